"""Batteries over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.errors import ReportError
from desim_warehouse.report import palette
from desim_warehouse.report.plot import style as look
from desim_warehouse.report.plot.fleet import part_shown

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from desim_warehouse.run import Run

_NAMED = 8
"""More robots than this are drawn alike, in thin lines."""


def battery(
    run: Run,
    *,
    start: float | None = None,
    end: float | None = None,
    robots: Sequence[int] | None = None,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """The energy in each robot's battery over time, with the threshold at which it is sent to charge.

    Args:
        run: the run; corners are exact at every change of state.
        start: of the window shown, in the model's time unit; default: the start of the run.
        end: of the window; default: the end of the run.
        robots: by number; default: all. Up to eight have a colour and a name each.

    Raises:
        ReportError: a model without batteries, an empty window, or a robot that is not there.
    """
    if run.model.battery is None:
        raise ReportError("battery: the robots of this model have none")
    begin, until, shown = part_shown(run, start, end, robots)
    curves = run.history.energy_curves
    specs = [run.history.batteries[number] for number in shown] or run.history.batteries
    few = len(shown) <= _NAMED
    with look.drawing(ax, style, title, (6.4, 3.6), "Energy of the robots over time") as axes:
        for index, number in enumerate(shown):
            times, levels = curves[number]
            if few:
                shape = look.cycle(index) | {"marker": ""}
                axes.plot(times, levels, label=f"robot {number}", linewidth=1.4, **shape)
            else:
                axes.plot(times, levels, color=palette.COLOURS[0], alpha=0.25, linewidth=0.8)
        for number, threshold in enumerate(dict.fromkeys(spec.threshold for spec in specs)):
            label = "" if number else "threshold"
            axes.axhline(threshold, color=palette.INK, linestyle="--", linewidth=1, label=label)
        lowest = min(min(curves[number][1]) for number in shown) if shown else 0.0
        axes.set_ylim(min(0.0, lowest) * 1.05, max(spec.capacity for spec in specs) * 1.03)
        axes.set_xlim(begin, until)
        axes.set_xlabel(look.text(f"Time ({run.model.units.time})"))
        axes.set_ylabel("Energy (unit of the capacity)")
        look.legend(axes, len(shown) + 1 if few else 2)
        return axes
