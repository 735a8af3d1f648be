"""Suspects that may hold a warehouse up, for `desim why`: each with its dose, and its relief as keys of the model.

A delay that only one place has is an obstacle; a delay that all places have is work. So a crossing is relieved only of
the time that robots take there beyond other places: removing all its time would gain a little at each busy node of
every model with a node time. Waits before a crossing and time on it are one suspect, because removing the time ends the
waits too, and both intervals overlap wherever the queue is long.

Idle robots do not show that charging is irrelevant: below a threshold of 85 % they stand idle waiting for a charger.
Several policies form one suspect, since of two good policies neither would ever be shown to be better. The cost of
batches is read from log rows written when batches are made: the release of the last task of a tour would be wrong for a
time window, and for batches that wait for a robot.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import number_of
from desim_warehouse.feasibility.pods import stations_of
from desim_warehouse.model import Model
from desim_warehouse.model.facts.aisles import widened
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.model.facts.disturbances import breakdowns
from desim_warehouse.model.facts.places import destinations, ends_in_stations
from desim_warehouse.model.facts.workers import Kind, groups, staff
from desim_warehouse.model.sections.goods import PoissonGoods
from desim_warehouse.model.steady import evenly, from_files, opened, without_breaks
from desim_warehouse.outcome.account import UNTAKEN, share_of_tasks
from desim_warehouse.outcome.chains import Root, lost_to
from desim_warehouse.policies import catalogue
from desim_warehouse.run import RunData
from desim_warehouse.run.quick import nearer
from desim_warehouse.states import (
    BROKEN,
    CHARGER,
    CLOSED_LANE,
    IN_LIFT,
    OPENING,
    PACKING,
    PERSON_AHEAD,
    PICKER,
    SERVER,
    SHOWN,
    Phase,
    Queue,
    names,
)
from desim_warehouse.study.fleet import Designs
from desim_warehouse.study.fleet.capped import KEY, caps, waits_much
from desim_warehouse.study.possible import refused
from desim_warehouse.values.distributions import mean_of, scaled

if TYPE_CHECKING:
    import pandas as pd

DOSE = 0.1
"""The common dose: the share of a capacity, or of the work, by which gains are compared."""
MOST_UNTAKEN = 0.1
"""Part of their time that tasks may wait to be taken up without robots being scarce."""
MOST_NODES = 5
"""Number of intersections to look at: the ones with the most waiting before them."""
LEAST_WAITING = 0.002
"""Part of the fleet's time that must be waited before an intersection for it to be looked at."""
LEAST_HELD_UP = 0.01
"""Part of the fleet's time that must be waited behind robots that load for wide aisles to be looked at."""
MOST_LANES = 3
"""Number of two-way lanes to look at one by one: the lanes on which robots spend most time."""
ROUNDING = 1e-9
CLEARED = 120.0
"""Seconds after which a broken robot is off the lanes, as a relief."""
_LIMITS = ("speed", "speed_back")
SOONER, FEWER = 0.1, 0.05
"""Parts by which handling times and demand are less."""
LEAST_CHARGING = 0.05
"""Part of the fleet's time on chargers from which the charging policy is looked at, where tasks wait for robots."""
HALF = 0.5
LEAST_LOADED = "least-loaded"
"""The chargers with the fewest robots for each, as a charging policy chooses them."""
DECISIONS = {"pod": "pods called by", "order_station": "orders to stations by"}
"""Decisions that move the lines for each visit of a pod; where pods are stored hardly does."""
AT_PLACES = names(lambda state: state.phase in (Phase.LOADING, Phase.UNLOADING) or state.queue == PICKER)
"""In which a robot stands in its lane at a storage place, unless the aisle is wide."""


@dataclass(frozen=True)
class Suspect:
    """A suspect that may hold the warehouse up: its name, and a relief in words and in keys of the model.

    `waited`: the share of the fleet's time that robots waited there in the analysed run; None if robots do not wait for
    it, as for handling. `dose`: the relief as a share of the present capacity, such as 1 for a second server; None if
    an obstacle is removed as a whole. `beside`: whether the suspect is the work itself, less of which always gains, so
    that it is not ranked. Several suspects may share a name, such as other policies.
    """

    name: str
    relief: str
    overrides: Mapping[str, Any]
    waited: float | None = None
    dose: float | None = None
    beside: bool = False

    @property
    def scale(self) -> float:
        """The factor that scales the gain to a common dose, 10 % of a capacity or of the work; 1 without a dose."""
        return 1.0 if self.dose is None else DOSE / abs(self.dose)


