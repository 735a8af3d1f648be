"""The quick estimate of a fleet's throughput, calculated from a probe of one robot of each kind.

For `desim check`, `desim new`, the live page, and the fleet with which the search of `desim plan` begins.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Any

from desim_warehouse.errors import ModelError
from desim_warehouse.feasibility.asked import most_loads
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.feasibility.hours import on_duty
from desim_warehouse.feasibility.parts import LiftLoad, MeanTask, StationLoad, mixed
from desim_warehouse.feasibility.peak import with_busiest_hour
from desim_warehouse.feasibility.pickers import picker_load
from desim_warehouse.feasibility.pods import by_line, driven, pile_on
from desim_warehouse.feasibility.power import power
from desim_warehouse.layout import Layout, checks
from desim_warehouse.layout.layout import Lift
from desim_warehouse.layout.zones import closed, zones_on
from desim_warehouse.model import Model
from desim_warehouse.model.facts.aisles import widened
from desim_warehouse.model.facts.demand import arrival_rate, open_share
from desim_warehouse.model.facts.disturbances import closures, disturbances, failing_lifts, ridden_lifts
from desim_warehouse.model.facts.lifts import left_for_robots, time_taken
from desim_warehouse.model.facts.peak import peak_rate
from desim_warehouse.model.facts.places import destinations, handling, slots, specs, worked_capacity
from desim_warehouse.model.facts.subfleets import flows_of, subfleets
from desim_warehouse.model.sections.goods import Popularity
from desim_warehouse.run.probe import Probe, calm, probe
from desim_warehouse.run.together import MOST_ROBOTS, TASKS, together
from desim_warehouse.states import Phase
from desim_warehouse.values.distributions import mean_of

BY_TIME = {"in-order", "earliest-due"}
"""Allocation policies that do not consider distance."""
BELOW, ABOVE = 0.07, 0.04
"""Relative deviations, down and up, of a long run from the probe of a fleet: fitted to `benchmarks.estimates`."""
ABOVE_WITH_PICKERS = 0.08
"""The upward deviation with pickers, whose positions at calls of robots vary more than those of robots."""
LEISURE = 4.0
"""Times as long as a task takes until the next one is known, where robots rest between them."""
LEAST_LESS = 0.01
"""The share of a task's time, or of its empty drive, from which an effect is reported."""
LEAST_LOADING = 0.05
"""The share of a task's time from which loading may block other robots."""
LEAST_WIDER = 0.05
"""The share of a fleet's tasks from which a gain by wide aisles is reported: measurements vary by half of it."""
WIDEST = 1.28
"""Times the least that the most is: charging takes no random times, as it is taken to, so that queues are shorter."""
PARTS = {
    Phase.TO_GOOD: "empty",
    Phase.LOADING: "load",
    Phase.TO_STATION: "loaded",
    Phase.UNLOADING: "unload",
}
"""The parts of a task that are reported separately."""


def estimate(model: Model, waiting: int | None = None) -> QuickEstimate:
    """Estimate the throughput of a fleet, from a model without errors; with pods a task is a line.

    `waiting`: tasks that an allocation may choose from; None: just as many that the next is always known.

    Raises:
        SimulationError: a robot by itself does none of the work.
    """
    return with_busiest_hour(model, _estimate(model, waiting))


