"""Formatting of numbers for people: only significant digits, shares in per cent, times in a suitable unit.

For all sentences, tables and pages.

Only an end of an interval that would look equal to the target gets more digits: one more digit for all three numbers
widened tables, and with more digits everywhere nobody reads them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from desim_warehouse.errors import number_of
from desim_warehouse.values.units import SECONDS

NONE = "–"
"""Where there is no value."""
_SMALLEST_P = 0.001
_NEAR = 0.01
"""Shares nearer to none or all than this have more than one decimal."""
_EXACT = 1e-4
"""An interval narrower than this part of the mean is none."""
_FEW = 5
"""Runs below which it is said beside an interval that there are so few, where they all agree."""
_MORE = 3
"""The most decimals more that an end of an interval has so that it does not look like 0."""
_SAME = 1e-11
"""Numbers that differ by less, as a part of them, are the same."""
_FINEST = 12
"""The most decimals of what lies close to a target."""
_LIMITS = {"s": 90.0, "min": 5400.0, "h": 129_600.0}
"""The seconds up to which times are said in a unit."""
_MOMENT = 0.01
"""Times that last no longer, in any unit, have no digits worth saying."""
_LONG_NAME = 4
"""Letters from which the name of a unit is a word, with a plural."""


class Mean(Protocol):
    """A mean with its interval, as `study.statistics.Estimate` is one."""

    @property
    def n(self) -> int:
        """Number of runs."""

    @property
    def mean(self) -> float:
        """Mean of these runs."""

    @property
    def interval(self) -> tuple[float, float] | None:
        """Ends of its confidence interval, if there is one."""

    @property
    def half_width(self) -> float | None:
        """Longer side of the interval, from the mean."""

    @property
    def sd(self) -> float | None:
        """Standard deviation of the runs; 0 if all of them agree."""

    @property
    def deterministic(self) -> bool:
        """Whether the runs use no random numbers, so that the mean is exact."""


def number(value: float, digits: int | None = None) -> str:
    """Format a number with separated thousands: four significant digits, or so many decimals (−2: whole hundreds)."""
    if not value:
        return "0"
    if not math.isfinite(value):
        return NONE if math.isnan(value) else ("∞" if value > 0 else "−∞")
    if digits is None:
        whole = float(value).is_integer() and abs(value) < 1e15  # noqa: PLR2004 - beyond, floats skip
        digits = 0 if whole else max(0, 3 - math.floor(math.log10(abs(value))))
        shown = f"{value:,.{digits}f}"
        shown = shown.rstrip("0").rstrip(".") if "." in shown else shown
    else:
        shown = f"{round(value, digits):,.{max(digits, 0)}f}"
    return shown.replace("-", "−") if float(shown.replace(",", "")) else shown.removeprefix("-")


def measured(value: float) -> str:
    """Format a value of one run: three significant digits, and all before the point."""
    if not value or not math.isfinite(value):
        return number(value)
    shown = number(value, max(0, 2 - math.floor(math.log10(abs(value)))))
    return shown.rstrip("0").rstrip(".") if "." in shown else shown


def decimals(half_width: float) -> int:
    """Decimals at which a half-width shows two significant digits; below 0 where these stand before the point."""
    if not half_width or not math.isfinite(half_width):
        return 0
    return 1 - math.floor(math.log10(abs(half_width)))


def within(mean: float, low: float, high: float) -> str:
    """Format a mean with the ends of its interval, to the digits that its width allows: `1.299 (1.298 to 1.301)`."""
    if math.isnan(low):
        return measured(mean)
    half = (high - low) / 2
    digits = decimals(half) if _EXACT * abs(mean) < half < math.inf else None
    texts = [measured(value) if digits is None else number(value, digits) for value in (mean, low, high)]
    return f"{texts[0]} ({texts[1]} to {texts[2]})"


def p_value(p: float | None) -> str:
    """Format a p-value: three decimals are enough for any decision."""
    if p is None:
        return NONE
    return f"< {_SMALLEST_P}" if p < _SMALLEST_P else "1" if p > 1 - _SMALLEST_P / 2 else f"{p:.3f}"


def percent(share: float, digits: int = 1) -> str:
    """Format a share in per cent, without the sign: `97.4`; 0 and 100 have no decimals."""
    return number(100 * share, 0 if share in {0.0, 1.0} else digits)


def least(value: float, digits: int, whole: float = math.inf) -> str:
    """Format a number, but never as 0 or the whole where it is not quite: `under 0.1`, `over 99.9`."""
    step = 10.0**-digits
    if 0 < value < step / 2:
        return f"under {number(step, digits)}"
    if whole - step / 2 <= value < whole:
        return f"over {number(whole - step, digits)}"
    return number(value, 0 if value in {0.0, whole} else digits)


@dataclass(frozen=True)
class Scale:
    """How the values of an indicator are written: `by` times as large, with their unit; shares as per cent."""

    unit: str = ""
    by: float = 1.0
    is_share: bool = False

    def value(self, value: float) -> str:
        """Format a value of one run with its unit: `3.71 min`, `97.4 %`."""
        return self._with_unit(self.bare(value), self.by * value)

    def bare(self, value: float) -> str:
        """Format a value of one run without its unit: `3.71`, `97.4`."""
        return least(100 * value, 1, 100) if self.is_share else measured(self.by * value)

    def single(self, value: float) -> str:
        """Format a value for the cell of a table whose head has the unit; a share has `%` in the cell instead."""
        return self.value(value) if self.is_share else self.bare(value)

    def estimate(self, mean: Mean, target: float | None = None) -> str:
        """Return a mean with its unit and the ends of its confidence interval: `97.4 % (97.1 to 97.7)`.

        An end that would look equal to `target` gets more digits.
        """
        if mean.interval is None:
            return f"{self.value(mean.mean)} ({'exact' if mean.deterministic else 'one run'})"
        few = f", {number_of(mean.n, 'run')}" if not mean.sd and mean.n < _FEW else ""
        return self.within(mean.mean, *mean.interval, target) + few

    def within(self, mean: float, low: float, high: float, target: float | None = None) -> str:
        """Return a mean with its unit and the ends of its interval, to the digits needed: `97.4 % (97.1 to 97.7)`.

        None of them is written as the target, or as 0 or 100 %, that is not exactly so.
        """
        unit = plural(self.unit, self.by * mean)
        digits = self._digits(mean, low, high)
        shown, first, last = (self._apart(value, digits, target) for value in (mean, low, high))
        return f"{shown}{f' {unit}' if unit else ''} ({first} to {last})"

    def _digits(self, mean: float, low: float, high: float) -> int:
        """Return the number of decimals for an interval of this width."""
        if not self.is_share:
            return decimals(self.by * max(mean - low, high - mean))
        most = 1 if low > _NEAR and high < 1 - _NEAR else 3
        return min(max(decimals(self.by * (high - low) / 2) - 1, 0), most) if high > low else 1

    def _apart(self, value: float, digits: int, target: float | None) -> str:
        """Format a value with at least `digits` decimals, and enough to differ from the target, 0 and 100 %."""
        aims = [aim for aim in (target, *((0.0, 1.0) if self.is_share else ())) if aim is not None]
        others = [self.by * aim for aim in aims if not math.isclose(value, aim, rel_tol=_SAME, abs_tol=_SAME)]
        if self.is_share and _SAME < value < 1 - _SAME and round(100 * value, _MORE) in {0.0, 100.0}:
            step = 10.0**-_MORE  # beyond it nobody cares, but it is not all or none
            return number(step if value < 0.5 else 100 - step, _MORE)  # noqa: PLR2004
        while digits < _FINEST and any(round(self.by * value, digits) == round(aim, digits) for aim in others):
            digits += 1
        return self._rounded(value, digits)

    def _rounded(self, value: float, digits: int) -> str:
        return percent(value, digits) if self.is_share else number(self.by * value, digits)

    def _with_unit(self, text: str, value: float) -> str:
        return f"{text} {plural(self.unit, value)}" if self.unit and text != NONE else text


PERCENT = Scale("%", 100.0, is_share=True)


def plural(unit: str, value: float) -> str:
    """Return a unit behind a number: words have a plural (`2 steps`), abbreviations have none (`2 min`)."""
    is_word = unit.isalpha() and len(unit) >= _LONG_NAME and not unit.endswith("s")
    return f"{unit}s" if is_word and value != 1 else unit


def times(unit: str, values: Iterable[float]) -> Scale:
    """Return the scale for times in a unit of a model: s, min, h or d by the largest of them; any other unit stays."""
    if unit not in SECONDS:
        return Scale(unit)
    in_seconds = float(SECONDS[unit])
    most = max((abs(value) for value in values if math.isfinite(value)), default=0.0) * in_seconds
    fit = next((name for name, limit in _LIMITS.items() if most < limit), "d") if most else unit
    return Scale(fit, in_seconds / float(SECONDS[fit]))


def duration(time: float, unit: str) -> str:
    """Return a time as people say it: `4 h`, `3.7 min`, `8.1 s`."""
    scale = times(unit, (time,))
    value = scale.by * time
    if 0 < value < _MOMENT:
        return f"under {number(_MOMENT)} {scale.unit}"
    digits = 0 if abs(value) >= 10 else 1 if abs(value) >= 1 else decimals(value)  # noqa: PLR2004 - two digits
    shown = number(value, digits)
    return f"{shown.rstrip('0').rstrip('.') if '.' in shown else shown} {plural(scale.unit, value)}"


def sentence(line: str) -> str:
    """Return a line as a sentence, with a capital and a full stop."""
    return capital(f"{line}.")


def capital(line: str) -> str:
    """Return a sentence with a capital."""
    return f"{line[:1].upper()}{line[1:]}"
