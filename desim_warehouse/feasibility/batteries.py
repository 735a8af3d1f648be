"""Faults of the batteries of a model, as findings before a run and as the cause in the error of a flat battery.

For `desim check`, and for the error that ends a run.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

from desim_warehouse.errors import number_of, spoken
from desim_warehouse.feasibility.asked import most_loads
from desim_warehouse.feasibility.needs import TIME, least_needs
from desim_warehouse.feasibility.power import Power, at_rest, needed_at_rest
from desim_warehouse.findings import Finding, amount
from desim_warehouse.layout import BayPlaces, Layout
from desim_warehouse.layout.checks import some
from desim_warehouse.model import Model
from desim_warehouse.model.facts import charging
from desim_warehouse.model.facts.ahead import handling_of
from desim_warehouse.model.facts.charging import (
    chargers_at,
    charging_rate,
    cycle_levels,
    levels,
    sharing_with,
    start_energy,
)
from desim_warehouse.model.facts.demand import always_open, arrival_rate, listed, orders_of
from desim_warehouse.model.facts.places import own_destinations
from desim_warehouse.model.sections.fleet import BatterySpec, Consumption
from desim_warehouse.model.sections.flows import OrdersArrivals
from desim_warehouse.model.sections.goods import RandomGoods

DRAINS = {"NO_CHARGER", "THRESHOLD_TOO_LOW"}
"""Findings that imply that a robot may run flat."""
EPS = 1e-9
MINUTE = 60.0


def errors(model: Model, layout: Layout, bays: Iterable[BayPlaces] | None = None) -> Iterator[Finding]:
    """Find the errors of batteries, for which `simulate` refuses a model.

    `bays`: those that may be given chargers, if there are none; default: all.
    """
    small = list(_battery_too_small(model, layout))
    small = small or [finding for finding in _charged_too_low(model, layout) if finding.level == "error"]
    yield from small
    if not chargers_at(model, layout):
        yield from _no_charger(model, layout, _drawn_at_least(model, layout), "at least", bays)


def warnings(model: Model, layout: Layout, balance: Power | None) -> Iterator[Finding]:
    """Find faults of batteries that a planner should know, although the model can be simulated."""
    yield from chargers_short(model, balance)
    yield from of_levels(model, layout, balance)
    length = model.run.length
    if balance is not None and balance.draws is not None and length is not None and not balance.chargers:
        each = balance.draws * length / model.fleet.size
        if not list(_no_charger(model, layout, _drawn_at_least(model, layout), "at least")):
            yield from (replace(finding, code="NEVER_CHARGED") for finding in _no_charger(model, layout, each, "about"))


def of_levels(model: Model, layout: Layout, balance: Power | None) -> Iterator[Finding]:
    """Find faults of batteries and of their charging levels that a planner should know."""
    battery, units = _battery(model), model.units
    yield from _threshold(model, layout)
    if not list(_battery_too_small(model, layout)):
        yield from (finding for finding in _charged_too_low(model, layout) if finding.level == "warning")
    yield from _not_settled(model, balance)
    seconds = battery.capacity / battery.charge_rate * units.seconds
    if seconds < MINUTE and units.metre is not None:
        yield Finding(
            "FAST_CHARGE",
            "battery.charge_rate",
            f"an empty battery is full in {amount(seconds)} s",
            f"charge_rate is energy per {units.time}, capacity in the same unit of energy",
        )


def cause(
    model: Model,
    layout: Layout,
    started: float | None = None,
    *,
    kind: str = "",
    drew: float = 0.0,
    resting: bool = False,
) -> str:
    """Return in one line why a battery ran flat and what helps, for the error that ends a run.

    `model`: taken as if all robots had the battery of the robot's `kind`; `layout`: with the chargers of all kinds.
    `started`: the energy at the start of the run, if below a full battery and if the robot has not been charged since.
    It is a cause if it does not exceed the level at which charging begins. `drew`: mean energy that the robot drew per
    time unit so far. `resting`: whether the robot had no work.
    """
    alike = sharing_with(model, layout, kind)
    chargers = chargers_at(alike, alike.floor)
    bays = [bay for bay in layout.bays.values() if bay.is_for(kind)]
    if not chargers:
        for_it = " for it" if any(bay.kinds for bay in layout.bays.values()) else ""
        return f"no bay has a charger{for_it}: give {_some_bay(bays)}"
    if resting and sum(chargers.values()) < needed_at_rest(alike):
        return f"{at_rest(alike, alike.floor)} (layout.bays), or faster ones (battery.charge_rate)"
    findings = [*errors(model, model.floor), *of_levels(model, model.floor, None)]
    thresholds = levels(model)
    looks_ahead = thresholds is not None and thresholds.margin is not None
    # A policy that looks ahead sends no robot out with a battery that is too small.
    drains = DRAINS if looks_ahead else {*DRAINS, "BATTERY_TOO_SMALL"}
    causes = [item for item in findings if item.code in drains]
    if causes:
        return "; ".join(f"{item.text}; {item.cure} [{item.code}]" for item in causes[:2])
    return _no_charger_in_time(alike, bays, started, drew, resting=resting)


def _no_charger_in_time(
    model: Model, bays: Iterable[BayPlaces], started: float | None, drew: float, *, resting: bool
) -> str:
    """Return why a robot reached no charger in time, if the model itself has no fault; arguments as in `cause`.

    `model`: with only the robots that share its chargers; `bays`: those that it may use.
    """
    chargers = chargers_at(model, model.floor)
    battery, count, robots = _battery(model), sum(chargers.values()), number_of(model.fleet.size, "robot")
    zones = dict.fromkeys(bay.zone for bay in bays if bay.node not in chargers)
    text = f"{number_of(count, 'charger')} (at {some(chargers)}) for {robots}"
    if zones:
        text += f", none in the bays {some(zones)} (layout.bays)"
    if started is not None and started <= cycle_levels(model)[0]:
        short = f"it started with {started:g} of {battery.capacity:g} and came to no charger in time"
        return f"{text}: {short}; a higher fleet.start_energy, more chargers, or chargers where robots start"
    if resting:
        short = at_rest(model, model.floor)
        return f"{text}: {short}; more chargers, or more energy kept back (policies.charging: margin)"
    each, drawn = charging_rate(model), drew * model.fleet.size
    gives = count * each
    if drawn > gives:
        short = f"{_give(count, gives, model.units.time)}, but {robots} that draw as this one did take {amount(drawn)}"
        needed = number_of(math.ceil(drawn / each), "charger") if each else "chargers"
        return f"{text}: {short}; need at least {needed}, or faster ones (battery.charge_rate)"
    wait = f"it waited longer than its battery lasts, {spoken(_waits(model), 'or')}"
    cure = "more chargers, more energy kept back (policies.charging: margin or level, battery.threshold)"
    return f"{text}: {wait}; {cure}, or a capacity above {battery.capacity:g}"


def too_small(model: Model, layout: Layout) -> str:
    """Return which tasks exceed every battery of the model, by arithmetic, and what helps; empty if there are none."""
    findings = list(_battery_too_small(model, layout)) or list(_charged_too_low(model, layout))
    return "; ".join(f"{item.text}; {item.cure} [{item.code}]" for item in findings)


def _waits(model: Model) -> list[str]:
    """Return, in words, the waits for which a robot of the model may have no reserve in its battery."""
    causes = {
        "for a repair": model.fleet.breaks_down,
        "for a station to open": model.layout.has_hours,
        "for a lane to open": bool(model.traffic.closures),
        "for people": bool(model.people) or any(lift.people for lift in model.layout.lifts.values()),
        "for the repair of a lift": any(lift.outages for lift in model.layout.lifts.values()),
    }
    return ["in traffic", *(wait for wait, is_present in causes.items() if is_present), "for a charger"]


def holds(model: Model, battery: BatterySpec) -> float:
    """Return the most energy that a task may draw: a full battery, and the reserve unless the policy looks ahead."""
    thresholds = levels(model)
    return _full(model, battery) + (battery.reserve if thresholds is None or thresholds.margin is None else 0.0)


def _full(model: Model, battery: BatterySpec) -> float:
    """Return the highest level at which a robot may begin a task: at the start, or as charging leaves it."""
    thresholds = levels(model)
    if thresholds is None or thresholds.margin is None:
        return battery.capacity
    return thresholds.full if model.tasks.never_end else max(thresholds.full, start_energy(model)[1] * battery.capacity)


def _battery_too_small(model: Model, layout: Layout) -> Iterator[Finding]:
    battery, thresholds = _battery(model), levels(model)
    needs = least_needs(model, layout, battery.draws)
    units = f"consumption is energy per {model.units.time}"
    margin = 0.0 if thresholds is None or thresholds.margin is None else thresholds.margin
    if needs.most + margin > holds(model, battery) * (1 + EPS):
        kept = f", and {model.policies.charging.name} keeps {amount(margin)} back" if margin else ""
        yield Finding(
            "BATTERY_TOO_SMALL",
            "battery.capacity",
            (
                f"{needs.worst} draws at least {amount(needs.most)}: the drive there, to the station and to a "
                f"charger or home; a battery gives {amount(holds(model, battery))}{kept}"
            ),
            f"{units}: check it; else a larger battery, or chargers closer",
        )
    elif thresholds is not None and needs.reach > (left := _full(model, battery) - thresholds.critical) * (1 + EPS):
        yield Finding(
            "BATTERY_TOO_SMALL",
            "battery.threshold",
            (
                f"the drive to a good draws {amount(needs.reach)}, but the threshold {thresholds.critical:g} leaves "
                f"only {amount(left)} of a full battery for it, so the good is never fetched"
            ),
            f"a lower threshold, or a larger battery ({units})",
        )


def _charged_too_low(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find tasks that a robot has energy for only before its first charge, as charging ends below a full battery.

    They are an error if a list has more of them than the batteries can do with their energy at the start.
    """
    thresholds, chargers = levels(model), chargers_at(model, layout)
    if thresholds is None or thresholds.margin is None or model.tasks.never_end or not chargers:
        return
    battery = _battery(model)
    later = least_needs(model, layout, battery.draws, again=True)
    limit = thresholds.full * (1 + EPS)
    hard = {
        task
        for task, (need, reach) in later.of.items()
        if max(need + thresholds.margin, reach + thresholds.critical) > limit
    }
    if not hard and max(later.most + thresholds.margin, later.reach + thresholds.critical) <= limit:
        return
    asked = zip(listed(model), own_destinations(model, layout), strict=True)
    count = sum(task in hard for task in asked)
    alone = least_needs(model, layout, battery.draws, anywhere=True).of
    least = min((alone[task][0] for task in hard), default=0.0)
    starts = start_energy(model)[1] * battery.capacity
    possible = model.fleet.size * starts / least if least else math.inf
    finding = Finding(
        "CHARGED_TOO_LOW",
        "policies.charging",
        (
            f"{later.worst} draws at least {amount(later.most)}, and {amount(thresholds.margin)} is kept back, but "
            f"{model.policies.charging.name} ends charging at {amount(thresholds.full)} of {amount(battery.capacity)}: "
            "only a robot that has not been charged yet may do it"
        ),
        "charging that ends higher (full), less kept back (margin, critical), or a larger battery",
    )
    yield replace(finding, code="BATTERY_TOO_SMALL") if count > possible else finding