def _estimate(model: Model, waiting: int | None = None) -> QuickEstimate:
    if model.pods is not None:
        paces = together(model, _known(model))
        pile = pile_on(model, *((1.0, 1.0) if paces is None else (paces.few.lines, paces.many.lines)))
        return by_line(_estimate(driven(model, pile.many), waiting), pile, model)
    layout, count, probes = model.floor, _robots_by_kind(model), _probes(model, waiting)
    of_kinds = {kind: _task(model, kind, probed) for kind, probed in probes.items()}
    cycle = mixed(of_kinds, count)
    rate, peak, places = arrival_rate(model), peak_rate(model), slots(model, layout)
    busy = min(places or model.fleet.size, sum(count.values()))
    balance = power(model, layout, cycle, of_kinds, rate, busy)
    charging = None
    if balance is not None and balance.charging_rate is not None and model.tasks.never_end:
        charging = balance.by_chargers * balance.task / balance.charging_rate
    unbroken = _unbroken(model)
    duty = on_duty(model) * unbroken
    total = cycle.time + (charging or 0.0)
    return QuickEstimate(
        *_extent(layout),
        model.units.metre,
        checks.room(layout, model.fleet.contact, closed(zones_on(layout, model.traffic.zones))),
        model.fleet.size,
        places,
        cycle,
        sum(probed.tasks for probed in probes.values()),
        rate,
        charging,
        sum(count.values()) * duty / total if total else math.inf,
        _stations(model, layout, probes, count, rate),
        *_crossing(model, probes),
        balance,
        model.traffic.most_out,
        None if peak is None else peak / model.units.hour,
        duty,
        unbroken=unbroken,
        lifts=_used_lifts(model, probes, count, rate),
        pickers=picker_load(model),
        subfleets=_subfleets(model, {kind: task.time + (charging or 0.0) for kind, task in of_kinds.items()}, duty),
    )


def _subfleets(model: Model, times: Mapping[str, float], duty: float) -> dict[str, float]:
    """Return the tasks per time unit that each subfleet can do by itself, by the time of a task of each kind.

    `duty`: the share of the run in which robots work.
    """
    kinds = model.fleet.kinds_of_robots()
    return {
        subfleet.name: duty * math.fsum(1 / times[kinds[robot]] for robot in subfleet.robots if times.get(kinds[robot]))
        for subfleet in subfleets(model)
    }


def measured(model: Model) -> QuickEstimate:
    """Estimate a model from the throughput that all its robots together have where work always waits (a probe).

    Charging is worked out: at the least robots queue for chargers as if they came at random, at the most not at all.

    Raises:
        SimulationError: a robot by itself does none of the work.
    """
    return with_busiest_hour(model, _measured(model))


def _measured(model: Model) -> QuickEstimate:
    quick = _estimate(model)
    paces = together(model, _known(model))
    if paces is None or model.fleet.size > MOST_ROBOTS or not 0 < quick.most < math.inf:
        return quick
    quick = replace(quick, lifts=_in_a_crowd(model, quick.lifts, paces.many.rides))
    bound, charging = quick.fleet_capacity * quick.round / quick.cycle.time, quick.charging or 0.0
    free = replace(quick, charging=None, power=None, fleet_capacity=bound)
    slow = quick.throughput_of_queues / free.throughput_of_queues
    slowest = [pace.rate * (1 - (1 - slow) * (1 - pace.free)) for pace in (paces.few, paces.many)]
    fastest = [min(pace.rate, model.fleet.size / (pace.work + charging)) for pace in (paces.few, paces.many)]
    more = ABOVE if model.pickers is None else ABOVE_WITH_PICKERS
    below, above = (BELOW, more) if model.fleet.size > 1 else (0.0, 0.0)  # nobody is in the way of one
    most = min([max(fastest) * quick.on_duty * (1 + above), *quick.other_limits.values()])
    least = min(max(min(slowest) * quick.on_duty * (1 - below), 0.0 if model.pods else most / WIDEST), most)
    likely = max(min((slowest[-1] + fastest[-1]) / 2 * quick.on_duty, most), least)
    capacity = max(quick.fleet_capacity, most if model.pods else 0.0)  # pods that are near save drives
    return replace(quick, fleet_capacity=capacity, measured=(least, likely, most), looked_at=TASKS)


def time_of_task(model: Model) -> float:
    """Return the mean time of a task of a model without pods, its next one always known, without charging."""
    tasks = {kind: _driven(probed) for kind, probed in _probes(model, None).items()}
    return mixed(tasks, _robots_by_kind(model)).time


