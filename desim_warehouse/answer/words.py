"""Names and units for people, shared by figures, tables and sentences; `numbers` formats numbers.

For all sentences, tables, figures and pages.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

from desim_warehouse.answer.numbers import PERCENT, Scale, duration, number, plural, times
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model import Model
from desim_warehouse.model.facts.keys import about
from desim_warehouse.model.facts.people import COUNTED
from desim_warehouse.model.schema import Units
from desim_warehouse.outcome.indicators import look_up, split
from desim_warehouse.outcome.targets import Target
from desim_warehouse.policies.catalogue import title_of
from desim_warehouse.states import TIMES
from desim_warehouse.values.labels import plain, readable
from desim_warehouse.values.units import SECONDS


class HasMean(Protocol):
    """Anything that has a mean, such as an estimate."""

    @property
    def mean(self) -> float:
        """The mean."""


_COLUMNS = {"run_time": ("Computing time of a run", "s")}
"""Titles and units of columns of a study table that are not indicators."""
STATE_WORDS = {name: state.doing for name, state in TIMES.items()}
"""Labels of the states of robots."""

_OF_THE_MODEL = {
    "time": "{time}",
    "length": "{length}",
    "speed": "{length} per {time}",
    "acceleration": "{length} per {time}^2",
    "power": "energy per {time}",
}
_OF_ALL = {"rate": "per hour", "angle": "degrees", "weighted": "", "tasks": ""}
"""Units by kind of quantity; any other kind is its own unit."""
_BOUNDS = {">=": "at least", "<=": "at most", ">": "more than", "<": "less than"}
_AIMS = {
    "on_time": "{} on time",
    "worked_on_time": "{} worked on in time",
    "orders_on_time": "{} of orders on time",
    "throughput_per_hour": "{}",
    "annual_cost": "{} a year",
    "robots_busy": "robots busy {}",
    "server_utilisation": "server utilisation {}",
    "worker_utilisation": "worker utilisation {}",
    "charger_utilisation": "charger utilisation {}",
}
"""Phrases of targets that differ from the indicator's name and value, by indicator."""
_RATE = "tasks per hour"
"""The unit of throughput, written `60 tasks an hour` in targets, and `tasks/h` beside intervals and in tables."""
_SAID_ALONE = "relief"
"""The factor of `desim why`, whose cases are shown without its name, such as `one robot more`."""
_LONGEST = 44
"""Longest label, in characters; longer labels are cut."""


def unit(kind: str, units: Units | None, seconds: bool = False) -> str:
    """Return the unit of a kind of quantity in the model; empty for counts and shares, or without a model."""
    if kind in ("count", "ratio", "share"):
        return ""
    if kind == "time" and seconds:
        return "s"
    if kind in _OF_THE_MODEL:
        return _OF_THE_MODEL[kind].format(length=units.length, time=units.time) if units else ""
    return _OF_ALL.get(kind, kind)


def indicator_kind(indicator: str) -> str:
    """Return the kind of unit of an indicator, such as time, length or count; empty for other columns."""
    measure = look_up(indicator)
    return measure.unit if measure else _COLUMNS.get(indicator, ("", ""))[1]


def is_share(indicator: str) -> bool:
    """Whether values of an indicator are shares, shown in per cent."""
    measure = look_up(indicator)
    return measure is not None and measure.is_share


def indicator_name(indicator: str) -> str:
    """Return the title of an indicator; for other columns, their title or name."""
    measure = look_up(indicator)
    return measure.title if measure else _COLUMNS.get(indicator, (indicator, ""))[0]


def in_sentence(indicator: str) -> str:
    """Return an indicator's name for use inside a sentence: `task time T`, `mean cycle time`."""
    what, _, how = indicator_name(indicator).rpartition(", ")
    name = f"mean {what[:1].lower()}{what[1:]}" if how == "mean" else indicator_name(indicator)
    return f"{name[:1].lower()}{name[1:]}"


def indicator_label(indicator: str, units: Units | None, seconds: bool = False) -> str:
    """Return the name and unit of an indicator, for an axis: `Task time T (step)`."""
    return with_unit(indicator_name(indicator), unit(indicator_kind(indicator), units, seconds))


def factor_unit(key: str, units: Units | None) -> str:
    """Return the unit of a factor's values; empty without a unit, and for cases."""
    factor = about(key)
    return unit(factor.kind, units) if factor else ""


def factor_name(key: str) -> str:
    """Name a factor for legends and heads of tables: `Chargers in parking`; cases keep their names."""
    name = in_words(key)
    return name if name == key else f"{name[0].upper()}{name[1:]}"


def in_words(key: str) -> str:
    """Name a factor inside a sentence: `chargers in parking`; cases keep their names."""
    factor = about(key)
    return factor.label if factor else key


def factor_head(key: str, units: Units | None) -> str:
    """Return a factor and its unit, for the head of a table: `Time between breakdowns (s)`."""
    return with_unit(factor_name(key), factor_unit(key, units))


def factor_label(key: str, units: Units | None) -> str:
    """Return a factor, its key if there is room, and its unit, for an axis: `Number of robots, fleet.size`."""
    name = factor_name(key)
    both = f"{name}, {key}"
    return with_unit(both if name != key and len(both) <= _LONGEST else name, factor_unit(key, units))


def averaged(factors: Sequence[str]) -> str:
    """Return the second line of an axis label, which names the factors averaged over; empty without factors."""
    return f"\naveraged over {', '.join(factors)}" if factors else ""


def with_unit(name: str, unit: str) -> str:
    """Return a label with its unit in brackets, if there is one."""
    return f"{name} ({unit})" if unit else name


def level(value: Any) -> str:
    """Return a value of a factor as text, short enough for a label."""
    value = plain(value)
    if value is None:
        return "none"
    if isinstance(value, float):
        return f"{value:g}"
    text = _without_folder(readable(value))
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