def _not_settled(model: Model, balance: Power | None) -> Iterator[Finding]:
    """Find endless work whose evaluation period begins before battery levels are in steady state (settled)."""
    start_shares, units = start_energy(model), model.units
    if model.fleet.start_energy == "settled" or balance is None:
        return
    if balance.night is not None and not balance.short:  # each day begins as the first
        return
    if not balance.chargers or not model.tasks.never_end or not 0 < balance.lasts < math.inf:
        return
    if model.run.warm_up >= balance.lasts:
        return
    shown = " to ".join(dict.fromkeys(f"{100 * share:.3g}" for share in start_shares))
    yield Finding(
        "START_ENERGY",
        "fleet.start_energy",
        (
            f"batteries start at {shown} % and last {amount(balance.lasts / units.hour)} h, and counting begins after "
            f"{amount(model.run.warm_up / units.hour)} h: the cost of charging may not show"
        ),
        "fleet.start_energy: settled, or a warm-up as long as a battery lasts",
    )


def _no_charger(
    model: Model, layout: Layout, drawn: float, about: str, bays: Iterable[BayPlaces] | None = None
) -> Iterator[Finding]:
    """Find batteries that are never charged, and from which the run draws more than they have.

    `drawn`: energy from each battery; `about`: the words `at least` or `about` before it. `bays`: as in `errors`.
    """
    battery, some_bay = _battery(model), _some_bay(layout.bays.values() if bays is None else bays)
    floor = floor_of(model)
    starts = battery.capacity * sum(start_energy(model)) / 2
    has = starts - floor
    if has <= 0 and drawn > 0 and starts < battery.capacity:
        yield Finding(
            "NO_CHARGER",
            "layout.bays",
            (
                f"no bay has a charger, and the batteries start with {amount(starts)} of {battery.capacity:g}, not "
                f"above {floor:g}, where robots stop working"
            ),
            f"give {some_bay} chargers, or the robots a higher fleet.start_energy",
        )
    elif drawn > has * (1 + EPS):
        yield Finding(
            "NO_CHARGER",
            "layout.bays",
            (
                f"no bay has a charger, and the batteries do not last: the run draws {about} {amount(drawn)} from "
                f"each, which has {amount(has)} above {floor:g}, where robots stop working"
            ),
            f"give {some_bay} chargers, the model no battery, or the run a length below {_ends(drawn, has)}",
        )


