"""Names, units and numbers for people: the same in figures, tables and sentences."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import spoken
from desim_warehouse.model.facts.keys import about
from desim_warehouse.outcome.indicators import look_up
from desim_warehouse.states import TIMES
from desim_warehouse.study.factors import readable
from desim_warehouse.study.table import plain

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from desim_warehouse.model.schema import Units
    from desim_warehouse.study.plan import StudyPlan
    from desim_warehouse.study.results import Results
    from desim_warehouse.study.statistics import Estimate, Target

_COLUMNS = {"run_time": ("Computing time of a run", "s")}
"""Columns of a study table that are no indicators: name for people, and unit."""
STATE_WORDS = {name: state.doing for name, state in TIMES.items()}
"""State of a robot: what it does, for people."""

_OF_THE_MODEL = {
    "time": "{time}",
    "length": "{length}",
    "speed": "{length} per {time}",
    "acceleration": "{length} per {time}^2",
    "power": "energy per {time}",
}
_OF_ALL = {"rate": "per hour", "angle": "degrees"}
"""Units by kind of quantity; any other kind is its own unit."""
_LONGEST = 44
"""A label longer than this is cut."""


def unit(kind: str, units: Units | None, seconds: bool = False) -> str:
    """The unit of a kind of quantity as the model names it; empty for counts and shares, and without a model."""
    if kind in ("count", "weighted", "ratio", "share"):
        return ""
    if kind == "time" and seconds:
        return "s"
    if kind in _OF_THE_MODEL:
        return _OF_THE_MODEL[kind].format(length=units.length, time=units.time) if units else ""
    return _OF_ALL.get(kind, kind)


def indicator_kind(indicator: str) -> str:
    """The kind of unit of an indicator: time, length, count, ...; empty for a column that is no indicator."""
    known = look_up(indicator)
    return known.unit if known else _COLUMNS.get(indicator, ("", ""))[1]


def is_share(indicator: str) -> bool:
    """Whether values of an indicator are shares, shown in per cent."""
    known = look_up(indicator)
    return known is not None and known.is_share


def indicator_name(indicator: str) -> str:
    """An indicator's title; the column's own name if it is no indicator."""
    known = look_up(indicator)
    return known.title if known else _COLUMNS.get(indicator, (indicator, ""))[0]


def in_sentence(indicator: str) -> str:
    """An indicator's name inside a sentence: `task time T`."""
    name = indicator_name(indicator)
    return f"{name[:1].lower()}{name[1:]}"


def indicator_label(indicator: str, units: Units | None, seconds: bool = False) -> str:
    """Name and unit of an indicator, for an axis: `Task time T (step)`."""
    return with_unit(indicator_name(indicator), unit(indicator_kind(indicator), units, seconds))


def factor_unit(key: str, units: Units | None) -> str:
    """The unit of a factor's values; empty where it has none, or is a case."""
    known = about(key)
    return unit(known.kind, units) if known else ""


def factor_name(key: str) -> str:
    """What a factor is, for legends and heads of tables: `Chargers in parking`; the name of a case as it is."""
    known = about(key)
    return f"{known.label[0].upper()}{known.label[1:]}" if known else key


def factor_head(key: str, units: Units | None) -> str:
    """A factor and its unit, for the head of a table: `Time between breakdowns (s)`."""
    return with_unit(factor_name(key), factor_unit(key, units))


def factor_label(key: str, units: Units | None) -> str:
    """A factor, its key where there is room, and its unit, for an axis: `Number of robots, fleet.size`."""
    name = factor_name(key)
    both = f"{name}, {key}"
    return with_unit(both if name != key and len(both) <= _LONGEST else name, factor_unit(key, units))


def averaged(factors: Sequence[str]) -> str:
    """What a mean leaves out of sight, as the second line of an axis; empty if nothing."""
    return f"\naveraged over {', '.join(factors)}" if factors else ""


def with_unit(name: str, of: str) -> str:
    """A label with its unit in brackets, if there is one."""
    return f"{name} ({of})" if of else name


