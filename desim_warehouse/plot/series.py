"""The end of the warm-up, by MSER-5 and in Welch's plot: `plot.warm_up` and `plot.welch`.

For `desim warm-up`, and for the page of a run.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from desim_warehouse.errors import ReportError
from desim_warehouse.look import palette
from desim_warehouse.plot import style as look
from desim_warehouse.run import RunData
from desim_warehouse.study.statistics.warmup import WarmUp
from desim_warehouse.study.warm_up import Settling
from desim_warehouse.values.arguments import is_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray


_WINDOWS = (0.02, 0.05, 0.15)
"""Shares of all observations on either side of a moving average."""


def cycle_times(run: RunData) -> list[float]:
    """Return the time from release to delivery of each task delivered, in order, in the model's time unit."""
    return [task.cycle_time for task in run.history.done]


def warm_up(
    source: RunData | Sequence[float] | NDArray[np.float64],
    batch: int = 5,
    *,
    label: str | None = None,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Draw batch means over time, the MSER statistic after each possible cut, and the cut that minimises it.

    Args:
        source: a Run, whose cycle times are looked at in order of delivery, or equally spaced observations.
        batch: observations per batch, 5 in MSER-5.
        label: name and unit of the observations, for the axis; default for a Run: cycle time and its unit.

    Raises:
        ReportError: a run with too few deliveries.
        StudyError: as `statistics.mser`.
    """
    from desim_warehouse.study.statistics.warmup import mser

    if isinstance(source, RunData):
        label = label or f"Cycle time ({source.model.units.time})"
        values: Sequence[float] | NDArray[np.float64] = cycle_times(source)
        if is_whole(batch) and len(values) < 6 * batch:
            raise ReportError(f"warm-up: {len(values)} tasks delivered, expected at least {6 * batch}")
        what = "Tasks delivered"
    else:
        values, what = source, "Observations"
    truncation = mser(values, batch)
    with look.drawing(ax, style, title, (6.4, 3.6), f"Warm-up by MSER-5: {truncation.note}") as axes:
        _draw(axes, truncation)
        axes.set_xlabel(what)
        axes.set_ylabel(look.text(label or "Mean of a batch"))
        return axes


def welch(
    source: Settling | Sequence[float] | Sequence[Sequence[float]] | NDArray[np.float64],
    window: int | None = None,
    *,
    label: str | None = None,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Draw Welch's plot: observations over time, averaged over replications, and their moving averages.

    Args:
        source: what `study.warm_up.settle` found, or equally spaced observations, of several replications if there
            are rows.
        window: observations on either side of each mean; default: three curves with 2, 5 and 15 % of all
            observations, of which to look at the first that is smooth.
        label: name and unit of the observations, for the axis.

    Raises:
        StudyError: as `statistics.welch`.

    Source: Welch (1983); Law (2015), section 9.5.1.
    """
    from desim_warehouse.study.statistics.warmup import averaged
    from desim_warehouse.study.statistics.warmup import welch as smooth

    settling = None if isinstance(source, list | tuple) or hasattr(source, "shape") else cast("Settling", source)
    series = averaged(cast("Any", source)) if settling is None else settling.series
    width = 1.0 if settling is None else settling.width
    windows = [window] if window is not None else [max(1, round(share * series.size)) for share in _WINDOWS]
    curves = [(w, smooth(series, w)) for w in windows]
    with look.drawing(ax, style, title, (6.4, 3.6), "Welch's plot: moving averages over time") as axes:
        axes.plot(width * (np.arange(series.size) + 0.5), series, color=palette.FAINT, linewidth=0.8, alpha=0.6)
        for number, (w, curve) in enumerate(curves):
            shown = {**look.cycle(number), "marker": ""}
            axes.plot(width * (np.arange(curve.size) + 0.5), curve, label=f"w = {w}", **shown)
        if settling is not None and settling.time is not None:
            axes.axvline(settling.time, color=palette.INK, linestyle="--", linewidth=1, label="cut by MSER-5")
        axes.set_xlabel("Observations" if settling is None else f"Time ({settling.time_unit})")
        axes.set_ylabel(look.text(label or _observed(settling)))
        axes.legend(loc="best")
        return axes


def _observed(settling: Settling | None) -> str:
    if settling is None:
        return "Observation"
    return f"{settling.observed.replace('_', ' ').capitalize()} ({settling.unit})"


def _draw(axes: Axes, truncation: WarmUp) -> None:
    places = truncation.positions + truncation.batch / 2
    (means,) = axes.plot(
        places, truncation.means, color=palette.COLOURS[0], linewidth=1.2, label=f"means of {truncation.batch}"
    )
    verdict = "" if truncation.valid else " (second half: run longer)"
    cut = axes.axvline(
        truncation.truncate, color=palette.COLOURS[1], linestyle="--", label=f"cut at {truncation.truncate}{verdict}"
    )
    if truncation.truncate:
        axes.axvspan(0, truncation.truncate, color=palette.FAINT, alpha=0.15, linewidth=0)
    kept = truncation.means[truncation.truncate // truncation.batch :]
    level = axes.hlines(
        kept.mean(), truncation.truncate, places[-1], color=palette.INK, linewidth=1.2, label="mean after the cut"
    )
    right = axes.twinx()
    tail = truncation.statistic[:-4]  # the last means are too few for the statistic
    (curve,) = right.plot(
        truncation.positions[: tail.size], tail, color=palette.COLOURS[2], linestyle=":", label="MSER (right)"
    )
    right.set_ylabel("MSER statistic")
    right.spines["right"].set_visible(True)
    right.grid(visible=False)
    axes.legend(
        handles=[means, level, cut, curve],
        loc="upper center",
        bbox_to_anchor=(0.5, -0.2),
        ncols=2,
    )
