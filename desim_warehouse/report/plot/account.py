"""Where the time went: the parts of an account of time, stacked."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from desim_warehouse.account import OF_ROBOTS, OF_TASKS
from desim_warehouse.report.plot import style as look
from desim_warehouse.report.plot.fleet import numbered

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from desim_warehouse.account import By
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
    """The parts of the time of each task, robot, edge, node or hour, stacked (`Run.account`; needs `log: all`).

    Of more than 24 edges or nodes those where robots waited longest are shown, the worst first.

    Raises:
        ReportError: a run without `log: all`, or another `by`.
    """
    table = run.account(by)
    across = f"{by.capitalize()}, in order of release" if by == "task" else by.capitalize()
    if by in ("edge", "node") and len(table) > _PLACES:
        across += f" (the {_PLACES} of {len(table)} with most waiting)"
        table = _worst(table)
    parts = [part for name, part in (OF_TASKS if by == "task" else OF_ROBOTS).items() if table[name].any()]
    with look.drawing(ax, style, title, (6.4, 3.8), f"Account of time by {by}") as axes:
        edges = [place - 0.5 for place in range(len(table) + 1)]
        below = [0.0] * len(table)
        for place, part in enumerate(parts):
            above = [low + float(value) for low, value in zip(below, table[part.name], strict=True)]
            axes.stairs(
                above,
                edges,
                baseline=below,
                fill=True,
                label=part.doing,
                facecolor=part.colour,
                edgecolor="white",
                linewidth=0,
                hatch=look.HATCHES[place % len(look.HATCHES)] if style == "print" else "",
            )
            below = above
        numbered(axes, [str(name) for name in table.index])
        if by in ("edge", "node"):
            axes.tick_params(axis="x", labelrotation=90)
        axes.set_ylim(bottom=0)
        axes.grid(visible=False, axis="x")
        axes.set_xlabel(look.text(across))
        axes.set_ylabel(look.text(f"Time ({run.model.units.time})"))
        look.legend(axes, len(parts), reverse=True)
        return axes


def _worst(table: pd.DataFrame) -> pd.DataFrame:
    order = pd.DataFrame({"waited": table["behind_robot"] + table["before_intersection"], "all": table.sum(axis=1)})
    return table.loc[order.sort_values(["waited", "all"], ascending=False, kind="stable").index[:_PLACES]]