def _robots_by_kind(model: Model) -> dict[str, int]:
    """Count the robots of each kind that do any tasks."""
    kinds = model.fleet.kinds_of_robots()
    return {kind: kinds.count(kind) for kind in kinds if not model.tasks.flows or flows_of(model, kind)}


def _probes(model: Model, waiting: int | None) -> dict[str, Probe]:
    return {kind: probe(model, kind, waiting or _known(model)) for kind in _robots_by_kind(model)}


@dataclass(frozen=True)
class Choice:
    """The effect of choosing tasks by distance: with `waiting` tasks to choose from, the empty drive takes `empty`."""

    policy: str
    waiting: int
    empty: float


def choice(model: Model, now: QuickEstimate) -> Choice | None:
    """Estimate the time saved by choosing tasks by distance; None if the policy does not, or hardly saves any.

    `now`: the estimate of the model, as measured.
    """
    allocation = model.policies.allocation
    if allocation.name in BY_TIME or allocation.own or model.pods is not None:  # a pod is called when a robot is free
        return None
    paces = together(model, _known(model))
    if paces is None or paces.many.empty >= now.cycle.empty * (1 - LEAST_LESS):
        return None
    return Choice(allocation.name, paces.waiting, paces.many.empty)


def _known(model: Model) -> int:
    """Return the number of tasks with which a robot always has a next task, or a whole tour of any flow."""
    loads = most_loads(model)
    return max(len(model.tasks.flows), 1) * (loads - 1) + loads


def _task(model: Model, kind: str, probed: Probe) -> MeanTask:
    """Return the parts of a task as probed, and if requested the parts of a task that no other follows."""
    if model.battery is None or arrival_rate(model) is None:
        return _driven(probed)
    known_tasks = _known(model)
    time, energy = calm(model, kind, known_tasks, LEISURE * known_tasks * probe(model, kind, known_tasks).time)
    return replace(_driven(probed), calm_time=time, calm_energy=energy)


def _driven(probed: Probe) -> MeanTask:
    parts = {part: probed.phases.get(phase, 0.0) for phase, part in PARTS.items()}
    other = probed.time - math.fsum(parts.values())
    return MeanTask(
        **parts, other=other if other > 1e-6 * probed.time else 0.0, energy=probed.energy, charging=probed.charging
    )


def _extent(layout: Layout) -> tuple[float, float]:
    points = list(layout.points.values())
    x, y = [point.real for point in points], [point.imag for point in points]
    return max(x) - min(x), max(y) - min(y)


def _unbroken(model: Model) -> float:
    """Return the availability of robots, the share of time in which they are not broken."""
    robots = model.fleet.robots()
    fails = [robot.breakdowns for robot in robots]
    left = [1.0 if f is None else mean_of(f.every) / (mean_of(f.every) + mean_of(f.repair)) for f in fails]
    return math.fsum(left) / len(left)


def _stations(
    model: Model, layout: Layout, probes: Mapping[str, Probe], count: Mapping[str, int], rate: float | None
) -> tuple[StationLoad, ...]:
    """Estimate each node where loads are handled, by how often and how long the robots of the probes were there.

    A node without a station serves one robot at a time, which clears it before the next comes.
    """
    robots, stations, loads = sum(count.values()), specs(model, layout), []

    def mean(node: str, values: Mapping[str, Mapping[str, float]]) -> float:
        return math.fsum(count[kind] * values_at.get(node, 0.0) for kind, values_at in values.items()) / robots

    done = handling(model, layout)
    shares = {
        kind: {node: share for node, (share, _) in values_at.visits.items()} for kind, values_at in probes.items()
    }
    times = {
        kind: {node: share * time for node, (share, time) in probed.visits.items()} for kind, probed in probes.items()
    }
    for node in destinations(model, layout):
        share = mean(node, shares)
        time = mean(node, times) / share if share else 0.0
        put = mean(node, {kind: probed.put_down for kind, probed in probes.items()})
        station = layout.stations.get(node)
        if station is None:
            serve = 1 / (time + model.tasks.clear_time) if time + model.tasks.clear_time else math.inf
            busy_at = None if rate is None else rate * share / serve
            loads.append(StationLoad(node, share, 1, serve, busy_at, handling=done.get(node, "unloading")))
            continue
        spec = stations[node]
        part = open_share(model, spec.hours)
        serve = part * station.servers / time if time else math.inf
        work = part * worked_capacity(spec) * share / put if put else math.inf
        busy = [None if rate is None or not limit else rate * share / limit for limit in (serve, work)]
        workers, doing = 0 if spec.work_time is None else spec.workers, done.get(node, "unloading")
        loads.append(StationLoad(node, share, station.servers, serve, busy[0], workers, work, busy[1], part, doing))
    return tuple(loads)