def suspects(run: RunData) -> list[Suspect]:
    """List the suspects of a run with `log: all`, first those that robots wait for longest.

    Raises:
        ReportError: a run with less in its log.
    """
    return [suspect for suspect in _all(run) if refused(run.model, suspect.overrides) is None]


def impossible(run: RunData) -> dict[str, str]:
    """Return the reliefs with which nothing can be simulated, each with the reason."""
    reasons = {suspect.relief: refused(run.model, suspect.overrides) for suspect in _all(run)}
    return {relief: reason for relief, reason in reasons.items() if reason is not None}


def left_out(run: RunData) -> list[str]:
    """List the reliefs that cannot be tried, each with the reason."""
    return [
        *(f"{relief}: {reason}" for relief, reason in impossible(run).items()),
        *(f"the same orders evenly: those of {name} come from a file" for name in from_files(run.model)),
    ]


def _all(run: RunData) -> list[Suspect]:
    model, nodes = run.model, run.account(by="node")
    whole = run.history.counted * model.fleet.size or 1.0
    stations = _stations(run)
    queued = {zone: _queued(nodes, SERVER, members) / whole for zone, members in stations.items()}
    closed = {zone: _queued(nodes, OPENING, members) / whole for zone, members in stations.items()}
    others = [
        *_intersections(run, nodes["before_intersection"] / whole, whole),
        *_servers(model, queued),
        *_chargers(model, _queued(nodes, CHARGER, list(nodes.index)) / whole),
        *_workers(model, queued),
        *_pickers(run),
        *_hours(model, closed),
        *_lifts(run),
        *_under_way(run),
        *_on_the_way(run),
        *_lanes(run),
        *_aisles(run),
        *_failures(run),
        *decisions(run),
        *of_pods(model),
    ]
    waiting = sorted(others, key=lambda suspect: -(suspect.waited or 0.0))
    return [*waiting, *_plain(model)]


def _intersections(run: RunData, before: pd.Series[float], whole: float) -> Iterator[Suspect]:
    """Yield nodes before which robots wait, or that they cross more slowly than others.

    `before`: the wait as a share of the fleet's time.
    """
    usual, own = run.model.traffic.node_time, dict(run.model.traffic.node_times)
    shafts = {node for lift in run.layout.lifts for node in lift.nodes}
    passages = run.nodes["passages"]
    longer = {
        node: max(time - usual, 0.0) * float(passages.get(node, 0.0)) / whole
        for node, time in own.items()
        if time > usual
    }
    spent = {str(node): float(share) + longer.get(str(node), 0.0) for node, share in before.items()}
    for node in sorted(spent, key=lambda node: -spent[node])[:MOST_NODES]:
        if spent[node] < LEAST_WAITING or "." in node or node in shafts:  # a name that cannot stand in a dotted key
            continue
        free, key = f"nobody waits at {node}", f"traffic.nodes.{node}"
        relief = f"{free} or is longer there than elsewhere" if node in longer else free
        as_others = {f"{key}.time": None} if node in longer else {}
        yield Suspect(f"intersection {node}", relief, {f"{key}.free": True, **as_others}, float(before[node]))


def _lifts(run: RunData) -> Iterator[Suspect]:
    """List faster lifts and further cabins, by the time that robots wait before lifts, for cabins, and ride in them.

    Routes that know no queues would take one cabin alone.
    """
    nodes = run.account(by="node")
    whole, routing = run.history.counted * run.model.fleet.size or 1.0, run.model.policies.routing
    for name, lift in run.model.layout.lifts.items():
        rows = nodes.loc[[node for cabin in run.layout.lifts if cabin.model_name == name for node in cabin.nodes]]
        spent = float((rows["before_intersection"] + rows[IN_LIFT]).sum()) / whole
        if spent < LEAST_WAITING or "." in name:
            continue
        key = f"layout.lifts.{name}"
        faster = {f"{key}.ride": HALF * lift.ride, f"{key}.doors": HALF * lift.doors}
        yield Suspect(f"lift {name}", f"lift {name} twice as fast", faster, spent, -HALF)
        more: dict[str, Any] = {f"{key}.cabins": lift.cabins + 1}
        relief = f"one cabin more beside lift {name}"
        if routing.name != "congestion-aware" and not routing.own:
            more["policies.routing"] = "congestion-aware"
            relief += ", routes by congestion-aware"
        yield Suspect(f"lift {name}", relief, more, spent, 1 / lift.cabins)


