"""Hours of stations, robots and flows in an estimate: shares of time, and hours that leave no time for work.

For the quick estimate (`run.quick`), and for `desim check`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from statistics import fmean

from desim_warehouse.findings import Finding, amount
from desim_warehouse.layout import Layout
from desim_warehouse.layout.layout import Edge
from desim_warehouse.layout.zones import edges_of
from desim_warehouse.model import Model
from desim_warehouse.model.facts.demand import asked_until, orders_of
from desim_warehouse.model.facts.hours import STEPS
from desim_warehouse.model.facts.places import destinations, specs
from desim_warehouse.model.sections.flows import STORAGE, End, FlowSpec, OrdersArrivals, ScheduleArrivals
from desim_warehouse.model.sections.pickers import need_one
from desim_warehouse.values.calendars import ALWAYS, Hours, merged, repeat_together


def on_duty(model: Model) -> float:
    """Return the share of the run in which a robot can work, on average over the fleet.

    A robot can work in its hours while a station that tasks go to is open (tasks for closed stations are held back),
    and pickers are at work if every task needs one.
    """
    layout, end = model.floor, asked_until(model)
    spec_of = specs(model, layout)
    stations = [
        model.hours(spec_of[node].hours) if node in spec_of else ALWAYS for node in destinations(model, layout)
    ] or [ALWAYS]
    names = model.fleet.hours_of_robots()
    people = _of_pickers(model, model.tasks.flows)
    share = {name: _share_of_all(model.hours(name), people, stations, end) for name in set(names)}
    return fmean(share[name] for name in names)


def _of_pickers(model: Model, flows: Mapping[str, FlowSpec]) -> Hours:
    """Return the hours of pickers where every task of some flows needs one; always where some goes on without them."""
    pickers = model.pickers
    return model.hours(pickers.hours) if pickers is not None and need_one(pickers, flows) else ALWAYS


def _share_of_all(robot: Hours, pickers: Hours, stations: Sequence[Hours], end: float) -> float:
    """Return the share of the time in which a robot and pickers are at work and a station is open.

    A run without end is treated as in `Hours.share`.
    """
    if ALWAYS in stations and pickers is ALWAYS:
        return robot.share(0.0, end)
    time = together = 0.0
    for begin, time in _between_changes((robot, pickers, *stations), 0.0, end):
        both = robot.is_open(begin) and pickers.is_open(begin) and any(station.is_open(begin) for station in stations)
        if math.isinf(time):  # the last state lasts for ever; if nobody works in it, it does not count
            return together / begin if begin and not both else float(both)
        together += (time - begin) * both
    return together / time


def _between_changes(calendars: Sequence[Hours], time: float, end: float) -> Iterator[tuple[float, float]]:
    """Yield the intervals up to `end` between consecutive openings or closings of any calendar, at most `STEPS`."""
    for _ in range(STEPS):
        if not time < end:
            return
        begin, time = time, min(end, *(hours.changes(time) for hours in calendars))
        yield begin, time


def nobody_at_work(model: Model, flow: str = "") -> Iterator[tuple[float, float]]:
    """Yield the intervals of a run in which no task of a flow can be done; of goods where it has no name.

    No robot that does its tasks is on duty then, no station is open at one of their stops, or no pickers are at work,
    whom each of them needs.
    """
    spec, fleet = model.tasks.flows.get(flow), model.fleet
    kinds = zip(fleet.kinds_of_robots(), fleet.hours_of_robots(), strict=True)
    robots = {hours for kind, hours in kinds if spec is None or not spec.kinds or kind in spec.kinds}
    needed = [[model.hours(name) for name in names] for names in (robots, *_hours_of_stops(model, spec))]
    needed.append([_of_pickers(model, {} if spec is None else {flow: spec})])
    idle = [
        stretch
        for stretch in _between_changes([hours for group in needed for hours in group], 0.0, model.run.end)
        if not all(any(hours.is_open(stretch[0]) for hours in group) for group in needed)
    ]
    yield from merged(idle)


def _hours_of_stops(model: Model, flow: FlowSpec | None) -> list[set[str | None]]:
    """Return, for each stop of a flow's tasks, the calendars of its places; None: always open, as storage is.

    One place of every stop must be open.
    """
    layout, spec_of = model.floor, specs(model, model.floor)
    stops: list[list[End]] = [[destinations(model, layout)]]
    if flow is not None:
        stops = [[route.source for route in flow.routes], [route.target for route in flow.routes]]
        stops += [[layout.nodes_of(name)] for name in flow.via]
    nodes = [[node for end in ends for node in (end if isinstance(end, tuple) else [STORAGE])] for ends in stops]
    return [{spec_of[node].hours if node in spec_of else None for node in stop} for stop in nodes]


def errors(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find calendars that never open where they are used, and calendars of robots and stations that never overlap."""
    end = model.run.end
    never = {place for place, name in _used(model) if not model.hours(name).following(0.0)[0] < end}
    for place in sorted(never):
        name = dict(_used(model))[place]
        when = "" if math.isinf(end) else f" in the run, which lasts {model.units.lasts(end)}"
        yield Finding(
            "NEVER_OPEN",
            place,
            f"calendar '{name}' does not open{when}",
            f"other times in calendars.{name}, another run.start, or a longer run",
        )
    if not never:
        yield from _late_orders(model)
        yield from _never_meet(model, layout, end)


