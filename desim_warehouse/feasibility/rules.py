"""Findings by the quick estimate: dimensions, times and demand that cannot work or are probably mistakes.

For `desim check`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

from desim_warehouse.errors import number_of, spoken
from desim_warehouse.feasibility import at_once, hours, limit, of_kinds, rest, starts
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.feasibility.loads import loads
from desim_warehouse.feasibility.mistakes import clashes, magnitudes, unused
from desim_warehouse.feasibility.needs import WITH_LOAD, least_needs
from desim_warehouse.feasibility.parts import LiftLoad
from desim_warehouse.feasibility.slow_ways import slow_ways
from desim_warehouse.findings import Finding, amount
from desim_warehouse.layout import Layout
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import spare_batteries, swapped_at
from desim_warehouse.model.facts.lifts import called
from desim_warehouse.model.facts.places import specs
from desim_warehouse.model.sections.goods import PoissonGoods
from desim_warehouse.values.distributions import mean_of

FASTEST, SLOWEST = 3.0, 0.05
"""Usual range of the speeds of robots in warehouses, in m/s."""
LARGEST, SMALLEST = 2000.0, 2.0
"""Usual range of the sides of a warehouse, in metres."""
FEW = 30
"""Number of tasks below which a run is too short."""
SHORTEST = 1500.0
"""Evaluation period in seconds below which an endless run shows no pattern of a day, and hardly a queue."""
HOUR = 3600.0
_ROUNDING = 1e-9
"""Relative error of a measured share."""


def errors(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find the errors beyond the layout, for which `simulate` refuses a model."""
    yield from starts.errors(model, layout)
    yield from _width(model)
    yield from hours.errors(model, layout)
    if model.battery is not None:
        yield from of_kinds.errors(model, layout)
        yield from _spares(model, layout)


def warnings(model: Model, layout: Layout, estimate: QuickEstimate) -> Iterator[Finding]:
    """Find probable mistakes, by the quick estimate, that a planner should know."""
    yield from _nothing_to_drive(estimate)
    yield from _units(model, estimate)
    yield from _length(model, estimate)
    yield from _demand(model, estimate)
    yield from _due(model, layout)
    yield from _one_at_work(model, estimate)
    yield from slow_ways(model, layout)
    yield from _unused_lifts(model, layout, estimate)
    yield from _one_load(model)
    yield from _spread(model)
    if model.battery is not None:
        yield from of_kinds.warnings(model, layout, estimate.power)
        yield from at_once.warnings(model, estimate)
        yield from rest.warnings(model, layout, estimate)


def mistakes(model: Model, layout: Layout, estimate: QuickEstimate) -> Iterator[Finding]:
    """Find probable mistakes in a model as it is written, with pods not as its robots drive it."""
    yield from unused.warnings(model, layout)
    yield from magnitudes.warnings(model, estimate)
    yield from clashes.warnings(model, layout)
    yield from clashes.crowds(model, estimate)
    yield from unused.notes(model, layout)
    yield from magnitudes.notes(model)
    yield from clashes.notes(model, layout)