def _queued(nodes: pd.DataFrame, queue: Queue, members: list[str]) -> float:
    """Return the time for which robots queue for something at some nodes, by the account of time of `nodes`."""
    states = [state.name for state in SHOWN.values() if state.queue == queue and state.name in nodes]
    return sum(float(nodes[state][members].sum()) for state in states)


def _stations(run: RunData) -> dict[str, list[str]]:
    """Return the nodes of each station that was used and whose name can stand in a dotted key."""
    nodes_of: dict[str, list[str]] = {}
    for node in destinations(run.model, run.layout):
        if node in run.layout.stations:
            nodes_of.setdefault(run.layout.stations[node].zone, []).append(node)
    return {zone: nodes for zone, nodes in nodes_of.items() if "." not in zone}


def _of_station(model: Model, zone: str, kind: Kind) -> str:
    """Return the words for the servers or people of a station, as all answers have them."""
    people = kind == "people"
    return next(group.name for group in groups(model) if group.zone == zone and (group.kind == "people") == people)


def _servers(model: Model, queued: Mapping[str, float]) -> Iterator[Suspect]:
    """Yield servers of stations, one more at each node, and slots where they keep robots from working."""
    for zone, share in queued.items():
        station = model.layout.stations[zone]
        key = f"layout.stations.{zone}"
        more: dict[str, Any] = {f"{key}.servers": station.servers + 1}
        if station.places <= station.servers:
            more[f"{key}.places"] = station.servers + 1
        another = "a second" if station.servers == 1 else "another"
        relief = f"{another} {staff(model, zone)} at each {_place(zone)}"
        yield Suspect(_of_station(model, zone, "servers"), relief, more, share, 1 / station.servers)
    layout = model.floor
    used = ends_in_stations(model, layout) or [node for node in destinations(model, layout) if node in layout.stations]
    slots = sum(layout.stations[node].places for node in used)
    zones = {layout.stations[node].zone for node in used} & queued.keys()
    if zones and slots < model.fleet.size:
        more = {f"layout.stations.{zone}.places": model.layout.stations[zone].places + 1 for zone in sorted(zones)}
        relief = "one place more at each node of the stations"
        yield Suspect("places at the stations", relief, more, dose=len(used) / slots)


def _chargers(model: Model, queued: float) -> Iterator[Suspect]:
    """Yield a charger more, and those with the fewest robots where robots queue and chargers stand at several nodes."""
    designs, own = Designs(model), model.policies.charging
    if designs.zone is not None:
        more = designs.of_chargers(designs.today + 1)
        yield Suspect("chargers", "one charger more", more, queued, 1 / designs.today)
    apart = len(chargers_at(model, model.floor)) > 1
    if apart and queued >= LEAST_WAITING and not own.own and own.params.get("charger") != LEAST_LOADED:
        spread = {"policies.charging": {"name": own.name, **own.params, "charger": LEAST_LOADED}}
        yield Suspect("the choice of chargers", "each to the chargers with the fewest robots", spread, queued)


def _place(zone: str) -> str:
    """Return the words for a place of a zone at which its servers and people are."""
    return "station" if zone == PACKING else f"node of {zone}"


def _workers(model: Model, zones: Iterable[str]) -> Iterator[Suspect]:
    """Yield people who work on what robots put down, one more at each node, with room for what is in work."""
    for zone in zones:
        station, key = model.layout.stations[zone], f"layout.stations.{zone}"
        if station.work_time is not None:
            more = {f"{key}.workers": station.workers + 1}
            if station.buffer is not None:
                more[f"{key}.buffer"] = max(station.buffer, station.workers + 1)
            relief = f"one {'packer' if zone == PACKING else 'worker'} more at each {_place(zone)}"
            yield Suspect(_of_station(model, zone, "people"), relief, more, dose=1 / station.workers)


def _pickers(run: RunData) -> Iterator[Suspect]:
    """Yield people who walk to robots at storage places, one more, and how they share the work."""
    pickers = run.model.pickers
    if pickers is None:
        return
    waited = run.kpis["share_awaiting_picker"]
    yield Suspect("pickers", "one picker more", {"pickers.count": pickers.count + 1}, waited, 1 / pickers.count)
    if pickers.zones > 1:
        yield Suspect("zones of pickers", "pickers in all zones", {"pickers.zones": 1})
    if pickers.stay == "order":
        yield Suspect("picker who stays", "a picker free after each pick", {"pickers.stay": "pick"})
    elif pickers.call == "there":
        yield Suspect("calls of pickers", "pickers sent ahead", {"pickers.call": "ahead"})
    more = opened(run.model, [] if pickers.hours is None else [pickers.hours])
    if more > ROUNDING:
        yield Suspect("hours of pickers", "pickers always at work", {"pickers.hours": None}, dose=more)