def _used_lifts(
    model: Model, probes: Mapping[str, Probe], count: Mapping[str, int], rate: float | None
) -> tuple[LiftLoad, ...]:
    """List the lifts used by robots of the probes, with rides; where robots would queue, also by their choice."""
    robots, rides = sum(count.values()), defaultdict[str, float](float)
    for kind, probed in probes.items():
        for edge, number in probed.rides.items():
            rides[edge] += count[kind] * number / robots
    loads = _lifts(model, rides)
    if rate is None or all(rate * load.share * load.time <= 1 for load in loads):
        return loads
    paces = together(model, _known(model))
    return loads if paces is None else _in_a_crowd(model, loads, paces.many.rides)


def _lifts(model: Model, ridden: Mapping[str, float]) -> tuple[LiftLoad, ...]:
    """List the lifts that are used, by the rides for each task along each of their edges.

    Where routes see queues, lifts to the same floors share the rides so that all are equally busy.
    """
    groups: dict[object, list[Lift]] = {}
    loads: dict[str, LiftLoad] = {}
    for lift in model.floor.lifts:
        groups.setdefault(_shared_by(model, lift), []).append(lift)
    for lifts in groups.values():
        ways = [list(permutations(lift.nodes, 2)) for lift in lifts]
        rides = [math.fsum(ridden.get(">".join(way), 0.0) for way in alike) for alike in zip(*ways, strict=True)]
        if not (share := math.fsum(rides)):
            continue
        times = [_time_in(model, lift, rides) for lift in lifts]
        does = [1 / time if time else 1.0 for time in times]
        for lift, time, each in zip(lifts, times, does, strict=True):
            loads[lift.name] = LiftLoad(lift.name, share * each / math.fsum(does), time / share)
    return tuple(loads[lift.name] for lift in model.floor.lifts if lift.name in loads)


def _shared_by(model: Model, lift: Lift) -> object:
    """Return the common key of lifts that share their rides: their floors, where routes see queues."""
    if model.policies.routing.name != "congestion-aware":
        return lift.name
    floors = tuple(model.floor.floors[node] for node in lift.nodes)
    return floors if len({*floors}) == len(floors) else lift.model_name


def _time_in(model: Model, lift: Lift, rides: Sequence[float]) -> float:
    """Return how long a lift is busy with so many rides each way, people and repairs included."""
    along = dict(zip(permutations(lift.nodes, 2), rides, strict=True))
    return time_taken(model, lift, along) / left_for_robots(model, lift)


def _in_a_crowd(model: Model, alone: Sequence[LiftLoad], rides: Mapping[str, float]) -> tuple[LiftLoad, ...]:
    """Return the loads of lifts with what robots that choose among many tasks ride for each of them."""
    crowd = {load.name: load.share * load.time for load in _lifts(model, rides)}
    return tuple(replace(load, crowd=crowd.get(load.name)) for load in alone)


def _crossing(model: Model, probes: Mapping[str, Probe]) -> tuple[str | None, float | None]:
    """Return the intersection that a task keeps busy longest, and the tasks per time unit that it lets through.

    Robots that follow each other over a node do so at least D / speed + node time apart.
    """
    headway, times = model.fleet.contact / model.fleet.fastest, dict(model.traffic.node_times)
    busy = {
        node: passed * (headway + times.get(node, model.traffic.node_time))
        for node, passed in next(iter(probes.values())).passages.items()
        if passed and node not in model.traffic.free_nodes
    }
    node = max(busy, key=busy.__getitem__, default=None)
    return (None, None) if node is None else (node, 1 / busy[node])


