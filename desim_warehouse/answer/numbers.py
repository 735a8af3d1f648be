"""Format numbers for people, with significant digits only, shares in per cent, and times in a suitable unit.

For all sentences, tables and pages.

Only an end of an interval that would look equal to the target gets more digits. Another digit for all three numbers
made tables wider, and numbers with many digits are not read.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from desim_warehouse.errors import number_of
from desim_warehouse.values.units import SECONDS

NONE = "–"
"""The text for a missing value."""
_SMALLEST_P = 0.001
_NEAR = 0.01
"""Distance from 0 or 100 % within which shares have more than one decimal."""
_EXACT = 1e-4
"""Half-width, relative to the mean, up to which an interval does not set the digits."""
_FEW = 5
"""Number of runs below which an interval of equal runs is shown with their number."""
_MORE = 3
"""Decimals, in per cent, of shares that are close to 0 or 100 % but not equal."""
_SAME = 1e-11
"""Tolerance within which numbers count as equal."""
_FINEST = 12
"""Largest number of decimals for a value close to a target."""
_LIMITS = {"s": 90.0, "min": 5400.0, "h": 129_600.0}
"""Longest time for which a unit is used, in seconds."""
_MOMENT = 0.01
"""Shortest duration that is written with its digits, in its unit."""
_LONG_NAME = 4
"""Number of letters from which the name of a unit is a word, with a plural."""


class Mean(Protocol):
    """A mean with its interval, such as `study.statistics.Estimate`."""

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
    """Format a number with separated thousands.

    `digits`: number of decimals (−2: whole hundreds); None for four significant digits.
    """
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
    """Format a value of one run with three significant digits, or all digits before the point."""
    if not value or not math.isfinite(value):
        return number(value)
    shown = number(value, max(0, 2 - math.floor(math.log10(abs(value)))))
    return shown.rstrip("0").rstrip(".") if "." in shown else shown


def decimals(half_width: float) -> int:
    """Return the decimals for two significant digits of a half-width; negative if these are before the point."""
    if not half_width or not math.isfinite(half_width):
        return 0
    return 1 - math.floor(math.log10(abs(half_width)))


def within(mean: float, low: float, high: float) -> str:
    """Format a mean with the ends of its interval, with digits by its width: `1.299 (1.298 to 1.301)`."""
    if math.isnan(low):
        return measured(mean)
    half = (high - low) / 2
    digits = decimals(half) if _EXACT * abs(mean) < half < math.inf else None
    texts = [measured(value) if digits is None else number(value, digits) for value in (mean, low, high)]
    return f"{texts[0]} ({texts[1]} to {texts[2]})"


def p_value(p: float | None) -> str:
    """Format a p-value with three decimals, which are enough for any decision."""
    if p is None:
        return NONE
    return f"< {_SMALLEST_P}" if p < _SMALLEST_P else "1" if p > 1 - _SMALLEST_P / 2 else f"{p:.3f}"


def percent(share: float, digits: int = 1) -> str:
    """Format a share in per cent, without the sign: `97.4`; 0 and 100 have no decimals."""
    return number(100 * share, 0 if share in {0.0, 1.0} else digits)


def least(value: float, digits: int, whole: float = math.inf) -> str:
    """Format a number, but as 0 or as the whole only if it is exact, else as `under 0.1` or `over 99.9`."""
    step = 10.0**-digits
    if 0 < value < step / 2:
        return f"under {number(step, digits)}"
    if whole - step / 2 <= value < whole:
        return f"over {number(whole - step, digits)}"
    return number(value, 0 if value in {0.0, whole} else digits)


@dataclass(frozen=True)
class Scale:
    """A format for the values of an indicator, which are multiplied by `by` and shown with `unit`."""

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
        """Format a value for a cell below a head with the unit; shares have `%` in the cell instead."""
        return self.value(value) if self.is_share else self.bare(value)

    def estimate(self, mean: Mean, target: float | None = None) -> str:
        """Format a mean with its unit and its confidence interval: `97.4 % (97.1 to 97.7)`.

        An end that would look equal to `target` gets more digits.
        """
        if mean.interval is None:
            if mean.n > 1 and not mean.deterministic:
                return self.agreeing(mean.mean, mean.n)
            return f"{self.value(mean.mean)} ({'exact' if mean.deterministic else 'one run'})"
        few = f", {number_of(mean.n, 'run')}" if not mean.sd and mean.n < _FEW else ""
        return self.within(mean.mean, *mean.interval, target) + few

    def agreeing(self, value: float, runs: int) -> str:
        """Format a value that random runs agree in and that has no interval: `0 s (the same in all 5 runs)`."""
        return f"{self.value(value)} (the same in all {runs} runs)"

    def within(self, mean: float, low: float, high: float, target: float | None = None) -> str:
        """Format a mean with its unit and the ends of its interval, to the digits needed: `97.4 % (97.1 to 97.7)`.

        A number looks like the target, 0 or 100 % only if it is equal to it.
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
        """Format a value with at least `digits` decimals, and enough to distinguish it from the target, 0 and 100 %."""
        aims = [aim for aim in (target, *((0.0, 1.0) if self.is_share else ())) if aim is not None]
        others = [self.by * aim for aim in aims if not math.isclose(value, aim, rel_tol=_SAME, abs_tol=_SAME)]
        if self.is_share and _SAME < value < 1 - _SAME and round(100 * value, _MORE) in {0.0, 100.0}:
            step = 10.0**-_MORE  # more digits do not matter, but the share is not 0 or 100 %
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
    """Return the unit after a number; words have a plural (`2 steps`), abbreviations have none (`2 min`)."""
    is_word = unit.isalpha() and len(unit) >= _LONG_NAME and not unit.endswith("s")
    return f"{unit}s" if is_word and value != 1 else unit


def times(unit: str, values: Iterable[float]) -> Scale:
    """Return the scale for times in a unit of a model: s, min, h or d by the largest value; other units stay."""
    if unit not in SECONDS:
        return Scale(unit)
    in_seconds = float(SECONDS[unit])
    most = max((abs(value) for value in values if math.isfinite(value)), default=0.0) * in_seconds
    fit = next((name for name, limit in _LIMITS.items() if most < limit), "d") if most else unit
    return Scale(fit, in_seconds / float(SECONDS[fit]))


def duration(time: float, unit: str) -> str:
    """Format a duration: `4 h`, `3.7 min`, `8.1 s`."""
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
    """Return a line with a capital first letter."""
    return f"{line[:1].upper()}{line[1:]}"
