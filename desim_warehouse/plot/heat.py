"""The waiting of robots: a map of the floor, coloured by waiting on each edge and before each intersection.

For `plot.congestion`, and for the page of a run.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

from desim_warehouse.errors import ReportError
from desim_warehouse.look import palette
from desim_warehouse.look.labels import box_around
from desim_warehouse.plot import floor as plan
from desim_warehouse.plot import style as look
from desim_warehouse.plot.cells import ARROWS
from desim_warehouse.plot.names import Name, length_of_a_point, write_names
from desim_warehouse.run import RunData

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize
    from networkx import DiGraph


By = Literal["blocked", "waits"]
_ROOMY = 1000
"""Nodes up to which there is room for their circles."""
_SHORT = 6
"""Letters of a name."""


def congestion(
    run: RunData,
    *,
    by: By = "blocked",
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Draw the waiting of robots on the floor: on edges behind other robots, and before intersections.

    It is of the evaluation period.

    Args:
        run: the run, at any level of log.
        by: "blocked" colours by the time waited there, as a part of the evaluation period, on a scale that is the same
            for all runs; "waits" by waiting episodes. Width and size show it, too.
    """
    if by not in ("blocked", "waits"):
        raise ReportError(f"by {by!r}: expected blocked or waits")
    from matplotlib.colors import Normalize

    floor, step = run.layout, plan.step_of(run.layout)
    part = 1.0 if by == "waits" else 1 / (run.history.counted or 1.0)
    on_edge = {edge: part * value for edge, value in edge_values(run, by).items()}
    at_node = {node: part * value for node, value in node_values(run, by).items()}
    most = max([*on_edge.values(), *at_node.values(), 0.0]) or 1.0
    shades = _Shades(Normalize(0, most), _map(), most) if by == "waits" else _steps()
    what = "Robots wait here, part of the time" if by == "blocked" else "Waiting episodes"
    with look.drawing(ax, style, title, plan.size_of(floor), f"{what} on each lane and at each node") as axes:
        plan.draw_goods(axes, floor, step, set())
        _edges(axes, run, on_edge, step, shades)
        dot = _nodes(axes, run, at_node, shades)
        plan.frame(axes, floor, step, run.model)
        _names(axes, run, dot)
        _bar(axes, what, shades)
        return axes


def edge_values(run: RunData, by: By) -> dict[tuple[str, str], float]:
    """Return the waiting on each lane, behind other robots; on a two-way lane for both directions."""
    column, edges = run.edges[by], run.layout.graph.edges
    return {
        (a, b): float(column[f"{a}>{b}"] + (column[f"{b}>{a}"] if edges[a, b].get("two_way") else 0))
        for a, b in run.layout.lanes
    }


def node_values(run: RunData, by: By) -> dict[str, float]:
    """Return the waiting before each intersection; nodes that are crossed together share their value."""
    values = dict.fromkeys(run.layout.graph, 0.0)
    for key, value in run.nodes[by].items():
        for name in _members(str(key), run.layout.graph):
            values[name] = float(value)
    return values


def _members(key: str, graph: DiGraph) -> list[str]:
    """Return the nodes of an intersection written `A+B`, whatever characters the names have."""
    if key in graph:
        return [key]
    for name in graph:
        if key.startswith(f"{name}+"):
            rest = _members(key[len(name) + 1 :], graph)
            if rest:
                return [name, *rest]
    return []


def _edges(axes: Axes, run: RunData, values: dict[tuple[str, str], float], step: float, shades: _Shades) -> None:
    from matplotlib.collections import LineCollection

    lines = [plan.ends(run.layout, edge, step) for edge in values]
    every = run.layout.graph.edges
    if len(every) <= ARROWS:
        plan.arrows(axes, [plan.ends(run.layout, edge, step) for edge in every], palette.FAINT)
    shown = LineCollection(lines, cmap=shades.colours, norm=shades.norm, zorder=2)
    shown.set_array(list(values.values()))
    shown.set_linewidth([1.2 + 5.0 * shades.size(value) for value in values.values()])
    axes.add_collection(shown)


def _nodes(axes: Axes, run: RunData, values: dict[str, float], shades: _Shades) -> float:
    """Draw a circle for each node; returns the largest radius in points."""
    graph = run.layout.graph
    room = min(_ROOMY / len(graph), 1.0)
    small = 30 if len(graph) <= plan.NAMED else 4 * room
    sizes = [small + 320 * room * shades.size(value) for value in values.values()]
    axes.scatter(
        [graph.nodes[name]["x"] for name in values],
        [graph.nodes[name]["y"] for name in values],
        s=sizes,
        c=list(values.values()),
        cmap=shades.colours,
        norm=shades.norm,
        edgecolors=palette.INK,
        linewidths=0.6 * room,
        zorder=3,
    )
    return math.sqrt(max(sizes)) / 2


def _names(axes: Axes, run: RunData, dot: float) -> None:
    """Write the names of floors, and of nodes beside circles of a radius in points, the first letters of long ones."""
    floor = run.layout
    short = {name: name if len(name) <= _SHORT else f"{name[: _SHORT - 1]}…" for name in floor.graph}
    radius = dot * length_of_a_point(axes)
    node_of, names = floor.graph.nodes, plan.names_of_floors(floor)
    if len(floor.graph) <= plan.NAMED and len(set(short.values())) == len(short):
        names += [
            Name(words, box_around(node_of[name]["x"], node_of[name]["y"], radius), (1, 1), "x-small", palette.INK)
            for name, words in short.items()
        ]
    if names:
        write_names(axes, names, plan.sheet(floor, plan.step_of(floor), dot=radius))


@dataclass(frozen=True)
class _Shades:
    """The colours of waiting, and the value from which lines and circles are largest."""

    norm: Normalize
    colours: Colormap
    most: float

    def size(self, value: float) -> float:
        """Return the size at which a value is drawn, from 0 to 1."""
        return min(value / self.most, 1.0)


def _map() -> Colormap:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("waiting", [palette.NO_WAIT, *palette.HEAT["light"]])


def _steps() -> _Shades:
    """Return a colour for each step of the scale, which is equal for all runs."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    colours = ListedColormap(palette.HEAT["light"]).with_extremes(under=palette.NO_WAIT)
    steps = [*palette.WAITED_STEPS, 1]
    return _Shades(BoundaryNorm(steps, colours.N), colours, palette.WAITED_STEPS[-1])


def _bar(axes: Axes, what: str, shades: _Shades) -> None:
    from matplotlib.cm import ScalarMappable

    figure = axes.get_figure(root=True)
    assert figure is not None
    bar = figure.colorbar(ScalarMappable(shades.norm, shades.colours), ax=axes, label=look.text(what), shrink=0.7)
    if shades.most == palette.WAITED_STEPS[-1]:
        middles = [(low + high) / 2 for low, high in pairwise([*palette.WAITED_STEPS, 1])]
        bar.set_ticks(middles, labels=step_words())
        bar.ax.tick_params(length=0)


def step_words() -> list[str]:
    """Return the steps of the scale in words; below the first is no colour."""
    percent = [f"{100 * step:g}" for step in palette.WAITED_STEPS]
    between = [f"{low} to {high} %" for low, high in pairwise(percent)]
    return [*between, f"over {percent[-1]} %"]
