"""Orders over the day: how many had come, and how many were delivered."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.report import palette
from desim_warehouse.report.plot import style as look
from desim_warehouse.report.text.numbers import times

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from desim_warehouse.run import Run


def arrivals(
    run: Run,
    *,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Tasks released and tasks delivered, counted from the start of the run; between the two lines is what is open.

    The warm-up is shaded.
    """
    from matplotlib.ticker import MaxNLocator

    tasks, end = run.history.tasks.values(), run.history.end
    came = sorted(task.released for task in tasks)
    went = sorted(task.delivered for task in tasks if math.isfinite(task.delivered))
    with look.drawing(ax, style, title, (6.4, 3.4), "Tasks released and delivered over time") as axes:
        scale = times(run.model.units.time, [end])
        for number, (found, label) in enumerate(((came, "released"), (went, "delivered"))):
            known = [0.0, *found, end]
            counts = [*range(len(found) + 1), len(found)]
            line = {**look.cycle(number), "marker": ""}
            axes.step([scale.by * time for time in known], counts, where="post", label=label, **line)
        if run.history.begin:
            axes.axvspan(0, scale.by * run.history.begin, color=palette.FAINT, alpha=0.15, linewidth=0, label="warm-up")
        axes.set_xlim(0, scale.by * end or 1.0)
        axes.set_ylim(bottom=0)
        axes.yaxis.set_major_locator(MaxNLocator("auto", integer=True))
        axes.set_xlabel(look.text(f"Time ({scale.unit})"))
        axes.set_ylabel("Tasks")
        look.legend(axes, 2)
        return axes
