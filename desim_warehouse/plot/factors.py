"""An indicator by the levels of a factor: the paper's Figs. 6-8, and the throughput curve with its knee.

For `plot.by_factor`, `facets` and `throughput`, in notebooks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from desim_warehouse.answer import words
from desim_warehouse.errors import ReportError, shown
from desim_warehouse.look import palette
from desim_warehouse.model import Model
from desim_warehouse.plot import style as look
from desim_warehouse.study.table import Cell, averaged_over, cells, is_numeric, order, usable
from desim_warehouse.study.table import levels as levels_of
from desim_warehouse.values.arguments import is_finite
from desim_warehouse.values.labels import plain

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


Kind = Literal["auto", "line", "bars", "points"]
_MANY = 24
"""More numeric levels than this are a sample of a range, not a list: points, not a line."""
_CROWDED = 6
"""From this many named levels on, names are slanted."""
_REACH = 12
"""How far beyond the means an axis with a target goes for their intervals, in quarters of what is between them."""


def by_factor(
    table: pd.DataFrame,
    factor: str,
    indicator: str,
    *,
    group: str | None = None,
    groups: Sequence[Any] | None = None,
    kind: Kind = "auto",
    confidence: float = 0.95,
    model: Model | None = None,
    seconds: bool = False,
    target: float | None = None,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Draw the mean of an indicator at each level of a factor, with t intervals over the replications.

    Args:
        table: a row per run; columns for factors (under their model keys), replication and indicators.
        factor: along the horizontal axis; numbers are to scale.
        indicator: along the vertical axis, in the unit of the model file.
        group: a second factor, one line or set of bars for each of its levels.
        groups: its levels in the order of their colours; default: those that have runs.
        kind: auto is lines for numbers, points for more than 24 of them, bars for names.
        confidence: of each interval; none is drawn where replications cannot differ, or there is only one.
        model: gives the axes their units.
        seconds: show times in seconds (needs `model`).
        target: a value of the indicator to draw a line at.

    The paper's Fig. 6 is `by_factor(table, "fleet.size", "T", group="tasks.goods", seconds=True, ...)`.
    Other factors are averaged over, replication by replication; the horizontal axis says so.

    Raises:
        ReportError: an unknown column, no run with a value, seconds without a model.
    """
    units = model.units if model else None
    if seconds and units is None:
        raise ReportError("seconds: expected a model, which says how many seconds a time unit has")
    scale = units.seconds if seconds and units and words.indicator_kind(indicator) == "time" else 1.0
    if target is not None and not is_finite(target):
        raise ReportError(f"target {shown(target):.60}: expected a number")
    keys = [factor] if group is None else [group, factor]
    estimates = cells(table, keys, indicator, confidence, scale)
    levels = _merged([cell.levels[-1] for cell in estimates])
    names = (groups or list(dict.fromkeys(cell.levels[0] for cell in estimates))) if group else [None]
    if kind == "auto":
        kind = "bars" if not is_numeric(levels) else "points" if len(levels) > _MANY else "line"
    alt = f"{words.indicator_name(indicator)} by {words.in_words(factor)}"
    alt += f" and {words.in_words(group)}" if group else ""
    above = f"{title}\n" if title and target is not None else title  # a line for the target
    with look.drawing(ax, style, above, (6.4, 3.8), alt) as axes:
        for index, name in enumerate(names):
            chosen = [cell for cell in estimates if group is None or cell.levels[0] == name]
            label = "" if group is None else look.text(words.level(name))
            _draw(axes, kind, chosen, levels, label, index, len(names))
        _horizontal(axes, factor, levels, model, named=kind == "bars" or not is_numeric(levels))
        axes.set_xlabel(axes.get_xlabel() + look.text(words.averaged(averaged_over(table, keys))))
        axes.set_ylabel(look.text(words.indicator_label(indicator, units, seconds)))
        axes.margins(x=0.04)
        _vertical(axes, indicator, estimates, None if target is None else target * scale)
        look.legend(axes, len(names), group and words.factor_head(group, units))
        return axes


