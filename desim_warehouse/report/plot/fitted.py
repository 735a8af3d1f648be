"""Measured times beside the distributions that were fitted to them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from desim_warehouse.report import palette
from desim_warehouse.report.plot import style as look

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from desim_warehouse.study.fit import Fitted

_SHOWN = 3
_POINTS = 400


def fitted(
    found: Fitted,
    *,
    unit: str = "s",
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """The share of measured times below each time, and that of the three distributions that fit best.

    Args:
        found: from `study.fit`.
        unit: of the times.
    """
    times = np.sort(found.times)
    best = found.best.words(unit)
    with look.drawing(ax, style, title, (6.4, 3.6), f"{len(times)} measured times; best: {best}") as axes:
        shares = np.arange(1, len(times) + 1) / len(times)
        axes.step(times, shares, where="post", color=palette.INK, label=f"{len(times)} measured times")
        at = np.linspace(0, times[-1], _POINTS)
        for rank, one in enumerate(found.candidates[:_SHOWN]):
            line = {**look.cycle(rank), "marker": ""}
            axes.plot(at, one.share_below(at), label=one.distribution.words(unit), **line)
        axes.set_xlabel(look.text(f"Time ({unit})"))
        axes.set_ylabel("Share of times below")
        look.in_percent(axes.yaxis)
        axes.set_ylim(0, 1.02)
        axes.legend(loc="lower right")
    return axes
