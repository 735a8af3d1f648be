"""Orders over the day: how many had come, and how many were delivered."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.report import palette
from desim_warehouse.report.plot import style as look

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
    tasks, end = run.history.tasks.values(), run.history.end
    came = sorted(task.released for task in tasks)
    went = sorted(task.delivered for task in tasks if math.isfinite(task.delivered))
    with look.drawing(ax, style, title, (6.4, 3.4), "Tasks released and delivered over time") as axes:
        hour = run.model.units.hour
        for number, (times, label) in enumerate(((came, "released"), (went, "delivered"))):
            known = [0.0, *times, end]
            counts = [*range(len(times) + 1), len(times)]
            line = {**look.cycle(number), "marker": ""}
            axes.step([time / hour for time in known], counts, where="post", label=label, **line)
        if run.history.begin:
            axes.axvspan(0, run.history.begin / hour, color=palette.FAINT, alpha=0.15, linewidth=0, label="warm-up")
        axes.set_xlim(0, end / hour or 1.0)
        axes.set_ylim(bottom=0)
        axes.set_xlabel("Time (h)")
        axes.set_ylabel("Tasks")
        look.legend(axes, 2)
        return axes