def design_spoken(design: Mapping[str, Any]) -> str:
    """Return a design point in words: `6 robots and 2 chargers, battery threshold 2`."""
    counts = [number_of(n, what) for key, n in design.items() if (what := _counted(key, n))]
    others = [setting(key, v) for key, v in design.items() if not _counted(key, v)]
    return ", ".join([*([spoken(counts)] if counts else []), *others]) or "the model as it is"


def setting(key: str, value: Any) -> str:
    """Return a key of the model with a value, in words: `dispatching: nearest`, `goods 20 random`."""
    factor = about(key)
    if factor is None:
        return level(value) if key == _SAID_ALONE else f"{key}: {level(value)}"
    text = named_policy(value) if key.startswith("policies.") and isinstance(value, str) else level(value)
    return f"{factor.label}{':' * isinstance(value, str)} {text}"


def _counted(key: str, value: Any) -> str:
    """Return the singular noun for the things that a factor counts; empty if it is not a count."""
    if not str(value).isdecimal():
        return ""
    return COUNTED.get("chargers" if key.endswith(".total_chargers") else key, "")


def in_unit(value: float, unit: str) -> str:
    """Return a quantity in the unit of a model: `20,000 steps`."""
    return f"{number(value)} {plural(unit, value)}".strip()


def target(goal: Target) -> str:
    """Return a target in words: `at least 95 % on time`, `mean cycle time at most 5 min`."""
    return reached(goal.indicator, f"{_BOUNDS[goal.sense]} {amount(goal.indicator, goal.value, goal.unit)}")


def reached(indicator: str, value: str) -> str:
    """Return a value of an indicator for use in a sentence: `97.4 % on time`, `mean cycle time 3.7 min`."""
    base, _, _ = split(indicator)
    if base in _AIMS:
        return f"{_AIMS[base].format(value)}{indicator_name(indicator).removeprefix(indicator_name(base))}"
    return f"{in_sentence(indicator)} {value}"


def amount(indicator: str, value: float, unit: str = "") -> str:
    """Format a bound of an indicator, shares in per cent and times in a suitable unit."""
    if is_share(indicator):
        return f"{100 * value:.4g} %"
    kind = indicator_kind(indicator)
    scale = times(unit, (value,)) if kind == "time" else Scale("tasks an hour" if kind == _RATE else unit)
    return in_unit(scale.by * value, scale.unit)


def scale(indicator: str, model: Model | None, values: Iterable[float] = ()) -> Scale:
    """Return the scale of an indicator: shares in per cent, times in a unit that suits the values."""
    return PERCENT if is_share(indicator) else scale_of_kind(indicator_kind(indicator), model, values)


def scale_of_kind(kind: str, model: Model | None, values: Iterable[float] = ()) -> Scale:
    """Return the scale of a kind of quantity, such as time, share or money; times in a unit that suits the values."""
    if kind == "share":
        return PERCENT
    if kind == "time" and model is not None:
        return times(model.units.time, values)
    if kind == "capacity per hour":
        return Scale("% an hour", 100.0)
    if kind == _RATE:
        return Scale("tasks/h")
    if kind.startswith("money"):
        return Scale(money(model))
    return Scale("" if kind == "energy" else unit(kind, model.units if model else None))


def value(indicator: str, value: float, model: Model) -> str:
    """Format a value of a run with its unit; times in a unit of the model's own also in s, min or h.

    Such as `120 steps (6 s)`.
    """
    text = scale(indicator, model, (value,)).value(value)
    if indicator_kind(indicator) != "time" or model.units.time in SECONDS or not math.isfinite(value):
        return text
    return f"{text} ({duration(value * model.units.seconds, 's')})"


def scale_of(indicator: str, model: Model | None, estimates: Iterable[HasMean | None]) -> Scale:
    """Return one scale for all estimates of a column."""
    return scale(indicator, model, [estimate.mean for estimate in estimates if estimate is not None])


def head(indicator: str, scale: Scale) -> str:
    """Return an indicator and the unit of its scale, for the head of a table; shares have `%` in the cells."""
    return with_unit(indicator_name(indicator), "" if scale.is_share else scale.unit)


def load(model: Model) -> str:
    """Return the word for a task of a model: a load, or with pods a line."""
    return "load" if model.pods is None else "line"


def loads(model: Model) -> str:
    """Return the word for tasks of a model: loads, or with pods lines."""
    return f"{load(model)}s"


def batteries_end_lower(lost: float) -> str:
    """Return the sentence on batteries that end a day lower than they begin it; `lost`: share of the capacity."""
    share = PERCENT.value(lost)
    return f"The day costs batteries {share} of their capacity, and no night fills them: later days begin lower."


def money(model: Model | None) -> str:
    """Return the currency of a model; empty if it names none."""
    return (model.prices.currency or "") if model is not None and model.prices is not None else ""


def policy(key: str, name: str) -> str:
    """Describe a policy with its name and parameters: `the nearest robot (nearest)`."""
    title = title_of(key.removeprefix("policies."), name.partition("(")[0])
    return named_policy(name) if title is None else f"{title} ({named_policy(name)})"


def named_policy(name: str) -> str:
    """Return the name of a policy with its parameters: `time-window, window 60`; a user's policy without its folder."""
    base, _, parameters = name.partition("(")
    if not parameters or ".py:" in name:
        return _without_folder(name)
    return f"{base}, {parameters.removesuffix(')').replace('=', ' ')}"


def _without_folder(name: str) -> str:
    """Return the name of a user's policy, such as `folder/my_policies.py:Patient`, without the folder."""
    return name.replace("\\", "/").rpartition("/")[2] if ".py:" in name else name
