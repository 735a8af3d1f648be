"""What designs cost against what they reach: a mark for each, and the front of those that none beats in both."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.report import palette
from desim_warehouse.report.plot import style as look
from desim_warehouse.report.text import words

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from desim_warehouse.study.designs.best_of_many import BestOfMany

Mark = tuple[float, float]


def trade_off(
    found: BestOfMany, *, title: str | None = None, style: look.Style = "light", ax: Axes | None = None
) -> Axes:
    """The target's indicator against the one that should be best, for each design that a search tried.

    The line joins the front: designs that no other beats in both. Without a target designs stand in the order in which
    they were tried. The mark of the best has its value on fresh days.
    """
    goal = found.target
    known = [one for one in found.tried if math.isfinite(one.mean)]
    across = [float(rank + 1) for rank in range(len(known))] if goal is None else [_at(one.reached) for one in known]
    scale = words.scale(found.indicator, found.model, [one.mean for one in known])
    other = None if goal is None else words.scale(goal.indicator, found.model, [x for x in across if math.isfinite(x)])
    by = 1.0 if other is None else other.by
    marks = [(by * x, scale.by * one.mean) for x, one in zip(across, known, strict=True) if math.isfinite(x)]
    name = words.indicator_name(found.indicator)
    alt = f"{name} of the options tried" + ("" if goal is None else f", against {words.in_sentence(goal.indicator)}")
    with look.drawing(ax, style, title, (6.4, 4.0), alt) as axes:
        axes.plot(*_columns(marks), linestyle="none", marker="o", color=palette.FAINT, label="tried")
        if goal is not None and other is not None:
            line = front(marks, goal.sign, 1.0 if found.maximise else -1.0)
            axes.plot(*_columns(line), marker="o", color=palette.COLOURS[0], label="front")
            bound = by * goal.value
            axes.axvline(bound, linestyle="--", color=palette.INK, label=look.text(words.target(goal)))
            axes.set_xlabel(look.text(words.with_unit(words.indicator_name(goal.indicator), other.unit)))
        else:
            axes.set_xlabel("Designs in the order in which they were tried")
        if found.best.value is not None:
            best = found.best.value.mean
            reached = found.best.reached.mean if found.best.reached is not None else 0.0
            x = by * reached if goal is not None else float(len(known))
            y, what = scale.by * best, "winner, checked on new days"
            axes.plot([x], [y], linestyle="none", marker="*", markersize=14, color=palette.COLOURS[1], label=what)
        axes.set_ylabel(look.text(words.with_unit(name, scale.unit)))
        look.legend(axes, 2)
        return axes


def front(marks: Sequence[Mark], across: float, upwards: float) -> list[Mark]:
    """The marks that no other beats in both directions, from left to right; -1: less is better in a direction."""
    kept: list[Mark] = []
    for mark in sorted(set(marks), key=lambda one: (-across * one[0], -upwards * one[1])):
        if not kept or upwards * mark[1] > upwards * kept[-1][1]:
            kept.append(mark)
    return sorted(kept)


def _at(value: float | None) -> float:
    return math.nan if value is None else value


def _columns(marks: Sequence[Mark]) -> tuple[list[float], list[float]]:
    return [x for x, _ in marks], [y for _, y in marks]
