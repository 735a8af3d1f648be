"""The course of a run by the clock: the lanes of its page, for notebooks and papers.

For `plot.day`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from desim_warehouse.answer import course
from desim_warehouse.look import palette
from desim_warehouse.outcome import day as outcome
from desim_warehouse.plot import style as look
from desim_warehouse.run import RunData

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from desim_warehouse.outcome.day import Day
    from desim_warehouse.values.arrays import Floats

_HIGH, _GAP = 3.2, 0.55
"""Height of the lane of robots, and of the gaps between lanes, as multiples of the height of a lane."""


def day(run: RunData, *, title: str | None = None, style: look.Style = "light", ax: Axes | None = None) -> Axes:
    """Draw the course of a run by the clock: robots by what they do, deliveries, open tasks, queues, and chargers.

    Each curve has the mean of each part of the run, of five minutes where it lasts for hours. A band marks the worst
    stretch. Lanes are `child_axes` of the Axes returned, the lane of robots first.

    Args:
        run: at any level of log; waits in traffic are told from work with `log: all`.
        title: above the figure.
        style: "light" for screens, "print" for papers.
        ax: axes to draw on; default: those of a new figure.

    Raises:
        ReportError: an unknown style.
    """
    history = run.history
    whole_day, chargers, fleet = outcome.day(history), history.chargers, run.model.fleet.size
    shown = course.curves(whole_day, run.model, chargers)
    high = _HIGH + len(shown) * (1 + _GAP)
    worst = course.worst(whole_day, run.model, chargers)
    with look.drawing(ax, style, title, (7.2, 0.9 + 0.5 * high), f"How the run went by the clock. {worst}") as axes:
        axes.set_axis_off()
        robots = axes.inset_axes((0, 1 - _HIGH / high, 1, _HIGH / high))
        colours = palette.COURSE["light"]
        robots.stackplot(
            whole_day.bounds,
            *(_steps(values) for values in whole_day.robots.values()),
            step="post",
            labels=[outcome.DOING[name] for name in whole_day.robots],
            colors=[colours[name] for name in whole_day.robots],
            linewidth=0,
        )
        _dress(robots, whole_day, fleet, str(fleet), "Robots")
        below = 1 - _HIGH / high
        for curve in shown:
            lane = axes.inset_axes((0, below - (1 + _GAP) / high, 1, 1 / high))
            below -= (1 + _GAP) / high
            lane.stairs(curve.values, whole_day.bounds, fill=True, color=colours[curve.kind])
            _dress(lane, whole_day, curve.top, curve.top_text, f"{curve.name}\n{curve.unit}")
        last = axes.child_axes[-1]
        times = course.ticks(run.model, 0.0, float(whole_day.bounds[-1]))
        last.tick_params(labelbottom=True, bottom=True)
        last.set_xticks([percent / 100 * whole_day.bounds[-1] for percent, _ in times], [text for _, text in times])
        robots.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, fontsize="small")
    return axes


def _steps(values: Floats) -> Floats:
    """Return the values with the last of them once more, for the end of its part."""
    return np.append(values, values[-1])


def _dress(lane: Axes, whole_day: Day, top: float, words: str, name: str) -> None:
    """Give a lane its scale, its name, and the band of the worst stretch."""
    lane.set_xlim(whole_day.bounds[0], whole_day.bounds[-1])
    lane.set_ylim(0, top)
    lane.set_yticks([0, top], ["0", words])
    lane.tick_params(labelbottom=False, bottom=False)
    lane.grid(visible=False)
    lane.set_ylabel(look.text(name), rotation=0, ha="right", va="center", labelpad=28)
    if whole_day.begin > 0:
        lane.axvspan(0, whole_day.begin, color="white", alpha=0.6, linewidth=0)
    if whole_day.worst is not None:
        lane.axvspan(whole_day.worst.start, whole_day.worst.end, color=palette.COLOURS[1], alpha=0.25, linewidth=0)
