"""Goods to person: the model as its robots drive it, visit by visit, and its estimate by line.

For `desim check` and `desim why`, if a model has pods.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from desim_warehouse.errors import number_of
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.feasibility.parts import PileOn, StationLoad
from desim_warehouse.feasibility.power import Power
from desim_warehouse.findings import Finding, amount
from desim_warehouse.model import Model
from desim_warehouse.model.facts.demand import arrival_rate, asked_until, flow_rates, open_share, orders_of
from desim_warehouse.model.facts.places import specs
from desim_warehouse.model.sections.flows import (
    Batch,
    FlowSpec,
    OrdersArrivals,
    PoissonArrivals,
    ProfileArrivals,
    SaturatedArrivals,
    ScheduleArrivals,
    StorageEnd,
)
from desim_warehouse.model.sections.pods import PodsSpec
from desim_warehouse.values.distributions import mean_of
from desim_warehouse.values.fields import parts_in

TO_SPARE = 2
"""Pods bound for a picker beyond those that keep it busy, as a reserve for random arrivals."""
_ROUNDING = 1e-9
"""Relative error of units that are calculated from rates."""


def pile_on(model: Model, few: float, many: float) -> PileOn:
    """Return the work of pickers, with the measured numbers of lines at a visit of a pod."""
    pods = model.pods
    assert pods is not None
    rates = flow_rates(model)
    pick = math.fsum(rates[name] * mean_of(flow.stop_time) for name, flow in model.tasks.flows.items())
    pick /= math.fsum(rates.values())
    servers = sum(item.servers for item in model.floor.stations.values())
    return PileOn(few, many, model.policies.of_pods("pod").name, pick, pods.change_time, servers)


def driven(model: Model, lines: float = 1.0) -> Model:
    """Return the model as its robots drive it: a task is a visit of a pod to a station for some lines, and back.

    With one line it is the shortest possible visit. A flow to several stations becomes one flow for each of them. Its
    arrivals stay those of lines, as schedules have whole numbers, and `tasks.demand` makes them visits.
    """
    if model.pods is None:
        return model
    flows = {}
    for name, flow in model.tasks.flows.items():
        nodes = stations_of(flow)
        time = lines * mean_of(flow.stop_time) + (model.pods.change_time if lines > 1 else 0.0)
        visits = _arrivals(model, flow, flow.mean_lines / len(nodes))
        changes = {"from": "storage", "to": "storage", "lines": 1, "stop_time": time, "arrivals": visits}
        for rank, node in enumerate(nodes):
            flows[f"{name} {node}" if rank else name] = {**flow.content(), **changes, "via": [node]}
    demand = 1.0 if arrival_rate(model) is None else model.tasks.demand / lines
    several = {f"fleet.kinds.{name}.capacity": None for name, kind in model.fleet.kinds.items() if kind.capacity}
    tasks = {"tasks.flows": flows, "tasks.demand": demand, "tasks.popularity": "uniform"}
    return model.replace({"pods": None, **tasks, "fleet.robot.capacity": 1, **several})


def stations_of(flow: FlowSpec) -> tuple[str, ...]:
    """Return the nodes to which pods are brought for a flow."""
    nodes = flow.target if isinstance(flow.source, StorageEnd) else flow.source
    assert isinstance(nodes, tuple)
    return nodes


def _arrivals(model: Model, flow: FlowSpec, share: float) -> dict[str, Any]:
    """Return the arrivals of a flow, with all rates and numbers multiplied by `share`; numbers are rounded in sum."""
    when = flow.when
    if isinstance(when, PoissonArrivals):
        return {"poisson": when.poisson * share}
    if isinstance(when, ProfileArrivals):
        rates = [rate * share for rate in when.profile.per_hour]
        return {"profile": {**when.profile.content(), "per_hour": rates}}
    if isinstance(when, SaturatedArrivals):
        return {"saturated": when.saturated}
    if isinstance(when, OrdersArrivals):
        orders = orders_of(model, flow)
        when = ScheduleArrivals(schedule=(Batch(at=orders.last, tasks=orders.tasks),))
    batches = [{"at": time, "tasks": tasks} for time, tasks in when.times(share)]
    return {"schedule": [batch for batch in batches if batch["tasks"]] or [{**batches[-1], "tasks": 1}]}


def by_line(estimate: QuickEstimate, pile: PileOn, model: Model) -> QuickEstimate:
    """Return the estimate by line instead of by visit; pickers limit the stations."""
    most = pile.many
    cycle = replace(estimate.cycle, **{part: value / most for part, value in vars(estimate.cycle).items()})
    return replace(
        estimate,
        cycle=cycle,
        rate=arrival_rate(model),
        peak=None if estimate.peak is None else estimate.peak * most,
        charging=None if estimate.charging is None else estimate.charging / most,
        fleet_capacity=estimate.fleet_capacity * most,
        crossing_capacity=None if estimate.crossing_capacity is None else estimate.crossing_capacity * most,
        stations=_pickers(model),
        lifts=tuple(replace(lift, share=lift.share / most, crowd=None) for lift in estimate.lifts),
        power=None if estimate.power is None else _of_line(estimate.power, most),
        pile_on=pile,
    )


def _pickers(model: Model) -> tuple[StationLoad, ...]:
    """Return the load of each station in lines; the lines of a flow are shared evenly among its stations."""
    spec_of, rate = specs(model, model.floor), arrival_rate(model)
    lines, time = defaultdict[str, float](float), defaultdict[str, float](float)
    for name, count in flow_rates(model).items():
        flow = model.tasks.flows[name]
        for node in (nodes := stations_of(flow)):
            lines[node] += count / len(nodes)
            time[node] += count / len(nodes) * mean_of(flow.stop_time)
    every, loads = math.fsum(lines.values()), []
    for node, count in lines.items():
        spec = spec_of[node]
        part, share = open_share(model, spec.hours), count / every
        most = part * spec.servers * count / time[node] if time[node] else math.inf
        busy = None if rate is None or not most else rate * share / most
        loads.append(StationLoad(node, share, spec.servers, most, busy, open=part, handling="picking"))
    return tuple(loads)


def _of_line(power: Power, most: float) -> Power:
    kinds = {kind: _of_line(balance, most) for kind, balance in power.kinds.items()}
    return replace(power, task=power.task / most, share=power.share / most, kinds=kinds)


# Probable mistakes in a model with pods


def warnings(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    """Find probable mistakes in a model with pods, by its quick estimate by line."""
    if estimate.pile_on is None:
        return
    yield from _not_read(model)
    yield from _stock(model, estimate)
    yield from _robots(model, estimate, estimate.pile_on)


def _not_read(model: Model) -> Iterator[Finding]:
    """Find keys that are read only in a model without pods."""
    popularity = "pods.popularity: which items are asked for"
    if model.tasks.popularity != "uniform":
        text = "with pods a line asks for an item, not for a storage place"
        yield Finding("CHANGES_NOTHING", "tasks.popularity", text, popularity)
    for place, end in parts_in(model.tasks, (StorageEnd,)):
        if isinstance(end, StorageEnd) and end.popularity is not None:
            yield Finding("CHANGES_NOTHING", f"tasks.{place}.popularity", "with pods no place is drawn", popularity)
    if model.fleet.largest_capacity > 1:
        yield Finding("CHANGES_NOTHING", "fleet.robot.capacity", "a robot carries one pod at a time", "leave it out")


def _stock(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    """Find items that run out, as the run picks more of them than pods hold and receive."""
    pods, rates = model.pods, flow_rates(model)
    assert pods is not None
    stock = pods.units
    if stock is None or not estimate.rate:
        return
    net = sum(_taken(model, pods, flow, rates[name]) for name, flow in model.tasks.flows.items())
    worst = int((net - stock).argmax())
    if net[worst] > stock[worst] * (1 + _ROUNDING):
        text = f"in this run {amount(net[worst])} units of item {pods.name_of(worst)} are picked beyond what is put "
        text += f"onto pods, which hold about {amount(stock[worst])}: lines will wait without end"
        yield Finding("STOCK_RUNS_OUT", "pods.stock", text, "more stock, or a flow to storage that brings as much")


def _taken(model: Model, pods: PodsSpec, flow: FlowSpec, rate: float) -> Any:
    """Return how many units of each item a flow takes from pods in the run, less than 0 if it puts them onto pods.

    Rows of a file name their items; the items of other lines are drawn by popularity. The result is a numpy array.
    """
    each = -pods.bundle if isinstance(flow.target, StorageEnd) else 1
    if not isinstance(flow.when, OrdersArrivals):
        return each * rate * asked_until(model) / model.units.hour * pods.item_shares
    orders = orders_of(model, flow)
    lines = (orders.tasks - sum(orders.items.values())) * pods.item_shares
    for item, count in orders.items.items():
        lines[item] += count
    return each * model.tasks.demand * lines


def _robots(model: Model, estimate: QuickEstimate, pile: PileOn) -> Iterator[Finding]:
    """Find fewer robots than stations, pods that change in no time, and more pods at a station than pickers need."""
    nodes = {node for flow in model.tasks.flows.values() for node in stations_of(flow)}
    robots, stations = model.fleet.size, model.floor.stations
    if robots < len(nodes):
        text = f"{number_of(robots, 'robot')} for {number_of(len(nodes), 'station')}: some always wait for a pod"
        yield Finding("MORE_THAN_FIT", "fleet.size", text, "more robots, or fewer nodes in `to`")
    each = robots / len(nodes)
    zone = {node: f"layout.stations.{stations[node].zone}.places" for node in nodes}
    if not pile.change and each > 1 and any(stations[node].places > 1 for node in nodes):
        text = "pods queue at stations, and the next is in front of the picker in no time"
        yield Finding("UNUSUAL", "pods.change_time", text, "about 5 s, or what you measure")
    driving = (estimate.cycle.time - pile.pick) * pile.many - pile.change
    kept = 1 + driving / (pile.pick * pile.few + pile.change) if pile.pick else math.inf
    busy = estimate.rate is None or estimate.rate * pile.pick > pile.servers / 2
    for node in sorted(nodes) if busy else ():
        item = stations[node]
        bound, enough = min(item.places, each) / item.servers, math.ceil(kept) + TO_SPARE
        if bound > enough:
            text = f"up to {amount(bound)} pods are there or on their way for each picker, and {enough} keep it busy: "
            text += "each has fewer lines then, and fewer lines an hour may be done"
            yield Finding("PODS_QUEUE", zone[node], text, f"{enough * item.servers} places, or fewer robots")
            return
