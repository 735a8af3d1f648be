"""The answer of a check in the words of the trade: loads an hour, orders a day, robots, chargers and stations."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator

from desim_warehouse.answer import busiest, numbers, words
from desim_warehouse.answer.numbers import capital, sentence
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.feasibility import limit
from desim_warehouse.feasibility.asked import orders_a_day, orders_asked_for
from desim_warehouse.feasibility.estimate import APART, PICKERS, QuickEstimate, limiting
from desim_warehouse.feasibility.loads import loads
from desim_warehouse.feasibility.parts import StationLoad
from desim_warehouse.feasibility.power import Power
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import kind_in_words
from desim_warehouse.model.facts.workers import Group, Load, groups
from desim_warehouse.run.quick import Choice, Nearer, left_out

_FEW, _MANY = 10.0, 1000.0
"""Rates below the first have one decimal, and rates from the second on are rounded to tens."""
_NOTHING = "nothing in the long run"
"""What robots can do whose rest alone draws more than chargers give."""
_WHOLE = 0.999
"""Share of the time from which on it is told in per cent, as in hours it would look like all of it."""
_ALMOST = 1e-9
"""Relative difference by which a rate may be below a whole number and count as this number."""


def sentences(
    model: Model,
    estimate: QuickEstimate | None,
    nearer: Nearer | None = None,
    choice: Choice | None = None,
    wider: float | None = None,
) -> list[str]:
    """Return the answer of a check in sentences; without an estimate only the warehouse and the demand.

    `wider`: the gain in tasks that the fleet would have in wide aisles, as a share.
    """
    asked = [sentence(line) for line in (*orders_a_day(model), *orders_asked_for(model))]
    if estimate is None:
        return [_warehouse(model), *asked]
    return [
        _warehouse(model),
        *asked,
        *_robots(model, estimate),
        *_chargers(estimate.power, model),
        *_stations(model, estimate),
        *_pickers(model, estimate),
        *_limit(estimate),
        *_busiest(model, estimate),
        *_savings(model, estimate, nearer, choice),
        *_aisles(wider),
        *(sentence(line) for line in left_out(model, model.floor)),
    ]


def _warehouse(model: Model) -> str:
    """Return the warehouse as a line of counts: `W: 12 robots, 1 charger, 2 packers, 480 storage places`."""
    parts = [_counted(group, group.number) for group in groups(model)]
    parts += [number_of(len(model.floor.storage), "storage place")] if model.floor.storage else []
    return f"{capital(model.name)}: {', '.join(parts)}."


def _counted(group: Group, number: int) -> str:
    """Return a group with its number in words: `1 packer`, `2 places of dock`; of a lift only its name."""
    if group.is_lift:
        return group.name
    name, separator, zone = group.name.partition(" of ")
    return f"{number_of(number, name.removesuffix('s'))}{separator}{zone}"


def _staff(model: Model, station: StationLoad) -> str:
    """Return the words for the servers or pickers that limit a station, with their number."""
    number = station.workers if station.limited_by_work else station.servers
    for group in groups(model):
        if station.node in group.nodes and (group.kind == "people") == station.limited_by_work:
            return _counted(group, number)
    return station.staff


def _robots(model: Model, estimate: QuickEstimate) -> Iterator[str]:
    """Yield the sentences on what the robots can do, against demand, and on how many robots are enough."""
    hour = model.units.hour

    def can_do(part: float) -> str:
        least, most = (_floor(rate * hour * part) for rate in estimate.range)
        return least if estimate.range[0] >= APART * estimate.range[1] else f"{least} to {most}"

    def with_part(words: Callable[[float], str], what: str = "") -> str:
        return f"{words(1)}{what}{limit.of_flows(model, estimate, estimate.bottleneck, words)}"

    if math.isfinite(estimate.range[1]):
        loads_an_hour = f"about {with_part(can_do, f' {words.loads(model)} an hour')}"
        line = f"{capital(limit.fleet(estimate))} can do {loads_an_hour if estimate.range[1] > 0 else _NOTHING}"
        if (rate := estimate.rate) is not None:
            line += f"; you need {with_part(lambda part: numbers.measured(rate * hour * part))}"
            peak = None if estimate.peak is None else numbers.measured(estimate.peak * hour)
            line += "" if peak is None else f" on average and {peak} in the busiest hour"
        yield f"{line}."
    yield from _at_work(model, estimate)
    if estimate.subfleets and estimate.rate is not None:
        yield from _enough_of_subfleets(loads(model, estimate))
    elif estimate.rate is not None and estimate.robots_needed is not None:
        yield _enough(model, estimate, estimate.robots_needed)


def _at_work(model: Model, estimate: QuickEstimate) -> Iterator[str]:
    """Yield the sentences on how many robots can be at work, and for how much of the time."""
    if estimate.at_work < estimate.robots:
        yield f"Only {estimate.at_work} of them can work at a time: the stations have no slots for more."
    if estimate.most_out is not None and estimate.most_out < estimate.robots:
        yield f"At most {estimate.most_out} of them are under way at a time (traffic.most_out)."
    if estimate.on_duty < 1:
        end, part = model.run.end, f"{numbers.PERCENT.value(estimate.on_duty)} of its time"
        if math.isfinite(end) and 0 < estimate.on_duty < _WHOLE:
            scale = numbers.times(model.units.time, (estimate.on_duty * end,))
            part = f"{numbers.measured(scale.by * estimate.on_duty * end)} of {scale.value(end)}"
        causes = ["hours"] * (estimate.on_duty < estimate.unbroken) + ["breakdowns"] * (estimate.unbroken < 1)
        yield f"{capital(spoken(causes))} leave a robot {part} for work."


def _enough(model: Model, estimate: QuickEstimate, mean: float) -> str:
    """Return the sentence on how many robots are enough, on average and in the busiest hour."""
    busy = estimate.busiest_hour or estimate
    peak = busy.robots_needed or 0.0
    if math.isinf(max(mean, peak)):
        short = estimate if math.isinf(mean) else busy
        asked = f"{numbers.measured((short.rate or 0.0) * model.units.hour)} {words.loads(model)}"
        asked = f"{asked} an hour" if math.isinf(mean) else f"the {asked} of the busiest hour"
        if short.pickers_walk_less:
            return f"Robots: a run tells how many are enough for {asked}, as pickers walk less, the more robots wait."
        return f"Robots: no number is enough for {asked}{limit.reason(estimate, short.limit_at(short.rate or 0.0))}."
    on_average, most = math.ceil(mean), max(math.ceil(mean), math.ceil(peak))
    counts = f"{most:,}" if on_average == most else f"{on_average:,} on average and {most:,} in the busiest hour"
    return f"Robots: {_are(counts, most, most <= estimate.robots)}; you have {estimate.robots:,}."


def _enough_of_subfleets(foreseen: Iterable[Load]) -> Iterator[str]:
    """Yield the sentences on how many robots of each subfleet are enough, and on subfleets without work."""
    parts = []
    for load in foreseen:
        if load.group.subfleet is None:
            continue
        need, has, kinds = load.robots_needed, load.group.number, load.group.zone
        if load.group.subfleet.flows:
            parts.append(f"{_are(f'{need} of {kinds}', need, need <= has)} (you have {has})")
        else:
            yield f"Robots of {kinds} have nothing to do: no flow is for them."
    yield f"Robots: {spoken(parts)}."


def _are(counts: str, number: int, enough: bool) -> str:
    return f"{counts} {'is' if number == 1 else 'are'} {'enough' if enough else 'needed'}"


def _chargers(power: Power | None, model: Model) -> Iterator[str]:
    """Yield the sentences on how many chargers are enough, and on how long a battery lasts."""
    if power is None:
        return
    lasts = numbers.duration(power.lasts, model.units.time) if math.isfinite(power.lasts) else ""
    battery = f"a full battery lasts {lasts} of work" if lasts else "batteries never run out"
    if power.needed is None:
        yield sentence(battery)
        return
    have = f"{power.chargers:,}" if power.chargers else "none"
    they_give = f"{have} {'gives' if power.chargers == 1 else 'give'}"
    number = f"{power.needed:,}" if power.needed else "none"
    line = _are(number, power.needed or 1, power.enough)
    if len(power.groups) > 1:
        needed = _by_kind((group.needed, group.kinds) for group in power.groups)
        have = have if power.enough else _by_kind((group.chargers, group.kinds) for group in power.groups)
        line += f", {needed}; you have {have}"
    elif power.by_chargers < 1 and power.enough:
        line += f", as {'it charges' if power.needed == 1 else 'they charge'} overnight, too; you have {have}"
    elif power.enough or power.short:
        line += f"; you have {have}"
    else:
        share = math.floor(100 * power.gives / (power.draws or math.inf))
        line = f"{power.needed:,} are needed in the long run; {they_give} {share} % of what the fleet draws"
    yield f"Chargers: {line}. {sentence(battery)}"


def _by_kind(counts: Iterable[tuple[int, tuple[str, ...]]]) -> str:
    """Return numbers for the kinds that share chargers: `1 for kind car and none for kind van`."""
    return spoken([f"{count or 'none'} for {spoken(map(kind_in_words, kinds))}" for count, kinds in counts])


def _stations(model: Model, estimate: QuickEstimate) -> Iterator[str]:
    """Yield the sentence on what the stations can serve, and on the utilisation of the fullest."""
    first, most = estimate.first_full, estimate.station_capacity * model.units.hour
    if first is None or math.isinf(most):
        return
    line = f"Stations can serve about {_floor(most)} {words.loads(model)} an hour"
    line += limit.of_flows(model, estimate, first.doing, lambda part: _floor(part * most))
    if (full := estimate.fullest) is not None and full.busy is not None:
        hours = " of its hours" if full.open < 1 else " of the time"
        line += f"; {full.node} ({_staff(model, full)}) would be in use {busiest.whole_percent(full.busy)}{hours}"
    yield f"{line}."


def _pickers(model: Model, estimate: QuickEstimate) -> Iterator[str]:
    """Yield the sentence on the lines that pickers can pick in an hour.

    The least holds if each robot is far from the one before, the most if pickers need not walk.
    """
    pickers = estimate.pickers
    if pickers is None or math.isinf(pickers.most):
        return
    least, most = (_floor(rate * model.units.hour) for rate in (pickers.least, pickers.most))
    yield (
        f"Pickers: {pickers.count} can pick {least} to {most} lines an hour; the more robots wait for them, the less "
        "they walk."
    )


def _limit(estimate: QuickEstimate) -> Iterator[str]:
    if estimate.subfleets:
        return  # more robots of which subfleet?
    robots, place = estimate.knee
    if place and not (place == PICKERS and estimate.pickers_walk_less):
        yield f"Beyond about {number_of(robots, 'robot')}, {limiting(place)}."


def _busiest(model: Model, estimate: QuickEstimate) -> Iterator[str]:
    """Yield the sentence on the busiest group by the estimate; none if the estimate foresees no rate."""
    line = busiest.are(loads(model, estimate), "of the time" if estimate.on_duty == 1 else "of their hours")
    if line:
        yield sentence(line)


def _aisles(wider: float | None) -> Iterator[str]:
    """Yield the sentence on the cost of robots that load in their lanes."""
    if wider is not None:
        more = f"about {numbers.number(100 * wider, 0)} % more"
        yield f"Robots hold up others while they load: beside their lanes they would do {more} (layout.aisles: wide)."


def _savings(model: Model, estimate: QuickEstimate, nearer: Nearer | None, choice: Choice | None) -> Iterator[str]:
    """Yield the sentences on time saved by a choice among tasks, and by fast movers nearer to the stations."""
    unit = model.units.time
    if choice is not None:
        before, after = (numbers.duration(time, unit) for time in (estimate.cycle.empty, choice.empty))
        if after != before:
            yield f"With many orders waiting, robots drive empty {after} a {words.load(model)} instead of {before}."
    if nearer is not None:
        scale = numbers.times(unit, (nearer.saved,))
        saved, now = (
            numbers.number(scale.by * time, 0 if scale.by * nearer.saved >= 1 else 2)
            for time in (nearer.saved, nearer.now)
        )
        keys = ", ".join(f"{key}: distance" for key in nearer.keys)
        gain = f"{saved} of {now} {scale.unit} a {words.load(model)}"
        yield f"Fast movers nearest to the stations would save {gain} ({keys})."


def _floor(rate: float) -> str:
    """Return a rate rounded down: to whole numbers, below 10 to one decimal, from 1,000 on to tens."""
    digits = 1 if rate < _FEW else 0 if rate < _MANY else -1
    return numbers.number(math.floor(rate * (1 + _ALMOST) * 10**digits) / 10**digits, max(digits, 0))