def _one_at_work(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    """Find a single slot at the stations, which keeps all robots but one in their bays."""
    if estimate.at_work != 1 or estimate.robots == 1:
        return
    hour = model.units.hour
    does, could = (
        amount(variant.capacity * hour) for variant in (estimate, replace(estimate, slots=None, measured=None))
    )
    yield Finding(
        "ONE_AT_WORK",
        "layout.stations",
        f"1 slot for {number_of(estimate.robots, 'robot')}: 1 of {estimate.robots} works at a time, as a task is given "
        f"out only when its station has a slot, and does {does} tasks an hour; with a slot for each they do {could}",
        "more slots (places) at the stations",
    )


def _nothing_to_drive(estimate: QuickEstimate) -> Iterator[Finding]:
    """Find tasks that end where they begin, so that robots carry loads nowhere."""
    if estimate.cycle.loaded <= 0:
        text = "loads are picked and put down at the same node, so no robot carries them anywhere"
        yield Finding("NOTHING_TO_DRIVE", "tasks", text, "say where loads really come from, or go to")


def _spread(model: Model) -> Iterator[Finding]:
    """Find routes among which robots cannot be spread, as turns make their times different."""
    if model.traffic.turn_time and model.policies.routing.params.get("spread", 1) != 1:
        yield Finding(
            "SPREAD_WITH_TURNS",
            "policies.routing.spread",
            "with traffic.turn_time equally short routes take different times, so only one of them is used",
            "leave out one of the two, or take congestion-aware",
        )


def _spares(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find kinds with fewer spare batteries than bays where they are swapped, so that some bay never has one."""
    for kind, count in spare_batteries(model).items():
        bays = len(swapped_at(layout, kind))
        if count < bays:
            where = f"fleet.kinds.{kind}.charging" if kind else "policies.charging"
            text = f"{'1 spare battery' if count == 1 else f'{count} spare batteries'} for {bays} bays with chargers"
            yield Finding("NO_SPARE", f"{where}.batteries", text, "at least one for each, or chargers in fewer bays")


# Widths, units and times


def _width(model: Model) -> Iterator[Finding]:
    layout, width = model.layout, 2 * max(robot.radius for robot in model.fleet.distinct())
    widths: dict[str, str | float | None] = {}
    if isinstance(layout.aisles, Mapping):
        widths |= {f"layout.aisles.{name}.width": lines.width for name, lines in layout.aisles.items()}
    else:
        widths["layout.aisles"] = layout.aisles
    if layout.blocks is not None:
        widths |= {f"layout.blocks.{key}": getattr(layout.blocks, key) for key in ("aisle_width", "cross_aisle_width")}
    aisles = {key: aisle for key, aisle in widths.items() if isinstance(aisle, int | float)}
    narrow = [(aisle, key) for key, aisle in aisles.items() if aisle < width * (1 - 1e-9)]
    if narrow:
        aisle, key = min(narrow)
        yield Finding(
            "ROBOT_WIDER_THAN_AISLE",
            key,
            f"an aisle is {aisle:g} {model.units.length} wide, a robot {width:g} (2 x its radius)",
            "give lengths in one unit (units.length), wider aisles or smaller robots",
        )


def _units(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    metre, length = estimate.metre, model.units.length
    if metre is None:
        return
    sides = [side * metre for side in (estimate.width, estimate.height)]
    if max(sides) > LARGEST or max(sides) < SMALLEST:
        yield Finding(
            "FLOOR_SIZE",
            "layout",
            f"the floor is {sides[0]:g} x {sides[1]:g} m",
            f"lengths are in {length}; units.length says so, e.g. mm",
        )
    robots = model.fleet.distinct()
    for speed in dict.fromkeys(speed for robot in robots for speed in (robot.speed, robot.loaded_speed)):
        real = speed * metre / model.units.seconds
        text = f"a robot drives {amount(real)} m/s ({amount(3.6 * real)} km/h)"
        cure = f"speed is in {length} per {model.units.time}; robots in warehouses drive 0.5 to 2 m/s"
        if real > FASTEST:
            yield Finding("FAST", "fleet.robot.speed", text, cure)
        elif real < SLOWEST:
            yield Finding("SLOW", "fleet.robot.speed", text, cure)


def _length(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    tasks, units = model.tasks, model.units
    for key in ("load_time", "unload_time"):
        time = mean_of(getattr(tasks, key)) * units.seconds
        if time >= HOUR:
            text = f"{time:g} s for one good ({amount(time / HOUR)} h)"
            yield Finding("LONG_HANDLING", f"tasks.{key}", text, f"times are in {units.time}")
    length = model.run.length
    if length is None:
        return
    counted = length - model.run.warm_up
    asked = math.inf if estimate.rate is None else estimate.rate
    done = counted * min(estimate.fleet_capacity, estimate.station_capacity, asked)
    few = done < FEW or (counted * units.seconds < SHORTEST and units.has_seconds and estimate.metre is not None)
    if counted < 3 * estimate.cycle.time or (few and model.tasks.never_end):
        warm_up = f", of which {counted:g} are counted" if model.run.warm_up else ""
        yield Finding(
            "SHORT_RUN",
            "run.length",
            (
                f"the run lasts {length:g} {units.time}{warm_up}; one task takes a robot "
                f"{amount(estimate.cycle.time)}, and about {done:.2g} can be done"
            ),
            f"times are in {units.time} (an hour has {units.hour:g}); let it last for some hundred tasks",
        )


# Demand


def _demand(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    tasks, hour = model.tasks, model.units.hour
    if estimate.rate is None or estimate.robots_busy is None:
        return
    asked = estimate.rate * hour
    if isinstance(tasks.goods, PoissonGoods) and tasks.goods.hours is None:
        asked = tasks.goods.poisson * tasks.demand
    if estimate.is_overloaded:
        part = limit.of_flows(model, estimate, estimate.bottleneck, lambda part: estimate.can_do(part * hour))
        yield Finding(
            "DEMAND_ABOVE_FLEET",
            "tasks.flows" if tasks.flows else "tasks.goods.poisson",
            f"demand is {asked:g} tasks an hour, but {limit.fleet(estimate)} can do {estimate.can_do(hour)}{part}",
            _cure(
                model,
                estimate,
                max(estimate.robots_busy, estimate.robots_needed or 0.0),
                ", each with a place at a station",
            ),
        )
    elif (busy := estimate.busiest_hour) is not None and busy.is_overloaded:
        yield Finding(
            "PEAK_ABOVE_FLEET",
            "tasks.flows" if tasks.flows else "tasks.goods.poisson",
            (
                f"demand is {amount((busy.rate or 0.0) * hour)} tasks in the busiest hour, but "
                f"{limit.fleet(busy)} can do {amount(busy.can_do_at_most * hour)}, so work piles "
                "up until it is over"
            ),
            _cure(model, busy, busy.robots_needed or 0.0, " to keep up with it"),
        )
    yield from _demand_of_stations(model, estimate)
    yield from _demand_of_lifts(model, estimate, estimate.rate)


def _cure(model: Model, estimate: QuickEstimate, need: float, how: str) -> str:
    """Return how many robots keep up with a demand, or what limits the fleet if that many hardly do more than fewer."""
    of_subfleets = [load for load in loads(model, estimate) if load.group.subfleet is not None]
    if short := [load for load in of_subfleets if load.robots_needed > load.group.number]:
        return f"at least {spoken(f'{load.robots_needed} of {load.group.zone}' for load in short)} are needed{how}"
    if of_subfleets and math.isfinite(need):
        return f"more robots of {max(of_subfleets, key=lambda load: load.need).group.zone}, which are the busiest"
    if estimate.pickers_walk_less and need > estimate.knee[0]:
        return "add robots or pickers, and see by a run how many: pickers walk less, the more robots wait for them"
    if math.isinf(need):
        return f"no number of robots keeps up{limit.reason(estimate, estimate.limit_at(estimate.rate or 0.0))}"
    robots, place = estimate.knee
    if need <= robots:
        return f"at least {math.ceil(need)} robots are needed{how}"
    return f"more than about {number_of(robots, 'robot')} hardly do more{limit.reason(estimate, place)}"


def _demand_of_stations(model: Model, estimate: QuickEstimate) -> Iterator[Finding]:
    handled = "unload_time" if estimate.pile_on is None else "stop_time"
    served = [(item.serve_busy or 0.0, item, item.servers, "server") for item in estimate.stations]
    worked = [(item.work_busy or 0.0, item, item.workers, "worker") for item in estimate.stations]
    for staff, time_key in ((served, handled), (worked, "work_time")):
        busy, worst, count, who = max(staff, key=lambda load: load[0], default=(0.0, None, 0, ""))
        if worst is None or busy <= 1:
            continue
        does = worst.handling if staff is served else "work on what is put down"
        spec = specs(model, model.floor).get(worst.node)
        time = "time" if spec is None or spec.hours is None else "opening time"
        needed = math.floor(count * busy * (1 + _ROUNDING)) + 1
        yield Finding(
            "DEMAND_ABOVE_STATIONS",
            f"layout.stations: {worst.node}",
            (
                f"{does} at {worst.node} takes {amount(100 * busy)} % of the {time} of its {number_of(count, who)}, "
                "so its queue grows without bound"
            ),
            f"it needs {number_of(needed, who)}, or less {time_key}, or a part of its tasks elsewhere (station_choice)",
        )


def _demand_of_lifts(model: Model, estimate: QuickEstimate, rate: float) -> Iterator[Finding]:
    """Find lifts with a demand for more rides than they can do; the cabins of a lift count together."""
    keys, hour = {lift.name: lift.model_name for lift in model.floor.lifts}, model.units.hour
    short: dict[str, list[LiftLoad]] = {}
    for lift in estimate.lifts:
        if rate * lift.least > 1:
            short.setdefault(keys[lift.name], []).append(lift)
    for name, cabins in short.items():
        most = amount(hour * math.fsum(cabin.capacity for cabin in cabins))
        rides = amount(hour * rate * math.fsum(cabin.least / cabin.time for cabin in cabins))
        who, queue = "it", "its queue grows"
        if len(cabins) > 1:
            who, queue = f"its {len(cabins)} cabins", "their queues grow"
        yield Finding(
            "DEMAND_ABOVE_LIFT",
            f"layout.lifts.{name}",
            f"{who} can do {most} rides an hour, but {rides} are needed: {queue} without bound",
            "one cabin more (cabins), a shorter ride or quicker doors",
        )


def _unused_lifts(model: Model, layout: Layout, estimate: QuickEstimate) -> Iterator[Finding]:
    """Find lifts that no robot takes, as another serves the same floors and the routing policy sees no queues."""
    if model.policies.routing.name == "congestion-aware" or model.policies.routing.own:
        return
    used, unused = {lift.name: lift for lift in estimate.lifts}, dict[str, list[str]]()
    for lift in layout.lifts:
        floors = {layout.floors[node] for node in lift.nodes}
        beside = [
            used[other.name]
            for other in layout.lifts
            if other.name in used and len(floors & {layout.floors[node] for node in other.nodes}) > 1
        ]
        if lift.name not in used and beside:
            unused.setdefault(beside[0].name, []).append(lift.name)
    for name, names in unused.items():
        most, lifts = used[name].capacity * model.units.hour, 1 + len(names)
        yield Finding(
            "LIFT_UNUSED",
            "policies.routing",
            f"{model.policies.routing.name} knows no queues: all robots take lift {name}, which can do "
            f"{amount(most)} rides an hour, and none takes {called(names)} to the same floors",
            f"congestion-aware takes {'both' if lifts == 2 else f'all {lifts}'}, which can do about "  # noqa: PLR2004
            f"{amount(lifts * most)}; or fastest with spread: {lifts}",
        )


def _one_load(model: Model) -> Iterator[Finding]:
    """Find robots that could carry more than they do, and batching policies that never combine tasks."""
    most, batching = model.fleet.largest_capacity, model.policies.batching.name
    if most > 1 and batching == "single":
        yield Finding(
            "ONE_LOAD",
            "policies.batching",
            f"robots carry up to {most} loads, but every task is a tour of its own",
            "policies.batching: fixed-size, time-window or by-order",
        )
    elif most == 1 and batching != "single":
        yield Finding(
            "ONE_LOAD",
            "fleet.robot.capacity",
            f"{batching} puts tasks together, but no robot carries more than one load",
            "fleet.robot.capacity, or the capacity of a kind: the loads that a robot carries at once",
        )


def _due(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find flows and goods whose `due_within` is less than a robot at the good needs to deliver it."""
    tasks = model.tasks
    within = {name: flow.due_within for name, flow in tasks.flows.items()} or {
        "": getattr(tasks.goods, "due_within", None)
    }
    if all(time is None for time in within.values()):
        return
    least = least_needs(model, layout, WITH_LOAD, anywhere=True).least
    for name, time in within.items():
        if time is not None and time < least[name]:
            yield Finding(
                "DUE_TOO_SOON",
                f"tasks.flows.{name}.due_within" if name else "tasks.goods.due_within",
                f"tasks are due after {time:g} {model.units.time}; a robot that is there needs {amount(least[name])}",
                f"due_within is in {model.units.time}",
            )