def _some_bay(bays: Iterable[BayPlaces]) -> str:
    zone = next((bay.zone for bay in bays), None)
    return "a bay without kinds some" if zone is None else f"layout.bays.{zone}.chargers (or total_chargers) some"


def _ends(drawn: float, has: float) -> str:
    return f"{100 * max(has, 0.0) / drawn:.2g} % of this"


def _drawn_at_least(model: Model, layout: Layout) -> float:
    """Return the least that the run draws from a robot that is never charged, if robots share the work evenly."""
    draws, length, robots = _battery(model).draws, model.run.length, model.fleet.size
    working = min(draws.empty, draws.loaded, draws.handling)
    task, time = _least_task(model, layout, draws), _least_task(model, layout, TIME)
    if not model.tasks.never_end:
        work = task * tasks_asked(model) / robots
        return work if length is None else min(work, working * length)
    assert length is not None
    rate = arrival_rate(model)
    if rate is None or always_open(model):
        return working * length
    done = draws.standing * length + (task - draws.standing * time) * rate * length / robots
    return min(done, max(working, draws.standing) * length)  # with too much work robots always work


def _least_task(model: Model, layout: Layout, draws: Consumption) -> float:
    """Return the least that the mean task draws from a robot; tasks that share a tour share its drives."""
    return least_needs(model, layout, draws, anywhere=True).mean / most_loads(model)