def facets(
    table: pd.DataFrame,
    factor: str,
    indicator: str,
    *,
    by: Sequence[str],
    group: str | None = None,
    kind: Kind = "auto",
    confidence: float = 0.95,
    model: Model | None = None,
    seconds: bool = False,
    target: float | None = None,
    title: str | None = None,
    style: look.Style = "light",
) -> Axes:
    """Draw `by_factor` once for each combination of levels of further factors, side by side on one scale.

    Arguments that are not named here: see `by_factor`.

    Args:
        by: the further factors; each combination of their levels that has runs is a panel, named by them.
        title: of the whole figure.

    Returns:
        The axes of the first panel; those of all are `ax.figure.axes`.

    Raises:
        ReportError: as `by_factor`, or `by` names no factor.
    """
    if not by:
        raise ReportError("facets: expected at least one factor that has a panel for each of its levels")
    parts = _parts(table, by, indicator)
    keys = [factor, *([group] if group else []), *by]
    alt = f"{words.indicator_name(indicator)} by {', '.join(map(words.in_words, keys))}"
    groups = None if group is None else levels_of(usable(table, [group, *by], indicator), group)
    with look.panels(len(parts), style, (4.4, 3.4), alt) as panels:
        for axes, (name, part) in zip(panels, parts, strict=True):
            by_factor(
                part,
                factor,
                indicator,
                group=group,
                groups=groups,
                kind=kind,
                confidence=confidence,
                model=model,
                seconds=seconds,
                target=target,
                title=name,
                style=style,
                ax=axes,
            )
        ends = [axes.get_ylim() for axes in panels]
        for axes in panels:
            axes.set_ylim(min(low for low, _ in ends), max(high for _, high in ends))
            legend = axes.get_legend()
            if legend is not None and axes is not panels[-1]:
                legend.remove()
        if title:
            panels[0].figure.suptitle(look.text(title))
        return panels[0]


def _vertical(axes: Axes, indicator: str, estimates: list[Cell], target: float | None) -> None:
    """Draw the target, and set the limits around it; without one, from 0 if no interval is below it; shares in %."""
    if target is not None:
        _target(axes, indicator, target, estimates)
    elif all(min(cell.estimate.interval or [cell.estimate.mean]) >= 0 for cell in estimates):
        axes.set_ylim(bottom=0)
    if words.is_share(indicator):
        look.in_percent(axes.yaxis)


def _target(axes: Axes, indicator: str, value: float, estimates: list[Cell]) -> None:
    """Draw a line at the target, its value above the axes; the axis is for means, their intervals and the line.

    Intervals that are many times as wide as the means lie apart are cut off.
    """
    means = [cell.estimate.mean for cell in estimates]
    axes.axhline(value, color=palette.INK, linestyle=(0, (6, 3)), linewidth=1.3, zorder=1)
    low, high = min(*means, value), max(*means, value)
    room = 0.25 * (high - low) or 0.1 * abs(value) or 1.0
    ends = [end for cell in estimates for end in cell.estimate.interval or ()]
    reach = _REACH * room
    axes.set_ylim(max(min([low, *ends]), low - reach) - room / 4, min(max([high, *ends]), high + reach) + room / 4)
    label = f"– – target {words.amount(indicator, value)}"
    axes.annotate(label, (1, 1), (0, 3), xycoords="axes fraction", textcoords="offset points", ha="right")


def _parts(table: pd.DataFrame, by: Sequence[str], indicator: str) -> list[tuple[str, pd.DataFrame]]:
    """Return the runs at each combination of levels of some factors, with its name."""
    parts = []
    for key in order(usable(table, by, indicator), by):
        chosen = table
        for name, value in zip(by, key, strict=True):
            chosen = chosen[[plain(item) == value for item in chosen[name]]]
        parts.append((words.design_spoken(dict(zip(by, key, strict=True))), chosen))
    return parts


def _merged(levels: list[Any]) -> list[Any]:
    """Levels of all groups, numbers upwards."""
    once = list(dict.fromkeys(levels))
    return sorted(once) if is_numeric(once) else once


def _errors(chosen: list[Cell]) -> list[list[float]] | None:
    """Return the reach of intervals below and above the means, shape (2, cells), nan for none; None without any."""
    ends = [cell.estimate.interval or (math.nan, math.nan) for cell in chosen]
    if all(math.isnan(low) for low, _ in ends):
        return None
    means = [cell.estimate.mean for cell in chosen]
    return [
        [mean - low for mean, (low, _) in zip(means, ends, strict=True)],
        [high - mean for mean, (_, high) in zip(means, ends, strict=True)],
    ]