def _hours(model: Model, closed: Mapping[str, float]) -> Iterator[Suspect]:
    """Yield opening hours of stations, shifts of robots, and breaks in either; the dose is the time gained."""
    breaks: dict[str | None, float] = {}
    for calendar, more, changes in without_breaks(model):
        breaks[calendar] = more
        yield Suspect(f"breaks in {calendar}", f"no breaks in {calendar}", changes, dose=more)
    for zone, share in closed.items():
        key = f"layout.stations.{zone}"
        hours = model.layout.stations[zone].hours
        more = opened(model, [hours])
        if more > breaks.get(hours, 0.0) + ROUNDING:
            always = {f"{key}.hours": None, f"{key}.at_close": "finish"}
            yield Suspect(f"hours of {zone}", f"{zone} always open", always, share, more)
    shifts = model.fleet.hours_of_robots()
    more = opened(model, shifts)
    if more > (breaks.get(shifts[0], 0.0) if len(set(shifts)) == 1 else 0.0) + ROUNDING:
        always = {"fleet.hours": None, **dict.fromkeys(_of_kinds(model, "hours"))}
        yield Suspect("shifts of robots", "robots always at work", always, dose=more)


def _under_way(run: RunData) -> Iterator[Suspect]:
    """Yield caps on the robots under way, where they wait for each other for much of their time."""
    if waits_much([run.kpis]):
        for most in caps(run.model):
            yield Suspect("robots under way", f"at most {number_of(most, 'robot')} under way", {KEY: most})


def _waited(run: RunData, part: str) -> float:
    """Return the share of the fleet's time that robots waited for one thing, waits behind others included."""
    whole = run.history.counted * run.model.fleet.size
    return float(run.account(by="robot")[part].sum()) / whole if whole else 0.0


def _on_the_way(run: RunData) -> Iterator[Suspect]:
    """Yield closures, slow zones, rules of zones, speed limits, and people in the aisles."""
    traffic = run.model.traffic
    if traffic.closures:
        yield Suspect("closures", "nothing closed", {"traffic.closures": {}}, _waited(run, CLOSED_LANE))
    if traffic.slow:
        yield Suspect("zones that are slow", "nothing slow", {"traffic.slow": {}})
    if traffic.zones:
        yield Suspect("zones with a rule", "no rule in any zone", {"traffic.zones": {}})
    edges = enumerate(run.model.layout.edges)
    limits = {f"layout.edges.{rank}.{key}": None for rank, edge in edges for key in _LIMITS if getattr(edge, key)}
    if limits:
        yield Suspect("limits of speed", "no speed limits on lanes", limits)
    if run.model.people:
        yield Suspect("people in the aisles", "nobody in the aisles", {"people": {}}, _waited(run, PERSON_AHEAD))


def _lanes(run: RunData) -> Iterator[Suspect]:
    """Yield two-way lanes, each relieved by two lanes side by side; ranked by use, as robots wait far from them."""
    spent = run.account(by="edge").sum(axis=1)
    used: dict[frozenset[str], tuple[float, int]] = {}
    for rank, edge in enumerate(run.model.layout.edges):
        ends = edge.source, edge.target
        if run.layout.graph.edges[ends]["two_way"]:
            used.setdefault(frozenset(ends), (float(spent[">".join(ends)] + spent[">".join(ends[::-1])]), rank))
    edges = run.model.layout.edges
    beside = {
        rank: {
            **{
                key: value
                for key, value in edges[rank].content().items()
                if value is not False and (key, value) != ("against", 1)
            },
            "side_by_side": True,
        }
        for _, rank in used.values()
    }
    busiest = sorted(((time, rank) for time, rank in used.values() if time), key=lambda item: (-item[0], item[1]))
    for _, rank in busiest[:MOST_LANES]:
        name = f"{edges[rank].source} - {edges[rank].target}"
        yield Suspect(f"two-way lane {name}", f"two lanes for {name}", {f"layout.edges.{rank}": beside[rank]})
    if len(busiest) > 1:
        every = {f"layout.edges.{rank}": edge for rank, edge in beside.items()}
        relief = f"two lanes for each of {len(every)} two-way lanes"
        yield Suspect("two-way lanes", relief, every, dose=DOSE * len(busiest))


