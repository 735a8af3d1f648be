"""The details behind the answer of a check, one figure per line: floor, parts of a task, energy and limits."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from desim_warehouse.errors import number_of
from desim_warehouse.feasibility.asked import orders_a_day, orders_asked_for
from desim_warehouse.feasibility.estimate import APART, PICKERS, THE_ROBOTS, QuickEstimate
from desim_warehouse.feasibility.parts import PileOn
from desim_warehouse.feasibility.power import Power
from desim_warehouse.findings import amount
from desim_warehouse.layout import checks
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import kind_in_words
from desim_warehouse.model.facts.lifts import called
from desim_warehouse.model.schema import Units
from desim_warehouse.run.quick import Choice, Nearer, left_out
from desim_warehouse.values.distributions import Distribution

FEWER = 0.99
"""Share of the rides for a task below which the smaller number of rides is printed, where robots choose."""


def of_model(model: Model) -> list[str]:
    """Return the lines on a model: layout, lanes, demand, what estimates leave out, and the shortest rings."""
    layout, fleet, units = model.floor, model.fleet, model.units
    graph, length, time = layout.graph, units.length, units.time
    sizes = (len(graph), "node"), (graph.number_of_edges(), "edge"), (len(layout.storage), "storage place")
    room = number_of(checks.room(layout, fleet.contact), "robot")
    lines = [
        f"{model.name}: {', '.join(number_of(*size) for size in sizes)}",
        f"robots keep D = {fleet.contact:g} {length} and drive up to {fleet.fastest:g} {length}/{time}",
        f"the lanes hold {room} at once, the fleet has {fleet.size:,}",
    ]
    if fleet.slowness:
        stop = fleet.slowness * fleet.fastest
        lines.append(f"a stop on the way costs up to {stop:.3g} {time} of braking and acceleration")
    if braking := fleet.longest_braking:
        way = f"{braking:.3g} {length}"
        lines.append(f"robots that keep their braking distance follow up to {way} farther behind")
    lines += [*orders_a_day(model), *orders_asked_for(model), *_times_that_vary(model), *left_out(model, layout)]
    for ring in checks.shortest_rings(graph):
        around = sum(graph.edges[edge]["length"] for edge in pairwise(ring))
        lines.append(f"ring of {around:g} {length}: {' > '.join(ring)}")
    return lines


def of_savings(model: Model, nearer: Nearer | None, choice: Choice | None, estimate: QuickEstimate) -> list[str]:
    """Return the lines on time saved by other places for fast movers, and by a choice among tasks."""
    time, lines = model.units.time, []
    if nearer is not None:
        saved = f"{amount(nearer.saved)} of {amount(nearer.now)} {time} a task"
        keys = ", ".join(f"{key}: distance" for key in nearer.keys)
        lines.append(f"fast movers nearest to the stations would save {saved} ({keys})")
    if choice is not None:
        drives = f"{amount(choice.empty)} {time} empty per task instead of {amount(estimate.cycle.empty)}"
        backlog, done = f"with {choice.waiting} tasks to choose from", estimate.can_do(model.units.hour)
        lines.append(f"{backlog}, {choice.policy} drives {drives}: {done} tasks an hour")
    return lines


def of_estimate(estimate: QuickEstimate, units: Units) -> list[str]:
    """Return the lines on the quick estimate: floor, mean task, robots, stations, energy and the knee."""
    time, hour = units.time, units.hour
    together = "" if estimate.measured is None else f", and on {estimate.looked_at:,} of the whole fleet"
    return [
        _floor(estimate, units),
        _task(estimate, time),
        f"measured on {estimate.sample:,} tasks of a single robot of each kind{together}",
        *([] if estimate.pile_on is None else [_pods(estimate.pile_on, units)]),
        _robots(estimate, time, hour),
        _stations(estimate, hour),
        *_lifts(estimate, hour),
        *([] if estimate.power is None else _energy(estimate.power, time)),
        *([] if estimate.subfleets else [_knee(estimate)]),
    ]


def _knee(estimate: QuickEstimate) -> str:
    robots, limit = estimate.knee
    unless = ", unless they walk less" if limit == PICKERS and estimate.pickers_walk_less else ""
    return f"knee: about {number_of(robots, 'robot')}; twice as many do hardly more, limited by {limit}{unless}"


def _times_that_vary(model: Model) -> Iterator[str]:
    """Yield a line for each random handling time of the model."""
    for name, time in (("loading", model.tasks.load_time), ("unloading", model.tasks.unload_time)):
        if isinstance(time, Distribution):
            yield f"{name} varies: {time.words(model.units.time)}"


def _floor(estimate: QuickEstimate, units: Units) -> str:
    width, height, metre = estimate.width, estimate.height, estimate.metre
    line = f"floor: {amount(width)} x {amount(height)} {units.length}"
    if metre is None or metre == 1:
        return line
    return f"{line} ({amount(width * metre)} x {amount(height * metre)} m)"


def _task(estimate: QuickEstimate, time: str) -> str:
    cycle = estimate.cycle
    parts = [(cycle.empty, "driving empty"), (cycle.load, "loading")]
    parts += [(cycle.loaded, "driving loaded"), (cycle.unload, "unloading")]
    if cycle.other:
        parts.append((cycle.other, "other"))
    added = " + ".join(f"{amount(part)} {name}" for part, name in parts)
    return f"mean task, measured: {amount(cycle.time)} {time} = {added}"


def _pods(pile_on: PileOn, units: Units) -> str:
    """Return the line on the lines that a visit of a pod serves, and on the work that pickers can do."""
    least, most = sorted((amount(pile_on.few), amount(pile_on.many)), key=float)
    lines = f"{least} line{'s' * (least != '1')}" if least == most else f"{least} to {most} lines"
    text = f"pods: {lines} a visit with {pile_on.policy}, measured"
    if not pile_on.pick:
        return text
    an_hour = pile_on.servers * units.hour
    text += f"; pickers: at most {amount(an_hour / pile_on.pick)} lines an hour"
    if not pile_on.change:
        return text
    slow, fast = (amount(an_hour / (pile_on.pick + pile_on.change / pile)) for pile in (pile_on.few, pile_on.many))
    rate = slow if slow == fast else f"{slow} to {fast}"
    return f"{text}, or {rate} if pods queue and a change takes {amount(pile_on.change)} {units.time}"


def _robots(estimate: QuickEstimate, time: str, hour: float) -> str:
    robots = number_of(estimate.robots, "robot")
    if estimate.at_work < estimate.robots:
        robots = f"{estimate.at_work} of {robots} (the stations have no slots for more)"
    if estimate.most_out is not None:
        robots += f", at most {estimate.most_out} of them under way,"
    if estimate.on_duty < 1:
        robots += f", able to work {amount(100 * estimate.on_duty)} % of the time,"
    text = f"robots: {robots} can do {estimate.can_do(hour)} tasks an hour"
    if estimate.bottleneck != THE_ROBOTS:
        text += f", limited by {estimate.bottleneck}"
    if estimate.queues.places and estimate.throughput_of_queues < APART * estimate.most:
        text += f", held back by queues for {estimate.queues.longest}"
    if estimate.charging:
        text += f", and charge {amount(estimate.charging)} {time} per task"
    if not estimate.subfleets and estimate.rate is not None and estimate.robots_needed is not None:
        text += f"; {_need(estimate, estimate.rate * hour, estimate.robots_needed, 'demanded')}"
        if (busy := estimate.busiest_hour) is not None and busy.rate is not None:
            text += f"; {_need(busy, busy.rate * hour, busy.robots_needed or 0.0, 'of the busiest hour')}"
    return text


def _need(estimate: QuickEstimate, asked: float, robots: float, what: str) -> str:
    if math.isfinite(robots):
        return f"the {amount(asked)} {what} need {amount(robots)} robots"
    if estimate.pickers_walk_less:
        return f"a run tells how many robots do the {amount(asked)} {what}, as pickers walk less, the more robots wait"
    return f"no number of robots does the {amount(asked)} {what}, limited by {estimate.limit_at(estimate.rate or 0.0)}"


def _stations(estimate: QuickEstimate, hour: float) -> str:
    most = estimate.station_capacity
    if math.isinf(most):
        return "stations: unloading takes no time"
    text = f"stations: at most {amount(most * hour)} tasks an hour, split between them as the tasks come"
    worst = estimate.fullest
    if worst is None:
        return text
    text += (
        f"; at the demanded rate, {worst.node} ({worst.staff}) is busy {100 * (worst.busy or 0.0):.3g} % of the time"
    )
    return f"{text} in which it is open ({amount(100 * worst.open)} % of all time)" if worst.open < 1 else text


def _lifts(estimate: QuickEstimate, hour: float) -> Iterator[str]:
    """Yield a line on what each lift can do, and on the demand for it; lifts that are alike share a line."""
    lines: dict[str, list[str]] = {}
    for lift in estimate.lifts:
        line = f"can do {amount(lift.capacity * hour)} rides an hour, at {amount(lift.share)} per task"
        if estimate.rate is not None:
            line += f"; the demand needs {amount(estimate.rate * lift.share * hour)}"
            if lift.least < FEWER * lift.share * lift.time:
                rides = amount(estimate.rate * lift.least / lift.time * hour)
                line += f", or {rides} if robots choose among many tasks"
        lines.setdefault(line, []).append(lift.name)
    for line, names in lines.items():
        yield f"{called(names)}: {'it' if len(names) == 1 else 'each'} {line}"


def _energy(power: Power, time: str) -> list[str]:
    """Return the lines on the energy balance, by kind if kinds differ."""
    if power.kinds:
        lines = [
            f"{kind_in_words(kind)}: {line}" for kind, alone in power.kinds.items() for line in _energy(alone, time)
        ]
        if power.needed is not None:
            lines.append(f"chargers: {power.chargers} in all; at least {power.needed} needed")
        return lines
    lasts = "never runs out" if math.isinf(power.lasts) else f"lasts {amount(power.lasts)} {time} of work"
    balance = f"chargers: {power.chargers:,}, which supply {amount(power.gives)} per {time}"
    if power.draws is not None and power.needed is not None:
        balance += f"; the fleet draws {amount(power.draws)}, at most {amount(power.most)}: "
        balance += f"at least {power.needed} needed"
    return [f"energy: a task draws {amount(100 * power.share)} % of a battery; a full battery {lasts}", balance]
