"""Targets as users write them, with shares in per cent."""

from __future__ import annotations

import re
from dataclasses import replace

from desim_warehouse.errors import StudyError
from desim_warehouse.outcome.indicators import INDICATORS, find, look_up
from desim_warehouse.study import statistics

_PERCENT = re.compile(r"([\d.]+)\s*%\s*$")


def read_target(text: str) -> statistics.Target:
    """A target as users write it, with shares as 0.95 or as 95 %.

    Raises:
        StudyError: not a target, or a share outside 0 to 1.
    """
    percent = _PERCENT.search(text)
    goal = statistics.parse_target(text[: percent.end(1)] if percent else text)
    if look_up(goal.indicator) is None:
        statistics.parse_target(text[: percent.end(1)] if percent else text, INDICATORS)  # says what is meant
    if not find(goal.indicator).is_share:
        if percent:
            raise StudyError(f"target {text!r}: {goal.indicator} is no share, expected a number without %")
        return goal
    goal = replace(goal, value=goal.value / 100) if percent else goal
    if not 0 <= goal.value <= 1:
        meant = f"; did you mean {goal.value:g} %?" if not percent and 1 < goal.value <= 100 else ""  # noqa: PLR2004
        raise StudyError(f"target {text!r}: {goal.indicator} is a share, expected a number from 0 to 1, or a %{meant}")
    return goal
