"""Keys without effect, as no part of the model reads them.

For `desim check`, and for the live page.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from desim_warehouse.errors import spoken
from desim_warehouse.findings import Finding
from desim_warehouse.layout import Layout
from desim_warehouse.layout.spec import BaySpec
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import by_kind
from desim_warehouse.model.facts.demand import order_files
from desim_warehouse.model.facts.keys import whole_annotation
from desim_warehouse.model.facts.places import destinations
from desim_warehouse.model.sections.fleet import BatterySpec
from desim_warehouse.model.sections.flows import FlowSpec, StorageEnd
from desim_warehouse.model.sections.goods import Good, PoissonGoods, SaturatedGoods
from desim_warehouse.model.sections.policy import OF_PODS
from desim_warehouse.policies import catalogue
from desim_warehouse.values.calendars import Names
from desim_warehouse.values.fields import Part, parts_in


def warnings(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find keys that were surely given for a purpose, and have no effect."""
    unnamed = _unnamed_calendars(model)
    if len(unnamed) == len(model.calendars):
        for name in unnamed:
            text = "no robot, station, flow, closure or visit names it, so it changes nothing"
            yield Finding("CHANGES_NOTHING", f"calendars.{name}", text, f"hours: {name} where it should hold")
    yield from _priorities(model)
    yield from _by_order(model)
    yield from _handed_over_whole(model)
    yield from _same_ends(model)
    yield from _nothing_to_work_on(model, layout)
    if model.prices is not None and not (model.prices.any or model.prices.turned_aisle):
        text = "nothing has a price, so all costs are 0"
        yield Finding("CHANGES_NOTHING", "prices", text, "robot, charger, energy, station_hour or late_order")
    for name, zone in model.traffic.slow.items():
        if zone.speed >= model.fleet.fastest:
            text = f"no robot drives faster than {model.fleet.fastest:g} anyway"
            yield Finding("CHANGES_NOTHING", f"traffic.slow.{name}.speed", text, "a lower limit")