def _used(model: Model) -> list[tuple[str, str]]:
    """Return the keys of a model that name a calendar, each with the calendar's name."""
    layout, fleet, tasks = model.layout, model.fleet, model.tasks
    places = [(f"layout.stations.{name}.hours", station.hours) for name, station in layout.stations.items()]
    places += [(f"tasks.flows.{name}.hours", flow.hours) for name, flow in tasks.flows.items()]
    places += [("tasks.goods.hours", getattr(tasks.goods, "hours", None)), ("fleet.hours", fleet.hours)]
    places += [(f"fleet.kinds.{name}.hours", kind.hours) for name, kind in fleet.kinds.items()]
    if model.pickers is not None:
        places.append(("pickers.hours", model.pickers.hours))
    return [(place, name) for place, name in places if name is not None]


def _late_orders(model: Model) -> Iterator[Finding]:
    """Find schedules and files with tasks after the hours of their flow are over for good."""
    for name, flow in model.tasks.flows.items():
        if flow.hours is None:
            continue
        last = 0.0
        if isinstance(flow.when, ScheduleArrivals):
            last = max(batch.at for batch in flow.when.schedule)
        elif isinstance(flow.when, OrdersArrivals):
            last = orders_of(model, flow).last
        if math.isinf(model.hours(flow.hours).following(last)[0]):
            yield Finding(
                "NEVER_OPEN",
                f"tasks.flows.{name}.hours",
                f"tasks are asked for at {amount(last)} {model.units.time}, and calendar '{flow.hours}' does not "
                "open again after that",
                f"times in calendars.{flow.hours} that last as long",
            )


