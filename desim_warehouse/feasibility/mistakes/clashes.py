"""Keys that contradict each other: breaks and due times, closures and the run, calendars, fleet and floor.

For `desim check`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import combinations

from desim_warehouse.errors import number_of
from desim_warehouse.feasibility.asked import most_loads
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.feasibility.hours import nobody_at_work
from desim_warehouse.findings import Finding, amount
from desim_warehouse.layout import Layout
from desim_warehouse.layout.zones import edges_of
from desim_warehouse.model import Model
from desim_warehouse.model.facts.day_parts import time_of_day
from desim_warehouse.model.facts.demand import arrival_rate, demand, order_files
from desim_warehouse.model.facts.disturbances import at_times, never_in_run
from desim_warehouse.model.facts.places import destinations
from desim_warehouse.model.schema import reading
from desim_warehouse.model.sections.flows import (
    FlowSpec,
    OrdersArrivals,
    Profile,
    Rates,
    ScheduleArrivals,
    StorageEnd,
    mean_rate,
)
from desim_warehouse.model.sections.goods import PoissonGoods, SaturatedGoods
from desim_warehouse.model.sections.orders import summary
from desim_warehouse.values.calendars import DAY, Shifts, Stretch, Stretches, clock_of, seconds_of, without
from desim_warehouse.values.fields import parts_in

LONGEST_BREAK = 6 * 3600.0
"""Seconds; a longer break was probably meant the other way round."""
MINUTE = 60.0
MOST_NAMED = 5
"""Most nodes of stations that a message names."""

BESIDE = 0.1
"""Least free width on either side of a robot in an aisle, in metres; where people walk, rules require half a metre."""
EPS = 1e-9


def warnings(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find times that contradict each other."""
    for name, calendar in model.calendars.items():
        if isinstance(calendar, Shifts):
            yield from _shifts(f"calendars.{name}", calendar)
        elif isinstance(calendar, Stretches) and _overlap(calendar.between):
            yield _overlapping(f"calendars.{name}.between")
    yield from _never(model)
    yield from _riders(model, layout)
    yield from _orders(model)
    if math.isfinite(model.run.end):
        yield from _breaks(model)
        yield from _due(model)


