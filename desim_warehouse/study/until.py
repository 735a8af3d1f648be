"""Reading how often to replicate: until the mean of an indicator is known well enough."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

from desim_warehouse.model import outline
from desim_warehouse.model.problems import Problem, got
from desim_warehouse.study.indicators import INDICATORS
from desim_warehouse.study.plan import Until

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from desim_warehouse.study.factors import Keys

_KEYS = ("indicator", "half_width", "confidence", "minimum", "cap")


def read_until(section: Mapping[str, Any], problems: list[Problem]) -> Until | None:
    """The rule that a section `replications` describes; what is wrong with it goes to `problems`."""
    before = len(problems)
    for key in section:
        if key not in _KEYS:
            near = outline.nearest(key, _KEYS)
            hint = f"did you mean '{near}'?" if near else f"expected {outline.spoken(_KEYS, 'or')}"
            problems.append(Problem(("replications", key), f"unknown key, {hint}", at_key=True))

    def part(key: str, expected: str, reads: Callable[[Any], Any], default: Any = None) -> Any:
        value = section.get(key, default)
        keys: Keys = ("replications", key)
        if value is None:
            problems.append(Problem(keys, f"missing, expected {expected}", missing=True))
            return default
        made = reads(value)
        if made is None:
            problems.append(Problem.of(keys, "not understood", value, expected))
        return made

    cap = part("cap", "a whole number of at least 2", _at_least_two, 200)
    made = Until(
        indicator=part("indicator", "the name of an indicator", _text),
        half_width=part("half_width", "a share of the mean, such as 2 % or 0.02", _share),
        confidence=part("confidence", "a number between 0 and 1, such as 0.95", _share, 0.95),
        minimum=part("minimum", "a whole number of at least 2", _at_least_two, min(30, cap)),
        cap=cap,
    )
    if made.indicator is not None:
        is_indicator(("replications", "indicator"), made.indicator, problems)
    if before == len(problems) and made.minimum > made.cap:
        expected = f"at least {made.minimum}"
        problems.append(Problem.of(("replications", "cap"), "below the minimum", made.cap, expected))
    return made if before == len(problems) else None


def is_indicator(keys: Keys, name: Any, problems: list[Problem]) -> bool:
    """See that there is such an indicator."""
    if name in INDICATORS:
        return True
    near = outline.nearest(str(name), INDICATORS)
    hint = f"did you mean '{near}'?" if near else f"expected one of {', '.join(INDICATORS)}"
    problems.append(Problem(keys, f"unknown indicator (got {got(name)}), {hint}"))
    return False


def is_number(value: Any, *, whole: bool = False) -> bool:
    """Whether a value is a finite number, or a whole one."""
    if isinstance(value, bool) or not isinstance(value, int if whole else int | float):
        return False
    return math.isfinite(value)


def _text(value: Any) -> str | None:
    return value if isinstance(value, str) else None


def _share(value: Any) -> float | None:
    """A share of 1, given as 0.02 or as 2 %."""
    if isinstance(value, str) and (match := re.fullmatch(r"\s*(\d+\.?\d*|\.\d+)\s*%\s*", value)):
        value = float(match[1]) / 100
    return float(value) if is_number(value) and 0 < value < 1 else None


def _at_least_two(value: Any) -> int | None:
    return int(value) if is_number(value, whole=True) and value >= 2 else None  # noqa: PLR2004