def _never_meet(model: Model, layout: Layout, end: float) -> Iterator[Finding]:
    """Find all places to which no robot can ever be sent, because one calendar or another is always in the way.

    A robot is sent when it is on duty, no closure that holds tasks back cuts the place off, and the station is open, or
    will be when the robot arrives.
    """
    holding = {name: spec for name, spec in model.traffic.closures.items() if spec.tasks == "hold"}
    fleet = model.fleet
    if not (model.layout.has_hours and fleet.has_hours) and not (
        holding and (model.layout.has_hours or fleet.has_hours)
    ):
        return
    spec_of = specs(model, layout)
    wanted = dict.fromkeys(destinations(model, layout))
    met, reachable = set[str](), set[str]()  # robots do not wait for a place that is cut off for ever
    seen = []
    for since, until, reached in _times(model, layout, end):
        seen.append(since)
        reachable.update(node for node in wanted if node in reached)
        if until is None:
            continue
        for node in reachable - met:
            spec = spec_of.get(node)
            opens = 0.0 if spec is None else model.hours(spec.hours).following(since)[0]
            if node in reached and opens < until:
                met.add(node)
        if met >= wanted.keys():
            return
    if len(seen) == STEPS and not _is_whole_course(model, seen[0], seen[-1]):
        return  # a later opening may be in time: the run waits for it
    for node in wanted:
        if node in met or node not in reachable:
            continue
        spec = spec_of.get(node)
        calendars = [f"{place}, '{name}'" for place, name in _used(model) if place.startswith("fleet.")]
        place = "fleet.hours"
        if spec is not None and spec.hours is not None:
            place = f"layout.stations.{layout.stations[node].zone}.hours"
            calendars.append(f"{place}, '{spec.hours}'")
        calendars += [f"traffic.closures.{name}.hours, '{closure.hours}'" for name, closure in holding.items()]
        text = "no robot is at work when the station is open, or just before"
        if holding:
            text = f"no robot is at work while there is an open way to {node}, and it is open itself"
            place = f"traffic.closures.{next(iter(holding))}.hours" if place == "fleet.hours" else place
        yield Finding(
            "HOURS_NEVER_MEET",
            place,
            f"{text} (these never meet: {'; '.join(calendars)})",
            "hours in which robots work, the ways are open and the station, too",
        )


def _times(model: Model, layout: Layout, end: float) -> Iterator[tuple[float, float | None, Collection[str]]]:
    """Yield the times at which calendars open or close, with the nodes that robots sent out then would reach.

    Before the nodes stands the time at which these robots have arrived, None if no robot is on duty. The first time is
    when the first flow has demand.
    """
    slowest = min(robot.speed for robot in model.fleet.distinct())
    edges = [data for *_, data in layout.graph.edges(data=True)]
    once_round = 10 * sum(data["length"] / slowest + data.get("takes", 0.0) for data in edges)
    robots, stations, closures = _in_the_way(model, layout)
    asked = [model.hours(flow.hours) for flow in model.tasks.flows.values()]
    asked += [model.hours(getattr(model.tasks.goods, "hours", None))] if model.tasks.goods is not None else []
    every = [*robots, *stations, *(hours for _, hours in closures)]
    reached_by_shut: dict[tuple[int, ...], Collection[str]] = {}
    first = min((hours.following(0.0)[0] for hours in asked), default=0.0)
    for time, until in _between_changes(every, first, end):
        shut = tuple(number for number, (_, hours) in enumerate(closures) if hours.is_open(time))
        if shut not in reached_by_shut:
            reached_by_shut[shut] = _reached(layout, [edge for number in shut for edge in closures[number][0]])
        works = any(hours.is_open(time) for hours in robots)
        yield time, min(until + once_round, end) if works else None, reached_by_shut[shut]


def _in_the_way(model: Model, layout: Layout) -> tuple[list[Hours], list[Hours], list[tuple[tuple[Edge, ...], Hours]]]:
    """Return the calendars of robots, of stations, and of closures that hold tasks back, with their edges."""
    robots = [model.hours(name) for name in dict.fromkeys(model.fleet.hours_of_robots())]
    stations = [model.hours(spec.hours) for spec in model.layout.stations.values()]
    closures = [
        (edges_of(layout, spec.members), model.hours(spec.hours))
        for spec in model.traffic.closures.values()
        if spec.tasks == "hold"
    ]
    return robots, stations, closures


def _is_whole_course(model: Model, begin: float, end: float) -> bool:
    """Whether all calendars in the way have repeated together between two times of a run."""
    robots, stations, closures = _in_the_way(model, model.floor)
    every = [*robots, *stations, *(hours for _, hours in closures)]
    return end >= max(begin, *(hours.repeats_from for hours in every)) + repeat_together(every, STEPS)


def _reached(layout: Layout, shut: Sequence[tuple[str, str]]) -> Collection[str]:
    """Return the nodes that can be reached from a bay without the edges that are shut."""
    if not shut or not layout.bays:
        return set(layout.graph)
    import networkx as nx

    graph = layout.graph.copy()
    graph.remove_edges_from(shut)
    return set(layout.bays).union(*(nx.descendants(graph, bay) for bay in layout.bays))