def must_charge(model: Model, layout: Layout) -> bool:
    """Return whether the run draws more from a robot than it starts with above the level where it stops working."""
    has = _battery(model).capacity * sum(start_energy(model)) / 2 - floor_of(model)
    return _drawn_at_least(model, layout) > has * (1 + EPS)


def floor_of(model: Model) -> float:
    """Return the level at which robots stop working."""
    thresholds = levels(model)
    return _battery(model).threshold if thresholds is None else thresholds.critical


def _battery(model: Model) -> BatterySpec:
    assert model.battery is not None
    return model.battery


def chargers_short(model: Model, balance: Power | None) -> Iterator[Finding]:
    """Find fleets, or kinds, that draw so much more than their chargers give that batteries fall, or run flat."""
    if balance is None or not balance.chargers or balance.draws is None:
        return
    units = model.units
    time = units.time
    capacity = model.fleet.size * charging.mean_capacity(model)
    falls = (balance.draws - balance.gives) * units.hour / capacity
    if not balance.short and falls * (model.run.length or 0.0) / units.hour <= sum(start_energy(model)) / 2:
        return
    text = f"the batteries fall by {amount(100 * falls)} % an hour, however well a short run looks"
    if balance.night is not None:
        lost = (balance.draws - balance.gives - balance.slack) * model.run.end / capacity
        text = f"the batteries lose {amount(100 * lost)} % a day, nights included, however well a single day looks"
    yield Finding(
        "CHARGERS_SHORT",
        "layout.bays",
        (
            f"{_give(balance.chargers, balance.gives, time)}, but the fleet draws {amount(balance.draws)}, up to "
            f"{amount(balance.most)}: {text}"
        ),
        f"need at least {number_of(balance.needed or 0, 'charger')}, or a higher charge_rate",
    )


def _give(chargers: int, gives: float, time: str) -> str:
    """Return in words how much energy chargers give per time unit."""
    return f"{number_of(chargers, 'charger')} {'gives' if chargers == 1 else 'give'} {amount(gives)} per {time}"


def _threshold(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find thresholds so low that a robot just above may not get to a charger after its next task.

    Such a robot stands on the edge of the task's good, and does the task before it charges.
    """
    battery, thresholds = _battery(model), levels(model)
    if thresholds is None or thresholds.margin is not None or not chargers_at(model, layout):
        return
    times, flows = handling_of(model, layout).means(), model.tasks.flows or [""]
    more = min(times.at_stop("load", flow) + times.at_stop("unload", flow) for flow in flows)
    rest = least_needs(model, layout, battery.draws, again=True).rest
    rest += (most_loads(model) - 1) * battery.draws.handling * more  # on a tour at least all loads are handled
    if rest > thresholds.critical + battery.reserve:
        yield Finding(
            "THRESHOLD_TOO_LOW",
            "battery.threshold",
            f"a robot just above {thresholds.critical:g} finishes its task, which with the drive to a charger draws at "
            f"least {amount(rest)} for the farthest good; it can run flat",
            f"a threshold well above {amount(rest)}, with a reserve for waiting; in energy, as capacity",
        )


def tasks_asked(model: Model) -> int:
    """Return the number of tasks, if the work ends."""
    goods = model.tasks.goods
    if isinstance(goods, RandomGoods):
        return goods.random
    if isinstance(goods, tuple):
        return len(goods)
    flows = model.tasks.flows.values()
    orders = sum(orders_of(model, flow).tasks for flow in flows if isinstance(flow.when, OrdersArrivals))
    return orders + sum(round(flow.scheduled * model.tasks.demand) for flow in flows)