def notes(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find times that may be meant as they are."""
    yield from after_last_departure(model)
    yield from _profiles(model)
    yield from _closed_goods(model, layout)


# One calendar


def _shifts(place: str, shifts: Shifts) -> Iterator[Finding]:
    opened, breaks = list(map(seconds_of, shifts.open)), list(map(seconds_of, shifts.breaks))
    if _overlap(opened):
        yield _overlapping(f"{place}.open")
    if _overlap(breaks):
        yield _overlapping(f"{place}.breaks")
    for rank, (begin, end) in enumerate(breaks):
        days = [(begin + day, end + day) for day in (-DAY, 0.0, DAY)]
        where = f"{place}.breaks.{rank}"
        if without(opened, days) == opened:
            text = f"{shifts.breaks[rank]} is outside what is open ({', '.join(shifts.open)}), so it takes nothing out"
            yield Finding("CALENDAR_SLIP", where, text, "a break within the opening hours")
        elif end - begin > LONGEST_BREAK:
            first, _, last = shifts.breaks[rank].partition("-")
            text = f"{shifts.breaks[rank]} is a break of {amount((end - begin) / 3600)} h"
            yield Finding("CALENDAR_SLIP", where, text, f"did you mean {last.strip()}-{first.strip()}?")


def _overlap(stretches: Iterable[Stretch]) -> bool:
    return any(a < d and c < b for (a, b), (c, d) in combinations(sorted(stretches), 2))


def _overlapping(place: str) -> Finding:
    text = "stretches overlap; where they do, it is open (or closed) as in one of them"
    return Finding("CALENDAR_SLIP", place, text, "stretches that follow one another, or two calendars")


# Events that never come


def _never(model: Model) -> Iterator[Finding]:
    end, unit = model.run.end, model.units.time
    ends = f"the run ends at {amount(end)} {unit}"
    for place, (what, calendar) in at_times(model).items():
        if never_in_run(model, calendar):
            text = f"never {what} in this run: calendar '{calendar}' does not open in it"
            yield Finding("NEVER_IN_RUN", f"{place}.hours", text, _other_times(model, calendar))
    for name, people in model.people.items():
        if people.hours is not None and never_in_run(model, people.hours):
            text = f"nobody comes in this run: calendar '{people.hours}' does not open in it"
            yield Finding("NEVER_IN_RUN", f"people.{name}.hours", text, _other_times(model, people.hours))
        if people.times and min(people.times) >= end:
            text = f"the first visit is at {amount(min(people.times))} {unit}, and {ends}"
            yield Finding("NEVER_IN_RUN", f"people.{name}.times", text, f"times in {unit}, or a longer run")
    for name, flow in model.tasks.flows.items():
        if isinstance(flow.when, ScheduleArrivals):
            late = sum(batch.tasks for batch in flow.when.schedule if batch.at >= end)
            if late:
                text = f"{late} of {sum(batch.tasks for batch in flow.when.schedule)} tasks come later: {ends}"
                place = f"tasks.flows.{name}.arrivals.schedule"
                yield Finding("NEVER_IN_RUN", place, text, "a longer run")
    late_files = [file for file in order_files(model) if file.last >= end]
    if late_files and not any(flow.never_ends for flow in model.tasks.flows.values()):
        text = f"orders are released until {amount(max(file.last for file in late_files))} {unit}, and {ends}"
        yield Finding("NEVER_IN_RUN", "run.length", text, "a longer run, or fewer rows")


def _other_times(model: Model, calendar: str) -> str:
    return f"other times in calendars.{calendar}, another run.start ({model.run.start}), or a longer run"


# Files of orders


def _orders(model: Model) -> Iterator[Finding]:
    """Find orders in a file that lead the opposite way of their flow, and release times that look like days."""
    how = None
    for name, flow in model.tasks.flows.items():
        if not isinstance(flow.when, OrdersArrivals) or flow.source is None:
            continue
        how = how or reading(model, model.floor)
        file, place = summary(flow.when.orders, how), f"tasks.flows.{name}.arrivals.orders"
        from_storage, to_storage = isinstance(flow.source, StorageEnd), isinstance(flow.target, StorageEnd)
        turned = file.stored if from_storage and not to_storage else file.fetched if to_storage else 0
        if turned and from_storage != to_storage:
            other, side = ("to", "from") if from_storage else ("from", "to")
            text = f"the flow leads {side} storage, and {turned:,} of {number_of(file.rows, 'row')} lead {other} it"
            yield Finding("ENDS_SWAPPED", place, text, "from and to of these rows the other way round, or another flow")
        if file.tasks > 1 and 0 < file.last * model.units.seconds < MINUTE and model.units.has_seconds:
            text = f"all orders are released within {amount(file.last)} {model.units.time}"
            cure = "times of day (08:15), or numbers in the model's unit; sheets may have them as parts of a day"
            yield Finding("UNUSUAL", place, text, cure)


# Due times


def _within(model: Model) -> list[tuple[str, str, float, str | None]]:
    """Return the times until tasks are due: key, flow, time, and the calendar by which these tasks come."""
    goods = model.tasks.goods
    if isinstance(goods, PoissonGoods | SaturatedGoods):
        hours = goods.hours if isinstance(goods, PoissonGoods) else None
        return [] if goods.due_within is None else [("tasks.goods.due_within", "", goods.due_within, hours)]
    flows = model.tasks.flows.items()
    return [
        (f"tasks.flows.{name}.due_within", name, flow.due_within, flow.hours)
        for name, flow in flows
        if flow.due_within is not None
    ]


def _breaks(model: Model) -> Iterator[Finding]:
    """Find tasks that arrive in a break longer than the time until they are due, so that they must be late."""
    end, units = model.run.end, model.units
    who = "no robot works" if model.pickers is None else "no robot or no picker works"
    for place, flow, within, calendar in _within(model):
        hours, gaps = model.hours(calendar), list(nobody_at_work(model, flow))
        lost = [(a, b - within) for a, b in gaps if b - a > within]
        late = sum(hours.open_time(b) - hours.open_time(a) for a, b in lost)
        if late > 0:
            longest = max(b - a for a, b in gaps)
            first, whole, allowed = (units.lasts(time) for time in (longest - within, longest, within))
            share = late / hours.open_time(end)
            yield Finding(
                "BREAK_BEYOND_DUE",
                place,
                f"{who}, or no station is open, for up to {whole}; tasks that arrive in the first {first} of "
                f"this break cannot be done within {allowed}, with any fleet ({amount(100 * share)} % of the time)",
                "hours for the tasks, later due times, or robots with breaks at other times (fleet.kinds)",
            )


def _due(model: Model) -> Iterator[Finding]:
    """Find due times that no task can miss, and waits that make tasks miss them."""
    run, unit, policies = model.run, model.units.time, model.policies
    counted = run.end - run.warm_up
    for place, _, within, _ in _within(model):
        if within >= counted:
            text = (
                f"tasks are due after {amount(within)} {unit}, as long as the run is counted, {amount(counted)}: none "
                "that comes in the counted time falls due in it"
            )
            yield Finding("NEVER_LATE", place, text, f"due_within is in {unit}; or a longer run")
        waits = policies.batching.name in {"time-window", "by-order"}
        window = policies.batching.params.get("window") if waits else None
        for key, wait in (("batching.window", window), ("interval", policies.interval)):
            if isinstance(wait, int | float) and wait >= within:
                text = f"tasks may wait {amount(wait)} {unit} for it, and are due after {amount(within)}"
                yield Finding("WAITS_BEYOND_DUE", f"policies.{key}", text, f"a shorter one, in {unit}")
    for name, flow in model.tasks.flows.items():
        if flow.due_at:
            yield from _departures(model, f"tasks.flows.{name}.due_at", flow)


def _departures(model: Model, place: str, flow: FlowSpec) -> Iterator[Finding]:
    """Find departures that no task can miss, or that are probably meant as times of day."""
    run, unit, timetable = model.run, model.units.time, model.timetable(flow)
    by_clock = math.isfinite(timetable.period)
    last = timetable.last(run.end)
    if last is None:
        text = f"the first due time is {amount(timetable.times[0])} {unit}, and the run ends at {amount(run.end)}"
        cure = f"times in {unit} from the start of the run"
        if by_clock:
            text = f"no departure is in the run, which begins at {run.start} and lasts {model.units.lasts(run.end)}"
            cure = "other times, or a longer run"
        yield Finding("NEVER_LATE", place, text, cure)
    elif not by_clock and flow.never_ends and last < run.end / 2:
        text = f"tasks come until {amount(run.end)} {unit}, and those after {amount(last)} are never due"
        yield Finding("NEVER_LATE", place, text, f"times in {unit} from the start of the run, on to its end")
    if clock_of(run.start) and not by_clock and model.units.has_seconds:
        clocks = [time_of_day(model, time) for time in timetable.times]
        text = (
            f"{amount(timetable.times[0])} {unit} counts from the start of the run at {run.start}: that is {clocks[0]} "
            "by the clock"
        )
        due_at = ", ".join(f"'{clock}'" for clock in dict.fromkeys(clocks))
        yield Finding("DUE_CLOCK", place, text, f"by the clock, every day: due_at: [{due_at}], or as you mean it")


def after_last_departure(model: Model) -> Iterator[Finding]:
    """Yield for each flow the number of orders after the run's last departure, which no share on time counts."""
    run, hour = model.run, model.units.hour
    for name, flow in model.tasks.flows.items():
        timetable = model.timetable(flow)
        last = timetable.last(run.end) if math.isfinite(run.end) else None
        if last is None:
            continue

        def asked(until: float, flow: FlowSpec = flow) -> float:
            rate = mean_rate(flow, until, hour, run.start, model.hours(flow.hours)) if until > 0 else 0.0
            return (rate or 0.0) * until / hour * model.tasks.demand

        whole = asked(run.end)
        late = whole - asked(last - timetable.cut_off)
        if round(late):
            when = (
                f"{time_of_day(model, last)} by the clock"
                if math.isfinite(timetable.period)
                else f"{amount(last)} {model.units.time}"
            )
            text = f"about {late:,.0f} of {whole:,.0f} tasks come too late for the last departure of the run, {when}"
            yield Finding("LAST_DEPARTURE", f"tasks.flows.{name}.due_at", f"{text}: they count in no share on time")


# Times that may be meant


def _profiles(model: Model) -> Iterator[Finding]:
    end, hour = model.run.end, model.units.hour
    for place, part in parts_in(model.tasks, (Profile,)):
        assert isinstance(part, Profile)
        rates = model.rates(part)
        whole = rates.every * len(part.per_hour)
        if whole < end < math.inf and whole % (24 * hour):
            text = f"its rates last {amount(whole / hour)} h, the run {amount(end / hour)} h: they start again"
            yield Finding("PROFILE_REPEATS", f"tasks.{place}", text, "a rate for each part of the run")
        plain = _are_of_the_day(rates, model) if rates.by_clock else math.isclose(whole, end)  # or they are the run's
        if clock_of(model.run.start) and not plain:
            text = f"its rates cover {amount(whole / hour)} h, not a day: the first holds from the start of the run on"
            if rates.by_clock:
                text = "its rates cover 24 h and begin at midnight"
            text += f", and the run starts at {model.run.start}"
            if rates.by_clock:
                text += ": the rate of that hour comes first"
            yield Finding("PROFILE_CLOCK", f"tasks.{place}", text)


def _are_of_the_day(rates: Rates, model: Model) -> bool:
    """Whether rates plainly begin at midnight: by the clock orders begin as the run does, or as counting begins."""
    step, day = int(rates.phase / rates.every), 24 * model.units.hour
    return rates.rates[step] > 0 == rates.rates[step - 1] or math.isclose(rates.phase + model.run.warm_up, day)


def _riders(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find people who ride in lifts when no robot could: never in the run, or only while the lift is closed."""
    end = model.run.end
    for name, lift in model.layout.lifts.items():
        if lift.people is None or lift.people.hours is None:
            continue
        calendar, key = lift.people.hours, f"layout.lifts.{name}.people.hours"
        if never_in_run(model, calendar):
            text = f"nobody rides in this run: calendar '{calendar}' does not open in it"
            yield Finding("NEVER_IN_RUN", key, text, _other_times(model, calendar))
            continue
        for place, closure in model.traffic.closures.items() if math.isfinite(end) else ():
            shut, closed = model.hours(closure.hours), {n for edge in edges_of(layout, closure.members) for n in edge}
            robots_ride = len(set(lift.stops(name)) - closed) > 1
            if not robots_ride and all(
                shut.open_time(last) - shut.open_time(first) >= last - first - EPS
                for first, last in model.hours(calendar).between(0.0, end)
            ):
                text = f"they ride only while traffic.closures.{place} keeps robots out, so robots do not wait for them"
                yield Finding("CHANGES_NOTHING", key, text, "other hours, or no people")


def _closed_goods(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find storage places and stations of tasks that no robot can reach during a closure."""
    import networkx as nx

    if not model.traffic.closures:
        return
    share, whose = demand(model, layout), "visits to storage" if model.tasks.flows else "tasks"
    for name, closure in model.traffic.closures.items():
        if never_in_run(model, closure.hours):
            continue
        graph = layout.graph.copy()
        graph.remove_edges_from(edges_of(layout, closure.members))
        bays = next(iter(layout.bays), None)
        reached = set() if bays is None else {bays, *nx.descendants(graph, bays)}
        lost = [
            place.number
            for place in layout.storage
            if not any(
                edge[0] in reached and (edge[0] == edge[1] or edge in graph.edges)
                for edge, _ in layout.approaches(place.edge, place.offset)
            )
        ]
        part = sum(float(share[number]) for number in lost)
        places = f"{number_of(len(lost), 'storage place')}, with {amount(100 * part)} % of the {whose},"
        behind = [places] if part else []
        if cut_off := [node for node in destinations(model, layout) if node not in reached]:
            behind.append(f"{', '.join(cut_off[:MOST_NAMED])}{', ...' * (len(cut_off) > MOST_NAMED)}")
        if behind:
            then = "robots that are sent there wait before it, and hold up others"
            if closure.tasks == "hold":
                then = "tasks there wait until it opens"
            yield Finding(
                "CLOSED_GOODS",
                f"traffic.closures.{name}",
                f"closed {_how_long(model, closure.hours)}: {' and '.join(behind)} cannot be reached; {then}",
                "hours for these tasks, or other members",
            )


def _how_long(model: Model, calendar: str) -> str:
    """Return in words how long a calendar is open in a run."""
    hours, end = model.hours(calendar), model.run.end
    if math.isinf(end):
        return "at times"
    longest, whole = max(until - since for since, until in hours.between(0.0, end)), hours.open_time(end)
    once = model.units.lasts(whole)
    return once if longest >= whole else f"{once} of the run and up to {model.units.lasts(longest)} at a time"


# Too much for the floor or fleet


def crowds(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    """Find numbers too large to be used (robots, chargers, tasks in a batch), and unusual aisles and speeds."""
    fleet, batching = model.fleet, model.policies.batching
    out = min(fleet.size, model.traffic.most_out or fleet.size)
    if out > estimate.lanes_hold > 0:
        text = f"{out} robots, and the lanes hold {estimate.lanes_hold} at once: they would stand bumper to bumper"
        yield Finding("MORE_THAN_FIT", "fleet.size", text, "fewer robots, a longer floor, or traffic.most_out")
    size, most = batching.params.get("size"), fleet.largest_capacity
    if isinstance(size, int) and not batching.own and size > most > 1:
        text = f"tours of {size} loads, and a robot carries {most}: tours have {most}"
        yield Finding("MORE_THAN_FIT", "policies.batching.size", text, "fleet.robot.capacity, or a smaller size")
    yield from _too_small_for_tours(model)
    yield from _windows(model)
    yield from _aisles(model, estimate)
    yield from _chargers(model)
    yield from _pace(model)


def _too_small_for_tours(model: Model) -> Iterator[Finding]:
    """Find kinds of robots that carry less than any tour of their flows, which are made for the largest robots."""
    size, kinds, flows = most_loads(model), model.fleet.kinds_of_robots(), model.tasks.flows.values()
    if model.policies.batching.name != "fixed-size":
        return
    loads = {kind: robot.capacity for kind, robot in zip(kinds, model.fleet.robots(), strict=True)}
    able = [set(flow.kinds) & loads.keys() if flow.kinds else loads.keys() for flow in flows] or [loads.keys()]
    for kind, own in loads.items():
        tours = [min(size, max(loads[able_kind] for able_kind in doing)) for doing in able if kind in doing]
        if tours and min(tours) > own:
            text = f"it carries {number_of(own, 'load')}, and tours have {min(tours)} for larger robots: "
            text += f"{number_of(kinds.count(kind), 'robot')} of this kind never get one"
            place = f"fleet.kinds.{kind}.capacity" if kind else "fleet.robot.capacity"
            cure = f"at least {min(tours)}, flows with kinds of their own, or policies.batching.size: {own}"
            yield Finding("MORE_THAN_FIT", place, text, cure)


def _windows(model: Model) -> Iterator[Finding]:
    """Find batching windows in which mostly no second task comes, so that there is nothing to combine."""
    batching, rate, unit = model.policies.batching, arrival_rate(model), model.units.time
    window = batching.params.get("window")
    if batching.name == "time-window" and isinstance(window, int | float) and rate and window * rate < 1:
        text = f"in {amount(window)} {unit} {amount(window * rate)} tasks come on average: few go together"
        yield Finding("UNUSUAL", "policies.batching.window", text, f"a longer window; times are in {unit}")


def _aisles(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    """Find aisles that are hardly wider than a robot."""
    blocks = model.layout.blocks
    if blocks is None or estimate.metre is None:
        return
    width = 2 * max(robot.radius for robot in model.fleet.distinct())
    for key in ("aisle_width", "cross_aisle_width"):
        aisle = getattr(blocks, key)
        if aisle is not None and width <= aisle < width + 2 * BESIDE / estimate.metre * (1 - EPS):
            unit = model.units.length
            text = f"an aisle is {aisle:g} {unit} wide, a robot {amount(width)} (2 x its radius)"
            yield Finding("NARROW_AISLES", f"layout.blocks.{key}", text, "fleet.robot.radius is half of its width")


def _chargers(model: Model) -> Iterator[Finding]:
    """Find more chargers than robots, if the number of chargers is given."""
    layout, robots = model.floor, model.fleet.size
    nodes = {name: sum(bay.zone == name for bay in layout.bays.values()) for name in model.layout.bays}
    bays = model.layout.bays.items()
    chargers = sum(bay.total_chargers or (bay.chargers or 0) * nodes[name] for name, bay in bays)
    if model.battery is not None and chargers > robots:
        text = f"{number_of(chargers, 'charger')} for {number_of(robots, 'robot')}"
        yield Finding("MORE_THAN_FIT", "layout.bays", text, "chargers is at each node, total_chargers in all")


def _pace(model: Model) -> Iterator[Finding]:
    """Find robots that stop at every node although they accelerate, or that drive faster with a load."""
    robots, node_time = model.fleet.distinct(), model.traffic.node_time
    if node_time and any(robot.acceleration for robot in robots):
        text = (
            f"{amount(node_time)} {model.units.time} at every node beside an acceleration: robots stop at every node, "
            "and gather speed again"
        )
        yield Finding("STOPS_AT_NODES", "traffic.node_time", text, "node_time: 0, and turn_time for turns")
    for robot in robots:
        if robot.loaded_speed > robot.speed:
            text = f"{robot.loaded_speed:g} with a load, {robot.speed:g} without"
            yield Finding("FASTER_LOADED", "fleet.robot.speed_loaded", text, "a speed below fleet.robot.speed")
            return