# Causes left out of the estimate, and gains of other layouts


UNKNOWN = "; estimates leave this out"
WAITS_LEFT_OUT = "; estimates count the time that is left, not the waits"
WAITS_OF_FLEET = "; estimates of batteries leave these waits out"


def left_out(model: Model, layout: Layout) -> list[str]:
    """List the causes that keep robots or chargers from work at times, and what the estimate leaves out."""
    has_battery = model.battery is not None
    with_people = WAITS_LEFT_OUT if model.fleet.size > MOST_ROBOTS else WAITS_OF_FLEET if has_battery else ""
    shared = [f"{text}{WAITS_LEFT_OUT}" for text in failing_lifts(model, layout)]
    shared += [f"{text}{with_people}" for text in ridden_lifts(model, layout)]
    lines = [*disturbances(model, layout), *(f"{text}{UNKNOWN}" for text in closures(model)), *shared]
    if model.fleet.breaks_down:
        draw = "draw energy while they are broken, and then" if has_battery else "that were broken"
        lines.append(f"robots {draw} begin anew what they did{UNKNOWN}")
    if model.fleet.has_hours or model.layout.has_hours:
        finishes = any(spec.hours is not None and spec.at_close == "finish" for spec in model.layout.stations.values())
        charge = ", and robots charge then, too" if has_battery else ""
        lines.append(
            f"robots {'and stations ' * finishes}finish after their hours what they began in them, up to one task more "
            f"for each in each opening{charge}{UNKNOWN}"
        )
    if model.pickers is not None and has_battery:
        lines.append(f"robots draw energy while they wait for pickers, which they do not foresee{UNKNOWN}")
    lines += [
        f"{name} is a policy of your own: the first of its kind is tried{UNKNOWN}" for name in model.policies.own()
    ]
    return lines


def nearer(model: Model) -> dict[str, Any]:
    """Return the overrides that put classes of fast movers nearest to the stations; none where nothing can be moved."""
    if model.pods is not None:
        return {}
    return {
        ".".join(("tasks", *keys, "by")): "distance"
        for keys, popularity in model.tasks.popularities()
        if isinstance(popularity, Popularity) and popularity.classes and popularity.by != "distance"
        if not any("." in key for key in keys)
    }


@dataclass(frozen=True)
class Nearer:
    """The time that a task takes less with fast movers nearer: `saved` of `now`, in time units; `keys` are changed."""

    saved: float
    now: float
    keys: tuple[str, ...]


def with_nearer(model: Model) -> Nearer | None:
    """Estimate how much less time a task takes with fast movers nearer; None where nothing is to be gained."""
    changes = nearer(model)
    try:
        moved = model.replace(changes) if changes else None
    except ModelError:  # no station is near
        return None
    if moved is None:
        return None
    now, then = map(time_of_task, (model, moved))
    return Nearer(now - then, now, tuple(changes)) if now - then >= LEAST_LESS * now else None


def in_wide_aisles(model: Model, now: QuickEstimate) -> float | None:
    """Measure the share of tasks that the fleet would do more if robots that load did not hold up others.

    The fleet is simulated as it is, and in wide aisles. The result is None if aisles are wide already, or next to
    nothing is to be gained.

    Args:
        model: a model without errors.
        now: its estimate.
    """
    if model.pods is not None or model.fleet.size == 1 or now.cycle.load < LEAST_LOADING * now.cycle.time:
        return None
    wide, more_edges = widened(model)
    if not more_edges:
        return None
    paces = [together(each, _known(model)) for each in (model, wide)]
    rates = [pace.many.rate for pace in paces if pace is not None]
    more = rates[1] / rates[0] - 1 if len(rates) == len(paces) else 0.0
    return more if more >= LEAST_WIDER else None