def level(value: Any) -> str:
    """A value of a factor, short enough for a label."""
    value = plain(value)
    if value is None:
        return "none"
    if isinstance(value, float):
        return f"{value:g}"
    text = readable(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


def design_name(design: Mapping[str, Any]) -> str:
    """A design point in words: `fleet.size = 6, battery.threshold = 2`."""
    return ", ".join(f"{key} = {level(value)}" for key, value in design.items()) or "the model as it is"


def design_spoken(design: Mapping[str, Any]) -> str:
    """A design point as one says it: `6 robots and 2 chargers, battery.threshold = 2`."""
    counts = [f"{n} {what}{'s' * (n != 1)}" for key, n in design.items() if (what := _counted(key, n))]
    others = {key: value for key, value in design.items() if not _counted(key, value)}
    parts = [*([spoken(counts)] if counts else []), *([design_name(others)] if others or not counts else [])]
    return ", ".join(parts)


def fleet(robots: int, chargers: int) -> str:
    """Robots, and chargers if there are some, as one says it: `6 robots and 2 chargers`."""
    return design_spoken({"fleet.size": robots, **({"chargers": chargers} if chargers else {})})


def _counted(key: str, value: Any) -> str:
    """What a factor counts, in the singular; empty if it is not a number of robots or chargers."""
    if not str(value).isdecimal():
        return ""
    charger = key == "chargers" or key.endswith(".total_chargers")
    return "robot" if key == "fleet.size" else "charger" if charger else ""


def number(value: float, digits: int | None = None) -> str:
    """A number with separated thousands: four significant digits, or the given decimals."""
    if not math.isfinite(value):
        return "–" if math.isnan(value) else ("∞" if value > 0 else "−∞")
    if digits is None:
        whole = float(value).is_integer() and abs(value) < 1e15  # noqa: PLR2004 - beyond, floats skip
        digits = 0 if whole or not value else max(0, 3 - math.floor(math.log10(abs(value))))
        shown = f"{value:,.{digits}f}"
        shown = shown.rstrip("0").rstrip(".") if "." in shown else shown
    else:
        shown = f"{value:,.{digits}f}"
    return shown.replace("-", "−") if float(shown.replace(",", "")) else shown.removeprefix("-")


def number_of(count: float, what: str) -> str:
    """A number of things, `what` in the singular: `1 task`, `1,200 tasks`."""
    return f"{number(count)} {what}{'s' * (count != 1)}"


def decimals(half_width: float) -> int:
    """Decimals at which a half-width shows two significant digits."""
    if not half_width or not math.isfinite(half_width):
        return 0
    return max(0, 1 - math.floor(math.log10(abs(half_width))))


def mean_text(estimate: Estimate) -> str:
    """A mean with its half-width, rounded alike; the mean alone where there is no interval. Shares of tasks in %."""
    if estimate.of_all is not None:
        return share_text(estimate)
    if estimate.half_width is None:
        return number(estimate.mean)
    digits = decimals(estimate.half_width)
    return f"{number(estimate.mean, digits)} ± {number(estimate.half_width, digits)}"


def replications(plan: StudyPlan) -> str:
    """How many replications each design has, in words."""
    rule = plan.replications
    if isinstance(rule, int):
        return str(rule)
    if isinstance(rule, tuple):
        return f"{min(rule)} to {max(rule)} of each design, as the procedure asked for"
    return (
        f"{rule.minimum} to {rule.cap} of each design, until the half-width of {rule.indicator} is at most "
        f"{number(100 * rule.half_width)} % of its mean"
    )


def met(study: Results, design: str) -> str:
    """Whether a design meets the target of a study; a dash where its runs do not say."""
    found = study.judged.get(design)
    return (
        "–" if found is None else {"meets": "met", "fails": "not met", "undecided": "too close to tell"}[found.verdict]
    )


def warm_up(study: Results) -> str:
    """What is not counted: one time for all designs, or found for each."""
    times, unit = study.warm_ups.values(), study.base.units.time
    if not times:
        return f"{number(study.base.run.warm_up)} {unit}, not counted"
    return f"{number(min(times))} to {number(max(times))} {unit}, found for each design, not counted"


def target(goal: Target) -> str:
    """A target as people write it: shares in per cent, times and lengths with their unit."""
    return f"{goal.indicator} {goal.sense} {amount(goal.indicator, goal.value)}{' ' * bool(goal.unit)}{goal.unit}"


def amount(indicator: str, value: float) -> str:
    """A value of an indicator, shares in per cent."""
    return f"{100 * value:.4g} %" if is_share(indicator) else number(value)


def interval_text(indicator: str, estimate: Estimate, unit: str = "") -> str:
    """A mean with the ends of its interval, rounded alike; shares in per cent."""
    if is_share(indicator):
        return share_text(estimate)
    of = f" {unit}" if unit else ""
    if estimate.interval is None:
        return f"{number(estimate.mean)}{of} ({'exact' if estimate.deterministic else 'one run'})"
    low, high = estimate.interval
    digits = decimals((high - low) / 2)
    return f"{number(estimate.mean, digits)}{of} ({number(low, digits)} to {number(high, digits)})"


def share_text(estimate: Estimate) -> str:
    """A share in per cent, with the ends of its interval, and the share of all tasks where that is another number."""
    digits = 1
    if estimate.interval is None:
        ends = "exact" if estimate.deterministic else "one run"
    else:
        low, high = (100 * end for end in estimate.interval)
        digits = min(max(decimals((high - low) / 2) - 1, 0), 3) if high > low else 1
        ends = f"{_percent(low, digits)} to {_percent(high, digits)}"
    mean = _percent(100 * estimate.mean, digits)
    all_tasks = mean if estimate.of_all is None else _percent(100 * estimate.of_all, digits)
    return f"{mean} % ({ends}" + (")" if all_tasks == mean else f"; of all tasks {all_tasks} %)")


def _percent(value: float, digits: int) -> str:
    """A share in per cent; that all or none of it is so needs no decimals."""
    return number(value, 0 if value in {0.0, 100.0} else digits)