def _aisles(run: RunData) -> Iterator[Suspect]:
    """Yield wide aisles, where robots that load in their lanes hold up others for much of their time."""
    model = run.model
    if model.pods is not None:
        return
    _, more_edges = widened(model)
    in_lanes = {Root(state, ">".join(edge)) for state in AT_PLACES for edge in more_edges}
    waited = sum(time for root, (time, _) in lost_to(run.history).items() if root in in_lanes)
    share = waited / (run.history.counted * model.fleet.size or 1.0)
    if share >= LEAST_HELD_UP:
        yield Suspect("narrow aisles", "wide aisles, with robots beside the lanes", {"layout.aisles": "wide"}, share)


def _failures(run: RunData) -> Iterator[Suspect]:
    """Yield breakdowns of robots, delays at nodes, and outages of chargers and lifts."""
    model = run.model
    if model.fleet.breaks_down:
        never = dict.fromkeys(("fleet.robot.breakdowns", *_of_kinds(model, "breakdowns")))
        broken = sum(run.kpis[f"share_{state}"] for state in BROKEN)
        yield Suspect("breakdowns", "robots never break down", never, broken)
        long = CLEARED / model.units.seconds
        stand = {
            f"{key}.clear": long
            for key, spec in breakdowns(model).items()
            if spec.clear is None and mean_of(spec.repair) > long and not _dotted(model, key)
        }
        if stand:
            yield Suspect("breakdowns", "broken robots off the lanes after 2 min", stand)
    if any(robot.delays for robot in model.fleet.robots()):
        never = dict.fromkeys(("fleet.robot.delays", *_of_kinds(model, "delays")))
        yield Suspect("delays", "no delays at nodes", never)
    fail = [name for name, bay in model.layout.bays.items() if bay.outages is not None and "." not in name]
    if fail and model.battery is not None:
        never = {f"layout.bays.{name}.outages": None for name in fail}
        yield Suspect("outages of chargers", "chargers never fail", never)
    fail = [name for name, lift in model.layout.lifts.items() if lift.outages is not None and "." not in name]
    if fail:
        never = {f"layout.lifts.{name}.outages": None for name in fail}
        yield Suspect("outages of lifts", "lifts never fail", never)


def _dotted(model: Model, key: str) -> bool:
    """Whether the key belongs to a kind whose name cannot stand in a dotted key."""
    return any("." in name and key.startswith(f"fleet.kinds.{name}.") for name in model.fleet.kinds)


def _of_kinds(model: Model, key: str) -> list[str]:
    """List the kinds of robots that have a key of their own."""
    kinds = model.fleet.kinds.items()
    return [f"fleet.kinds.{name}.{key}" for name, kind in kinds if getattr(kind, key) is not None and "." not in name]


def _plain(model: Model) -> Iterator[Suspect]:
    """Yield suspects that robots do not wait for, though they may be the limit: fleet size, peaks, the work itself."""
    for kind, count in Counter(model.fleet.kinds_of_robots()).items():
        if "." in kind:
            continue
        more = {"fleet.size": model.fleet.size + 1}
        name, relief = "the number of robots", "one robot more"
        if kind:
            more[f"fleet.kinds.{kind}.count"] = count + 1
            name, relief = f"robots of kind {kind}", f"one robot of kind {kind} more"
        elif model.fleet.kinds:
            name, relief = "robots of no kind", "one more robot of no kind"
        yield Suspect(name, relief, more, dose=1 / count)
    if model.fleet.exit_time:
        yield Suspect("the way out of bays", "leaving bays at once", {"fleet.exit_time": 0}, dose=-1)
    if classes := nearer(model):
        yield Suspect("where items lie", "fast movers nearer", classes)
    even = evenly(model)
    if even:
        yield Suspect("peaks", "the same orders evenly", even)
    tasks = model.tasks
    sections = {
        "tasks": tasks,
        **{f"tasks.flows.{name}": flow for name, flow in tasks.flows.items() if "." not in name},
        **{f"layout.stations.{name}": part for name, part in model.layout.stations.items() if "." not in name},
    }
    shorter = {
        f"{section}.{key}": scaled(getattr(part, key), 1 - SOONER)
        for section, part in sections.items()
        for key in ("load_time", "unload_time")
        if getattr(part, key)
    }
    if shorter:
        relief = "loading and unloading a tenth shorter"
        yield Suspect("handling", relief, shorter, dose=-SOONER, beside=True)
    goods = tasks.goods
    less: dict[str, Any] = {}
    if isinstance(goods, PoissonGoods):
        less = {"tasks.goods": {**goods.content(), "poisson": goods.poisson * (1 - FEWER)}}
    elif tasks.arrive and tasks.has_rates:
        less = {"tasks.demand": tasks.demand * (1 - FEWER)}
    if less:
        yield Suspect("demand", "5 % fewer orders", less, dose=-FEWER, beside=True)


