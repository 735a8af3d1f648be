"""Where the time went: the parts of an account of time, stacked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from desim_warehouse.outcome.account import OF_ROBOTS, OF_TASKS, OF_WORK, Share
from desim_warehouse.report.plot import style as look
from desim_warehouse.report.plot.fleet import numbered

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from desim_warehouse.outcome.account import By
    from desim_warehouse.run import Run

_PLACES = 24
"""The most edges or nodes that are shown: those with the most waiting."""


def account(
    run: Run,
    by: By = "task",
    *,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """The parts of the time of each task, flow, station, robot, edge, node or hour, stacked (`Run.account`).

    Needs `log: all`. Of flows and stations the mean task is shown; of more than 24 edges or nodes those where robots
    waited longest, the worst first.

    Raises:
        ReportError: a run without `log: all`, or another `by`.
    """
    table = run.account(by)
    across = f"{by.capitalize()}, in order of release" if by == "task" else by.capitalize()
    if by in ("edge", "node") and len(table) > _PLACES:
        across += f" (the {_PLACES} of {len(table)} with most waiting)"
        table = _worst(table)
    known = OF_TASKS if by in OF_WORK else OF_ROBOTS
    parts = [part for name, part in known.items() if name in table and table[name].any()]
    means = by in ("flow", "station")
    size = (6.4, 1.2 + max(0.36 * len(table), 0.2 * len(parts))) if means else (6.4, 3.8)
    with look.drawing(ax, style, title, size, f"Account of time by {by}") as axes:
        unit = look.text(f"({run.model.units.time})")
        _stack(axes, table, parts, style, across=means)
        if means:
            axes.set_yticks(range(len(table)), [look.text(name) for name in table.index])
            axes.set_ylim(len(table) - 0.4, -0.6)
            axes.set_xlim(left=0)
            axes.grid(visible=False, axis="y")
            axes.set_xlabel(f"Mean time of a task {unit}")
        else:
            numbered(axes, [str(name) for name in table.index])
            if by in ("edge", "node"):
                axes.tick_params(axis="x", labelrotation=90)
            axes.set_ylim(bottom=0)
            axes.grid(visible=False, axis="x")
            axes.set_xlabel(look.text(across))
            axes.set_ylabel(f"Time {unit}")
        look.legend(axes, len(parts), reverse=not means)
        return axes


def _stack(axes: Axes, table: pd.DataFrame, parts: list[Share], style: look.Style, *, across: bool) -> None:
    """The parts of each row on top of one another, or side by side in a bar across."""
    edges = [place - 0.5 for place in range(len(table) + 1)]
    below = [0.0] * len(table)
    for place, part in enumerate(parts):
        values = [float(value) for value in table[part.name]]
        above = [low + value for low, value in zip(below, values, strict=True)]
        drawn: dict[str, Any] = {
            "label": part.doing,
            "facecolor": part.colour,
            "edgecolor": "white",
            "linewidth": 0,
            "hatch": look.HATCHES[place % len(look.HATCHES)] if style == "print" else "",
        }
        if across:
            axes.barh(range(len(values)), values, 0.7, left=below, **drawn)
        else:
            axes.stairs(above, edges, baseline=below, fill=True, **drawn)
        below = above


def _worst(table: pd.DataFrame) -> pd.DataFrame:
    import pandas as pd

    order = pd.DataFrame({"waited": table["behind_robot"] + table["before_intersection"], "all": table.sum(axis=1)})
    return table.loc[order.sort_values(["waited", "all"], ascending=False, kind="stable").index[:_PLACES]]
