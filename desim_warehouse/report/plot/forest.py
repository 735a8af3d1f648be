"""Designs against a baseline: a forest plot of paired differences."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.report import palette
from desim_warehouse.report.plot import style as look
from desim_warehouse.report.text import words

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from matplotlib.axes import Axes

    from desim_warehouse.model import Model
    from desim_warehouse.study.statistics import Comparison


def differences(
    comparison: Comparison,
    indicator: str,
    *,
    names: Mapping[Any, str] | None = None,
    model: Model | None = None,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Each design minus the baseline under common random numbers, with intervals that hold all at once.

    Filled marks differ from the baseline by the comparison's own test, hollow ones cannot be told from it.

    Args:
        comparison: from `desim_warehouse.study.statistics.compare`.
        indicator: what was compared; names the axis.
        names: design -> label; default: the design itself.
        model: gives the axis its unit.
    """
    names = names or {}
    units = model.units if model else None
    rows = list(comparison.differences)
    base = names.get(comparison.baseline, str(comparison.baseline))
    size = (6.4, 1.3 + 0.29 * len(rows))
    alt = f"Differences in {words.indicator_name(indicator)} to {base}"
    with look.drawing(ax, style, title, size, alt) as axes:
        axes.axvline(0.0, color=palette.INK, linewidth=1.0)
        for place, row in enumerate(rows):
            told, mean = bool(row.differs), row.estimate.mean
            low, high = row.estimate.interval or (mean, mean)
            axes.errorbar(
                [mean],
                [place],
                xerr=None if row.estimate.interval is None else [[mean - low], [high - mean]],
                color=palette.COLOURS[0] if told else palette.FAINT,
                marker="o" if told else "D",
                markerfacecolor=palette.COLOURS[0] if told else "white",
                linestyle="none",
                capsize=3,
                elinewidth=1.4,
            )
        labels = [names.get(row.design, str(row.design)) for row in rows]
        axes.set_yticks(range(len(rows)), [look.text(label) for label in labels])
        axes.set_ylim(len(rows) - 0.4, -0.6)
        axes.grid(visible=False, axis="y")
        axes.locator_params(axis="x", nbins=6)
        if words.is_share(indicator):
            look.in_percent(axes.xaxis)
        axes.set_xlabel(look.text(f"{words.indicator_label(indicator, units)}:\ndifference to {base}"))
        return axes
