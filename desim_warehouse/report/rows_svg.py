"""Rows of intervals or bars as an inline drawing: every row has its words and its number beside it, as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.errors import number_of
from desim_warehouse.outcome.account import OF_ROBOTS, OF_TASKS, counted_tasks
from desim_warehouse.report import html
from desim_warehouse.report.answer import Bar, Rows
from desim_warehouse.report.text import numbers

if TYPE_CHECKING:
    from desim_warehouse.outcome.account import By
    from desim_warehouse.report.html import Html
    from desim_warehouse.run import Run

_LEAST = 0.005
"""Part of a task's time from which on it has a bar of its own."""


def rows(figure: Rows) -> Html:
    """Intervals, or bars from 0, one below the other."""
    ends = [end for one in figure.rows for end in (one.low, one.high, one.mean) if end is not None]
    low, high = min([*ends, figure.at or 0.0]), max([*ends, figure.at or 0.0])
    room = 0.04 * (high - low) if figure.at is not None else 0.0
    low, span = low - room, (high - low + 2 * room) or 1.0
    return html.figure("rows", figure, lambda value: round(1000 * (value - low) / span, 1))


def account(run: Run) -> Html | None:
    """Where the time of a task goes, of a robot where there were none, in one unit; None: the log does not say."""
    if run.record.level != "all":
        return None
    by: By = "task" if counted_tasks(run.history) else "robot"
    of = OF_TASKS if by == "task" else OF_ROBOTS
    table = run.account(by)
    parts = table.mean().sort_values(ascending=False)
    whole = float(parts.sum())
    if not whole:
        return None
    unit = numbers.times(run.model.units.time, [float(parts.iloc[0])])
    marks = tuple(
        Bar(
            label=of[str(name)].doing,
            mean=float(part),
            text=f"{unit.value(float(part))} · {100 * part / whole:.0f} %",
            standing="part",
        )
        for name, part in parts.items()
        if part >= _LEAST * whole
    )
    many = number_of(len(table), by)
    return rows(Rows(title=f"Where the {unit.value(whole)} of a {by} go, mean of {many}", rows=marks))
