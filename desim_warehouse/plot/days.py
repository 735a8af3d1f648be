"""Real days beside simulated ones, and measured times beside the distributions that were fitted to them.

For `plot.real_day`, `passages`, `residuals` and `fitted`, and so for the page of `desim validate` and for `desim fit`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from desim_warehouse.errors import ReportError, shown
from desim_warehouse.fleet_log.validate import Validation
from desim_warehouse.layout import Layout
from desim_warehouse.look import palette
from desim_warehouse.look.labels import box_around
from desim_warehouse.plot import floor as plan
from desim_warehouse.plot import style as look
from desim_warehouse.plot.names import Name, write_names
from desim_warehouse.study.fit import Fitted
from desim_warehouse.values.arguments import is_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from desim_warehouse.fleet_log.ranks import Ranked
    from desim_warehouse.values.arrays import Flags


By = Literal["passed", "stood"]
Line = tuple[tuple[float, float], tuple[float, float]]
_WORDS = {"passed": "Robots along a lane, an hour", "stood": "Robots standing on a lane, {} an hour"}
REAL, MORE, LESS = palette.INK, palette.COLOURS[1], palette.COLOURS[0]
_NAMED = 3
"""Edges outside that are named in a figure."""
_ASIDE = ((6, 5), (6, -14), (-34, 6))
"""Points from a mark to its name, the worst first: marks outside are often near one another."""
_WIDTH = 5.0
"""Inches: as wide as can be read on a phone."""
_BAR = 0.9
"""Inches for the scale below a floor."""
_NONE = "#D5D5D5"
_END = 1.3
"""Where the scale of differences ends, in ends of the band."""
_BESIDE = 0.05
"""How far apart the directions of a two-way lane are drawn, in edges."""


def real_day(
    validation: Validation,
    number: int | None = None,
    *,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Draw the load units put down in each hour of a real day: a line over the band of the simulated days.

    A day like the simulated ones lies wholly inside the band on 95 of 100 days. Circles mark what lies outside.

    Args:
        validation: from `dw.validate`.
        number: of the day, from 0; default: the one that lies out farthest.
    """
    if number is None:
        number = farthest(validation)
    days = len(validation.days)
    if not is_whole(number, 0, days - 1):
        raise ReportError(f"day {shown(number):.60}: there are days 0 to {days - 1}")
    ranks, parts = validation.drops[number], validation.parts[number] / validation.model.units.hour
    low, high = ranks.band(0)
    with look.drawing(ax, style, title, (_WIDTH, 3.3), f"Drops an hour: {validation.days[number]}") as axes:
        runs = ranks.simulated.shape[1]
        label = f"band of {runs} simulated days"
        axes.stairs(high, parts, baseline=low, fill=True, color=palette.COLOURS[5], alpha=0.35, label=label)
        axes.stairs(ranks.simulated[0].mean(axis=0), parts, color=LESS, linestyle="--", label="their mean")
        axes.stairs(ranks.real[0], parts, color=REAL, linewidth=2, label="real day")
        out = np.flatnonzero(ranks.out)
        if len(out):
            middle = (parts[:-1] + parts[1:]) / 2
            marks: dict[str, Any] = {
                "marker": "o",
                "markerfacecolor": "none",
                "markeredgecolor": MORE,
                "markersize": 10,
            }
            axes.plot(middle[out], ranks.real[0][out], linestyle="none", label="outside", **marks)
        axes.set_xlim(parts[0], parts[-1])
        axes.set_ylim(bottom=0)
        axes.set_xlabel("Time of the log (h)")
        axes.set_ylabel("Drops an hour")
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=2)
    return axes


def farthest(validation: Validation) -> int:
    """Return the number of the real day whose drops lie out farthest, relative to the bound of its band."""
    return int(np.argmax([np.abs(ranks.off).max() / (ranks.bound or 1.0) for ranks in validation.drops]))


def passages(
    validation: Validation, *, title: str | None = None, style: look.Style = "light", ax: Axes | None = None
) -> Axes:
    """Draw how often robots came along each edge in an hour, real over simulated: a mark for each edge.

    A bar goes from the lowest to the highest simulated day. On the line both are alike. Edges outside the band of all
    edges are coloured, the worst three named.

    Raises:
        ReportError: logs of trips, which do not say where robots drove.
    """
    ranks = of_edges(validation, "passed")
    real, simulated = ranks.real.mean(axis=0), ranks.simulated.mean(axis=0)
    across = simulated.mean(axis=0)
    with look.drawing(
        ax, style, title, (_WIDTH, 3.8), "Robots along each lane in an hour, real over simulated"
    ) as axes:
        axes.hlines(real, simulated.min(axis=0), simulated.max(axis=0), color=palette.FAINT, linewidth=0.8, alpha=0.6)
        most = max(float(real.max()), float(simulated.max())) * 1.05 or 1.0
        axes.plot([0, most], [0, most], color=palette.FAINT, linestyle="--", linewidth=1, label="alike")
        for which, label, mark in _sides(ranks):
            if which.any():
                shown: dict[str, Any] = {"linestyle": "none", "marker": mark[0], "color": mark[1], "markersize": 5}
                axes.plot(across[which], real[which], label=label, **shown)
        edges = list(validation.model.floor.graph.edges)
        for edge, beside in zip(_worst(ranks), _ASIDE, strict=False):
            point = (across[edge], real[edge])
            axes.annotate(look.text(">".join(edges[edge])), point, beside, textcoords="offset points", fontsize="small")
        axes.set_xlim(0, most)
        axes.set_ylim(0, most)
        axes.set_xlabel("Simulated: robots along the lane an hour")
        axes.set_ylabel("Real")
        axes.legend(loc="upper left")
    return axes