def _nothing_to_work_on(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find stations with a work time at which no load is ever put down."""
    flows = model.tasks.flows.values()
    if not flows or order_files(model):
        return
    ends = {node for flow in flows for route in flow.routes if isinstance(route.target, tuple) for node in route.target}
    for name, station in model.layout.stations.items():
        if station.work_time is not None and not {*layout.nodes_of(name)} & ends:
            text = "no flow leads there (to), so nothing is put down there to be worked on"
            yield Finding("CHANGES_NOTHING", f"layout.stations.{name}.work_time", text, f"to: {name}, not from")


def _same_ends(model: Model) -> Iterator[Finding]:
    """Find flows that lead from nodes to the same nodes."""
    for name, flow in model.tasks.flows.items():
        for route in flow.routes:
            if isinstance(route.source, tuple) and not flow.via and set(route.source) == set(route.target):
                ends = spoken(route.source)
                text = f"loads begin and end at {ends}: they stay where they are, or go back and forth"
                yield Finding("SAME_ENDS", f"tasks.flows.{name}", text, "from: storage, or where loads really go (to)")
                break


def notes(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find keys without effect here that may be meant for a variant of the model."""
    unnamed = _unnamed_calendars(model)
    if len(unnamed) < len(model.calendars):
        for name in unnamed:
            yield Finding("NOT_USED", f"calendars.{name}", "changes nothing here: nothing names it")
    for place, why in (*_of_batteries(model), *_of_work(model), *_stations(model, layout)):
        yield Finding("NOT_USED", place, f"changes nothing here: {why}")


# Names without a user


def _unnamed_calendars(model: Model) -> list[str]:
    if not model.calendars:
        return []
    used = {name for _, part in parts_in(model, (Part,)) for name in _names_in(part, "calendars")}
    return [name for name in model.calendars if name not in used]


def _names_in(part: Part, section: str) -> list[Any]:
    """Return the names in `section` to which the keys of a part refer; None for each key that is not set."""
    fields = type(part).model_fields.items()
    keys = [name for name, field in fields if _is_name(whole_annotation(field), section)]
    return [getattr(part, key) for key in keys]


def _is_name(annotation: Any, section: str) -> bool:
    notes = getattr(annotation, "__metadata__", ())
    if any(isinstance(note, Names) and note.of == section for note in notes):
        return True
    return any(_is_name(inner, section) for inner in getattr(annotation, "__args__", ()))


def _stations(model: Model, layout: Layout) -> Iterator[tuple[str, str]]:
    used_places = {*destinations(model, layout), *(name for file in order_files(model) for name in file.names)}
    for name in model.layout.stations:
        if not {name, *layout.nodes_of(name)} & used_places:
            yield f"layout.stations.{name}", "no task begins, stops or ends there"


# Keys that no policy reads


def _reads(model: Model, what: str) -> bool:
    """Return whether a policy looks at an attribute of tasks; the user's own policies may look at any.

    With pods only the policies of pods count: allocation chooses a robot for a visit, and no line.
    """
    specs = [item for item in model.policies.specs().items() if model.pods is None or item[0] in OF_PODS]
    return any(spec.own or what in getattr(catalogue.find(kind, spec.name), "reads", ()) for kind, spec in specs)


def _priorities(model: Model) -> Iterator[Finding]:
    if _reads(model, "priority"):
        return
    tasks = model.tasks
    goods = tasks.goods if isinstance(tasks.goods, tuple) else ()
    places = ["tasks.goods"] * any(isinstance(good, Good) and good.priority for good in goods)
    places += [f"tasks.flows.{name}.priority" for name, flow in tasks.flows.items() if flow.priority]
    places += ["tasks.flows"] * any(file.urgent for file in order_files(model))
    for place in places[:1]:
        if model.pods is None:
            decides = f"policies.allocation: {model.policies.allocation.name}"
            cure = "policies.allocation: earliest-due, or a policy of your own"
        else:
            decides = f"policies.pod: {model.policies.of_pods('pod').name}"
            cure = "policies.pod: one of your own, which chooses among the lines of a station"
        yield Finding("CHANGES_NOTHING", place, f"priorities are given, and {decides} does not look at them", cure)


def _by_order(model: Model) -> Iterator[Finding]:
    if model.policies.batching.name != "by-order" or model.fleet.largest_capacity == 1:
        return
    if any(flow.lines != 1 for flow in model.tasks.flows.values()):
        return
    if all(file.tasks == file.orders for file in order_files(model)):
        text = "by-order, but no two tasks are of one order, so every task is a tour of its own"
        cure = "lines of a flow, a file of orders with a column order (arrivals: {orders: ...}), or fixed-size"
        yield Finding("CHANGES_NOTHING", "policies.batching", text, cure)


def _handed_over_whole(model: Model) -> Iterator[Finding]:
    """Find orders that are to be handed over as a whole although no robot brings two of their lines at once."""
    if model.tasks.flows and model.fleet.largest_capacity > 1 and model.policies.batching.name != "single":
        return
    for name, flow in model.tasks.flows.items():
        if flow.unload_per == "order":
            text = "order, but no robot brings several lines at once, so each line takes the time by itself"
            cure = "fleet.robot.capacity, and policies.batching: by-order"
            yield Finding("CHANGES_NOTHING", f"tasks.flows.{name}.unload_per", text, cure)


def has_due(model: Model) -> bool:
    """Return whether any task has a due time."""
    goods = model.tasks.goods
    if isinstance(goods, tuple):
        return any(isinstance(good, Good) and good.due is not None for good in goods)
    if isinstance(goods, PoissonGoods | SaturatedGoods):
        return goods.due_within is not None
    flows = model.tasks.flows.values()
    return any(flow.due_within is not None or flow.due_at for flow in flows) or any(
        file.due for file in order_files(model)
    )


# Keys of something that the model lacks


def _of_batteries(model: Model) -> Iterator[tuple[str, str]]:
    charging, battery = model.policies.charging, model.battery
    if battery is not None:
        yield from _thresholds(model, battery)
        return
    none = "there is no battery"
    for place, bay in parts_in(model.layout, (BaySpec,)):
        assert isinstance(bay, BaySpec)
        for key in ("chargers", "total_chargers", "kinds"):
            if getattr(bay, key):
                yield f"layout.{place}.{key}", none
        if bay.outages is not None:
            yield f"layout.{place}.outages", none
    yield from ((f"fleet.kinds.{name}.charging", none) for name, kind in model.fleet.kinds.items() if kind.charging)
    if charging.content() != type(model.policies).model_fields["charging"].default.content():
        yield "policies.charging", none
    if model.fleet.start_energy != 1:
        yield "fleet.start_energy", none
    if model.prices is not None and model.prices.energy:
        yield "prices.energy", none


def _thresholds(model: Model, battery: BatterySpec) -> Iterator[tuple[str, str]]:
    """Find thresholds of batteries that no charging policy reads."""
    of_kinds = by_kind(model).items()
    named = [
        (
            "battery",
            battery,
            [kind_model.policies.charging for _, kind_model in of_kinds if kind_model.battery is battery],
        )
    ]
    for kind, alone in of_kinds:
        own = model.fleet.kinds[kind].battery if kind else None
        named += [(f"fleet.kinds.{kind}.battery", own, [alone.policies.charging])] if own is not None else []
    for place, spec, policies in named:
        read = any(catalogue.reads_threshold(policy.name, policy.params) for policy in policies)
        if "threshold" in spec.model_fields_set and policies and not read:
            yield f"{place}.threshold", f"policies.charging: {policies[0].name} goes by its own levels"


def _of_work(model: Model) -> Iterator[tuple[str, str]]:
    tasks, fleet = model.tasks, model.fleet
    if model.prices is not None and model.prices.late_order and not has_due(model):
        yield "prices.late_order", "no task has a due time, so that none is late"
    if tasks.popularity != "uniform" and not _draws_places(model):
        yield "tasks.popularity", "no storage place is drawn by it"
    if model.traffic.most_out is not None and model.traffic.most_out >= fleet.size:
        yield "traffic.most_out", f"there are no more than {fleet.size} robots"
    if not any(flow.load_type for flow in tasks.flows.values()):
        of_kinds = {f"fleet.kinds.{name}.carries": kind.carries for name, kind in fleet.kinds.items()}
        for place, carries in {"fleet.robot.carries": fleet.robot.carries, **of_kinds}.items():
            if carries:
                yield place, "no flow has a load_type"


def _draws_places(model: Model) -> bool:
    if isinstance(model.tasks.goods, tuple):
        return False
    flows = [part for _, part in parts_in(model.tasks, (FlowSpec,)) if isinstance(part, FlowSpec)]
    ends = [end for flow in flows for route in flow.routes for end in (route.source, route.target)]
    return not flows or any(isinstance(end, StorageEnd) and end.popularity is None for end in ends)