def _draw(axes: Axes, kind: Kind, chosen: list[Cell], levels: list[Any], label: str, index: int, groups: int) -> None:
    """Draw one group: a line, points or bars, with the intervals."""
    means, errors = [cell.estimate.mean for cell in chosen], _errors(chosen) if chosen else None
    if kind == "bars":
        width = 0.8 / groups
        places = [levels.index(cell.levels[-1]) + (index - (groups - 1) / 2) * width for cell in chosen]
        axes.bar(
            places,
            means,
            width * 0.92,
            yerr=errors,
            label=label or None,
            color=palette.COLOURS[index % len(palette.COLOURS)],
            hatch=look.HATCHES[index % len(look.HATCHES)],
            edgecolor="white",
            error_kw={"ecolor": palette.INK, "capsize": 3, "elinewidth": 1.2},
        )
        return
    numeric = is_numeric(levels)
    places = [cell.levels[-1] if numeric else levels.index(cell.levels[-1]) for cell in chosen]
    shape = {**look.cycle(index), **({"linestyle": "none"} if kind == "points" else {})}
    axes.errorbar(places, means, yerr=errors, label=label or None, capsize=3, elinewidth=1.2, **shape)


def _horizontal(axes: Axes, factor: str, levels: list[Any], model: Model | None, *, named: bool) -> None:
    """Set the horizontal axis: the factor's name and unit, its levels where they are few."""
    axes.set_xlabel(look.text(words.factor_label(factor, model.units if model else None)))
    if named:
        axes.set_xticks(range(len(levels)), [look.text(words.level(value)) for value in levels])
        if len(levels) >= _CROWDED or max(len(words.level(value)) for value in levels) > 2 * _CROWDED:
            axes.tick_params(axis="x", labelrotation=25)
            for tick in axes.get_xticklabels():
                tick.set_horizontalalignment("right")
                tick.set_rotation_mode("anchor")
        axes.grid(visible=False, axis="x")
    elif len(levels) <= 2 * _CROWDED:
        axes.set_xticks(levels, [words.level(value) for value in levels])


def throughput(
    table: pd.DataFrame,
    factor: str = "fleet.size",
    indicator: str = "throughput_per_hour",
    *,
    group: str | None = None,
    confidence: float = 0.95,
    model: Model | None = None,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Draw the throughput curve, with its knee and the smallest size within 5 % of the maximum marked.

    As `by_factor` with a numeric factor; marks only without `group` and for three or more sizes.

    Raises:
        ReportError: as `by_factor`, or a factor that is not numeric.
    """
    estimates = cells(table, [factor], indicator, confidence)
    if not is_numeric([cell.levels[0] for cell in estimates]):
        raise ReportError(f"{factor}: expected numbers, to draw a throughput curve over them")
    axes = by_factor(
        table,
        factor,
        indicator,
        group=group,
        kind="line",
        confidence=confidence,
        model=model,
        title=title,
        style=style,
        ax=ax,
    )
    if group is None and len(estimates) > 2:  # noqa: PLR2004 - fewer have no knee
        with look.drawing(axes, style, None, (0, 0)):
            _marks(axes, estimates)
    return axes


def _marks(axes: Axes, estimates: list[Cell]) -> None:
    """Mark the knee, and 95 % of the maximum."""
    from desim_warehouse.study.statistics.knee import knee, smallest_within

    sizes, means = [float(cell.levels[0]) for cell in estimates], [cell.estimate.mean for cell in estimates]
    shape = knee(sizes, means)
    if shape.at is not None:
        axes.axvline(shape.at, color=palette.COLOURS[1], linestyle="--", linewidth=1.2, label=f"knee: {shape.at:g}")
    near = smallest_within(sizes, means)
    axes.axhline(
        0.95 * shape.maximum,
        color=palette.FAINT,
        linestyle=":",
        linewidth=1.2,
        label=f"95 % of the maximum: from {near:g}",
    )
    axes.legend(loc="lower right")