def residuals(
    validation: Validation,
    *,
    by: By = "passed",
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Draw real minus simulated passages on the floor, for each edge: blue where there were less, orange where more.

    The scale ends a little beyond the band of all edges. Edges outside are wide, and the worst three are named with
    their difference.

    Args:
        validation: from `dw.validate`.
        by: "passed": how often robots came along in an hour; "stood": how long they stood there in an hour.

    Raises:
        ReportError: another `by`, or logs of trips, which do not say where robots drove.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    if by not in _WORDS:
        raise ReportError(f"by {by!r}: expected {' or '.join(_WORDS)}")
    ranks = of_edges(validation, by)
    floor, step = validation.model.floor, plan.step_of(validation.model.floor)
    lines = {edge: _line(floor, edge, step) for edge in floor.graph.edges}
    shades = ScalarMappable(Normalize(-_END, _END), LinearSegmentedColormap.from_list("off", (LESS, _NONE, MORE)))
    colours = shades.to_rgba(ranks.off / (ranks.bound or 1.0))
    what = _WORDS[by].format(validation.model.units.time)
    width, height = plan.size_of(floor)
    size = _WIDTH, height * _WIDTH / width + _BAR
    with look.drawing(ax, style, title, size, f"{what}: real less simulated, on each lane") as axes:
        widths = np.where(ranks.out, 5.0, 2.5).tolist()
        axes.add_collection(LineCollection(list(lines.values()), colors=colours, linewidths=widths, zorder=2))
        plan.arrows(axes, list(lines.values()), palette.FAINT)
        names = plan.names_of_floors(floor)
        names += plan.draw_nodes(axes, floor, set(), named=len(floor.graph) <= plan.NAMED)
        off = ranks.real.mean(axis=0) - ranks.simulated.mean(axis=(0, 1))
        edges = list(lines)
        worst = [_name(lines[edges[rank]], f"{'>'.join(edges[rank])} {off[rank]:+.3g}") for rank in _worst(ranks)]
        plan.frame(axes, floor, step, validation.model)
        write_names(axes, [*worst, *names], plan.sheet(floor, step))
        figure = axes.get_figure(root=True)
        assert figure is not None
        bar = figure.colorbar(shades, ax=axes, orientation="horizontal", label=look.text(what), shrink=0.8)
        bar.set_ticks([-1, 0, 1], labels=["less:\nend of the band", "as\nsimulated", "more:\nend of the band"])
    return axes


def of_edges(validation: Validation, by: By) -> Ranked:
    """Return the counts on edges; raises ReportError where the logs do not have them."""
    ranks = validation.passed if by == "passed" else validation.stood
    if ranks is None:
        raise ReportError("logs of trips do not say where robots drove, expected messages or runs")
    return ranks


def _sides(ranks: Ranked) -> list[tuple[Flags, str, tuple[str, str]]]:
    """Return the edges inside their band, above it, and below it; each group in words, with a mark and a colour."""
    return [
        (~ranks.out, "inside the band", ("o", palette.FAINT)),
        (ranks.out & (ranks.off > 0), "more than simulated", ("^", MORE)),
        (ranks.out & (ranks.off < 0), "less than simulated", ("v", LESS)),
    ]


def _worst(ranks: Ranked) -> list[int]:
    """Return the edges outside the band that lie out farthest."""
    out = np.flatnonzero(ranks.out)
    worst: list[int] = out[np.argsort(-np.abs(ranks.off[out]), kind="stable")][:_NAMED].tolist()
    return worst


def _name(line: Line, words: str) -> Name:
    """Return words to be written beside the middle of an edge."""
    (x0, y0), (x1, y1) = line
    upright = abs(y1 - y0) > abs(x1 - x0)
    around = box_around((x0 + x1) / 2, (y0 + y1) / 2, 0.0)
    return Name(words, around, (1, 0) if upright else (0, -1), "small", palette.INK)


def _line(floor: Layout, edge: tuple[str, str], step: float) -> Line:
    """Return an edge as drawn, always beside its opposite direction, so that both are seen."""
    (x0, y0), (x1, y1) = plan.ends(floor, edge, step)
    if not floor.graph.edges[edge].get("two_way"):
        return (x0, y0), (x1, y1)
    length = math.dist((x0, y0), (x1, y1)) or 1.0
    dx, dy = -_BESIDE * step * (y1 - y0) / length, _BESIDE * step * (x1 - x0) / length
    return (x0 + dx, y0 + dy), (x1 + dx, y1 + dy)


_SHOWN = 3
_POINTS = 400


def fitted(
    fitted: Fitted,
    *,
    unit: str = "s",
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Draw the share of measured times below each time, beside the same share for the three best distributions.

    Args:
        fitted: from `study.fit`.
        unit: of the times.
    """
    times = np.sort(fitted.times)
    best = fitted.best.words(unit)
    with look.drawing(ax, style, title, (6.4, 3.6), f"{len(times)} measured times; best: {best}") as axes:
        shares = np.arange(1, len(times) + 1) / len(times)
        axes.step(times, shares, where="post", color=palette.INK, label=f"{len(times)} measured times")
        grid = np.linspace(0, times[-1], _POINTS)
        for rank, candidate in enumerate(fitted.candidates[:_SHOWN]):
            line = {**look.cycle(rank), "marker": ""}
            axes.plot(grid, candidate.share_below(grid), label=candidate.distribution.words(unit), **line)
        axes.set_xlabel(look.text(f"Time ({unit})"))
        axes.set_ylabel("Share of times below")
        look.in_percent(axes.yaxis)
        axes.set_ylim(0, 1.02)
        axes.legend(loc="lower right")
    return axes
