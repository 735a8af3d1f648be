"""An indicator over two factors: a response surface, seen from above."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.errors import ReportError
from desim_warehouse.report import palette
from desim_warehouse.report.plot import style as look
from desim_warehouse.report.text import numbers, words
from desim_warehouse.study.table import averaged_over, cells, is_numeric

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable

    from desim_warehouse.model import Model
    from desim_warehouse.study.table import Cell

_WRITTEN = 64
"""Means are written in the cells if a row of them has no more characters than this."""
_SCATTERED = 0.5
"""Points that fill less than this part of the grid they span are a sample (Sobol, Latin hypercube), not a grid."""


def surface(
    table: pd.DataFrame,
    x: str,
    y: str,
    indicator: str,
    *,
    model: Model | None = None,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """The mean of an indicator at each pair of levels of two factors.

    A grid of designs becomes a heat map with the means in its cells. A sample of a range (Sobol points, Latin
    hypercube) becomes filled contours between the points. Other factors are averaged over, and the horizontal axis
    says so.

    Raises:
        ReportError: an unknown column, no run with a value, or one factor twice.
    """
    if x == y:
        raise ReportError(f"surface: expected two factors, got {x} twice")
    found = cells(table, [x, y], indicator)
    xs, ys = _levels(found, 0), _levels(found, 1)
    units = model.units if model else None
    sampled = is_numeric(xs) and is_numeric(ys) and len(found) < _SCATTERED * len(xs) * len(ys)
    alt = f"{words.indicator_name(indicator)} over {x} and {y}"
    with look.drawing(ax, style, title, (6.4, 4.4), alt) as axes:
        shown = _contours(axes, found) if sampled else _grid(axes, found, xs, ys)
        axes.set_xlabel(look.text(words.factor_label(x, units) + words.averaged(averaged_over(table, [x, y]))))
        axes.set_ylabel(look.text(words.factor_label(y, units)))
        figure = axes.get_figure(root=True)
        assert figure is not None
        bar = figure.colorbar(shown, ax=axes, label=look.text(words.indicator_label(indicator, units)))
        if words.is_share(indicator):
            look.in_percent(bar.ax.yaxis)
        return axes


def _levels(found: list[Cell], place: int) -> list[Any]:
    once = list(dict.fromkeys(cell.levels[place] for cell in found))
    return sorted(once) if is_numeric(once) else once


def _grid(axes: Axes, found: list[Cell], xs: list[Any], ys: list[Any]) -> ScalarMappable:
    """A coloured cell for each pair of levels, with its mean."""
    means = np.full((len(ys), len(xs)), np.nan)
    for cell in found:
        means[ys.index(cell.levels[1]), xs.index(cell.levels[0])] = cell.estimate.mean
    mesh = axes.pcolormesh(np.ma.masked_invalid(means), cmap=palette.MAP, edgecolors="white", linewidth=0.8)
    width = max(len(numbers.number(cell.estimate.mean)) for cell in found)
    if len(xs) * (width + 1) <= _WRITTEN and len(ys) <= _WRITTEN // 4:
        middle = (np.nanmin(means) + np.nanmax(means)) / 2
        for (row, column), mean in np.ndenumerate(means):
            if np.isfinite(mean):
                colour = "white" if mean < middle else "black"
                axes.text(column + 0.5, row + 0.5, numbers.number(float(mean)), color=colour, ha="center", va="center")
    axes.set_xticks(np.arange(len(xs)) + 0.5, [look.text(words.level(value)) for value in xs])
    axes.set_yticks(np.arange(len(ys)) + 0.5, [look.text(words.level(value)) for value in ys])
    if any(len(words.level(value)) > 8 for value in xs):  # noqa: PLR2004 - letters that fit side by side
        axes.tick_params(axis="x", labelrotation=25)
    axes.grid(visible=False)
    return mesh


def _contours(axes: Axes, found: list[Cell]) -> ScalarMappable:
    """Filled contours between sampled points, and the points."""
    x, y = ([float(cell.levels[place]) for cell in found] for place in (0, 1))
    means = [cell.estimate.mean for cell in found]
    flat = len(found) < 4 or min(means) == max(means)  # noqa: PLR2004 - too few for a surface
    points = axes.scatter(x, y, c=means, cmap=palette.MAP, edgecolors="white", linewidths=0.8, zorder=3)
    if flat:
        return points
    return axes.tricontourf(x, y, means, levels=12, cmap=palette.MAP)
