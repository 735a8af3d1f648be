"""Parts of an answer: a number with its one interval, a tile, the figure, and the design that it is about."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from desim_warehouse.answer import words
from desim_warehouse.answer.numbers import Scale
from desim_warehouse.answer.parts import Bar, BigNumber, Rows, SaidNumber, Subject
from desim_warehouse.model import Model
from desim_warehouse.outcome.targets import Target
from desim_warehouse.study.plan import run_seed
from desim_warehouse.study.statistics.judge import DesignVerdict


def number(one: DesignVerdict[Any], target: Target, model: Model) -> SaidNumber:
    """The mean of a design that was judged, with the bounds of the verdict."""
    scale = words.scale(target.indicator, model, (one.mean,))
    return within(target.indicator, scale, (one.mean, one.low, one.high), target.value)


def within(
    of: str, scale: Scale, found: tuple[float, float | None, float | None], aim: float | None = None
) -> SaidNumber:
    """A mean with the ends of its interval; none where both are None or as the mean, as it is exact."""
    mean, low, high = found
    known = low is not None and high is not None and not math.isnan(low) and low < high
    if not known or low is None or high is None:
        return SaidNumber(of=of, mean=mean, text=scale.value(mean))
    return SaidNumber(of=of, mean=mean, low=low, high=high, text=scale.within(mean, low, high, aim))


def bar(label: str, found: SaidNumber, standing: str = "") -> Bar:
    """A row of a figure, for a number."""
    return Bar(label=label, mean=found.mean, low=found.low, high=found.high, text=found.text, standing=standing)


def figure(title: str, bars: Iterable[Bar], at: float, at_words: str) -> Rows | None:
    """Rows beside a line at some value; None where there are none."""
    rows = tuple(bars)
    return Rows(title=title, at=at, at_words=at_words, rows=rows) if rows else None


def aim(goal: Target) -> str:
    """What stands at the line of a target in a figure: `target 95 %`."""
    return f"target {words.amount(goal.indicator, goal.value, goal.unit)}"


def promise(what: str, confidence: float, *, exact: bool) -> str:
    """How sure all numbers or verdicts of an answer are."""
    if exact:
        return "Nothing in this model is random: one run of each option is exact."
    return f"All {what} hold at once with {100 * confidence:g} % confidence."


def each(confidence: float) -> str:
    """How sure intervals are, each by itself."""
    return f"Each interval holds with {100 * confidence:g} % confidence."


def tile(text: str, what: str) -> BigNumber:
    """The text of a number as a large one, its interval as the note."""
    value, _, ends = text.partition(" (")
    return BigNumber(value=value, what=what, note=ends.removesuffix(")"))


def about(name: str, model: Model, seed: int) -> Subject:
    """What the page shows: the first run of a design."""
    return Subject(name=name, model=model.content(), seed=run_seed(seed, 0))