# Decisions


def decisions(run: RunData) -> Iterator[Suspect]:
    """Yield each decision with another policy in its place."""
    model = run.model
    if model.policies.batching.name != "single":
        yield Suspect("batching", "every task by itself", {"policies.batching": "single"})
    if model.policies.interval:
        yield Suspect("the interval of decisions", "decisions at once", {"policies.interval": 0})
    if model.traffic.most_out is not None:
        yield Suspect("the cap on robots under way", "no cap on robots under way", {KEY: None})
    charging = sum(run.kpis[f"share_{name}"] for name in names(lambda state: state.phase is Phase.CHARGING))
    if charging >= LEAST_CHARGING and share_of_tasks(run.history, *UNTAKEN) > MOST_UNTAKEN:
        yield from _charging(model)


def _charging(model: Model) -> Iterator[Suspect]:
    """Yield the other built-in charging policies with their defaults, and the model's own without its parameters."""
    own, battery = model.policies.charging, model.battery
    for name in catalogue.OURS["charging"]:
        if name == own.name and not own.params:
            continue
        threshold = battery is not None and "threshold" in battery.model_fields_set
        if catalogue.problems("charging", name, {}) or (catalogue.reads_threshold(name, {}) and not threshold):
            continue  # it has no defaults
        yield Suspect("the charging policy", f"charging by {name}", {"policies.charging": name})


# Pods


def of_pods(model: Model) -> Iterator[Suspect]:
    """Yield the reliefs of a model with pods, none of a model without. Robots do not wait for any of them."""
    pods = model.pods
    if pods is None:
        return
    if pods.change_time:
        half = {"pods.change_time": HALF * pods.change_time}
        yield Suspect("the change of pods", "pods changed in half the time", half, dose=-HALF)
    flows = {name: flow for name, flow in model.tasks.flows.items() if "." not in name}
    shorter = {
        f"tasks.flows.{name}.stop_time": scaled(flow.stop_time, 1 - DOSE)
        for name, flow in flows.items()
        if flow.stop_time
    }
    if shorter:
        yield Suspect("picking", "a line picked in a tenth less time", shorter, dose=-DOSE, beside=True)
    if pods.orders:
        more = _tenth(pods.orders)
        relief = f"{more - pods.orders} more of {pods.orders} orders at each station"
        yield Suspect("orders at the stations", relief, {"pods.orders": more}, dose=more / pods.orders - 1)
    if pods.holds is None:
        more = _tenth(pods.per_pod)
        relief = f"{more - pods.per_pod} more of {pods.per_pod} items on each pod"
        yield Suspect("what pods hold", relief, {"pods.per_pod": more}, dose=more / pods.per_pod - 1)
    if pods.stock is not None:
        yield Suspect("stock", "stock without end", {"pods.stock": None})
    yield from _fewer_places(model)
    for kind, words in DECISIONS.items():
        now = model.policies.of_pods(kind).name
        for name in catalogue.OURS[kind]:
            if name not in {now, "random"}:
                yield Suspect(f"policies.{kind}", f"{words} {name}", {f"policies.{kind}": name})


def _tenth(count: int) -> int:
    return math.ceil(count * (1 + DOSE))


def _fewer_places(model: Model) -> Iterator[Suspect]:
    """Yield reliefs with fewer pods at a time at the stations, each for more lines, down to two pods.

    One of the two is picked, and one is on its way.
    """
    layout = model.floor
    used = [layout.stations[node] for flow in model.tasks.flows.values() for node in stations_of(flow)]
    least = {item.zone: item.places - 1 for item in used if item.places - 1 > item.servers and "." not in item.zone}
    if least:
        fewer = {f"layout.stations.{zone}.places": places for zone, places in least.items()}
        dose = -1 / max(least.values())
        yield Suspect("pods at the stations", "one place fewer at each node of the stations", fewer, dose=dose)
