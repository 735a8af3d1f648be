"""The warehouse drawn: nodes, one-way edges, goods, bays and stations."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from desim_warehouse.report import palette
from desim_warehouse.report.plot import style as look
from desim_warehouse.report.zones import robot_radii, zones
from desim_warehouse.run import Run

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model

_NAMED = 60
"""Up to so many nodes have their names drawn."""
BAY, STATION, GOOD, FETCHED = palette.COLOURS[2], palette.COLOURS[0], "#BBBBBB", palette.COLOURS[1]


def layout(
    source: Model | Run,
    *,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """The floor of a model: nodes with names, one-way arrows, goods, places in bays and stations, unloading nodes.

    Goods that the task list fetches are filled, all others are outlined. Names are drawn for up to 60 nodes.
    """
    from desim_warehouse.layout import build

    model = source.model if isinstance(source, Run) else source
    floor = source.layout if isinstance(source, Run) else build(model.layout)
    step = step_of(floor)
    with look.drawing(ax, style, title, size_of(floor), f"Layout of {model.name}") as axes:
        draw_goods(axes, floor, step, fetched_of(model))
        draw_edges(axes, floor, step, palette.FAINT)
        beside = _zones(axes, floor, model)
        draw_nodes(axes, floor, set(model.tasks.unload_at))
        frame(axes, floor, step, model, beside)
        _key(axes, floor, model)
        return axes


def step_of(floor: Layout) -> float:
    """How large things are on this floor: the length of its shortest edge as drawn."""
    lengths = [math.dist(_at(floor, a), _at(floor, b)) for a, b in floor.graph.edges]
    return min((length for length in lengths if length > 0), default=1.0)


def size_of(floor: Layout) -> tuple[float, float]:
    """Size of a figure, in inches, in the proportions of the floor."""
    nodes = floor.graph.nodes(data=True)
    xs, ys = [data["x"] for _, data in nodes], [data["y"] for _, data in nodes]
    across, down = max(xs) - min(xs) or 1.0, max(ys) - min(ys) or 1.0
    return 7.2, min(max(5.6 * down / across + 1.2, 2.6), 8.0)


def fetched_of(model: Model) -> set[int]:
    """The goods that a task list names; none where goods are drawn."""
    goods = model.tasks.goods
    if not isinstance(goods, tuple):
        return set()
    return {item if isinstance(item, int) else item.good for item in goods}


def _at(floor: Layout, node: str) -> tuple[float, float]:
    data = floor.graph.nodes[node]
    return data["x"], data["y"]


def ends(floor: Layout, edge: tuple[str, str], step: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """The two ends of an edge as drawn: beside its opposite direction where both are there."""
    (x0, y0), (x1, y1) = _at(floor, edge[0]), _at(floor, edge[1])
    if not floor.graph.has_edge(edge[1], edge[0]):
        return (x0, y0), (x1, y1)
    length = math.dist((x0, y0), (x1, y1)) or 1.0
    by = 0.03 * step / length
    dx, dy = -(y1 - y0) * by, (x1 - x0) * by
    return (x0 + dx, y0 + dy), (x1 + dx, y1 + dy)


def draw_goods(axes: Axes, floor: Layout, step: float, fetched: set[int]) -> None:
    """A square for each storage place; those in `fetched` filled."""
    from matplotlib.collections import PatchCollection
    from matplotlib.patches import Rectangle

    side = 0.8 * (floor.goods_size or 0.09 * step)
    for wanted in (False, True):
        squares = [
            Rectangle((place.x - side / 2, place.y - side / 2), side, side)
            for place in floor.storage
            if (place.number in fetched) == wanted
        ]
        axes.add_collection(
            PatchCollection(
                squares,
                facecolor=FETCHED if wanted else "white",
                edgecolor=FETCHED if wanted else GOOD,
                linewidth=0.8,
                zorder=1,
            )
        )


def draw_edges(axes: Axes, floor: Layout, step: float, colour: str) -> None:
    """A line for each one-way edge, its arrow in the middle."""
    from matplotlib.collections import LineCollection

    lines = [ends(floor, edge, step) for edge in floor.graph.edges]
    axes.add_collection(LineCollection(lines, colors=colour, linewidths=1.0, zorder=2))
    arrows(axes, lines, colour)


def arrows(axes: Axes, lines: list[tuple[tuple[float, float], tuple[float, float]]], colour: str) -> None:
    """An arrow head for each line, a little beyond its middle."""
    if not lines:
        return
    x = [0.44 * x0 + 0.56 * x1 for (x0, _), (x1, _) in lines]
    y = [0.44 * y0 + 0.56 * y1 for (_, y0), (_, y1) in lines]
    lengths = [math.dist(*line) or 1.0 for line in lines]
    u = [(x1 - x0) / n for ((x0, _), (x1, _)), n in zip(lines, lengths, strict=True)]
    v = [(y1 - y0) / n for ((_, y0), (_, y1)), n in zip(lines, lengths, strict=True)]
    size = 0.012 if len(lines) <= 2 * _NAMED else 0.006
    axes.quiver(
        x,
        y,
        u,
        v,
        color=colour,
        angles="xy",
        pivot="mid",
        units="width",
        scale=1 / size,
        width=size / 6,
        headwidth=6,
        headlength=6,
        headaxislength=6,
        minlength=0,
        zorder=2.5,
    )


def draw_nodes(axes: Axes, floor: Layout, unloading: set[str]) -> None:
    """A dot for each node, with its name where there are few; unloading nodes in the colour of stations."""
    graph = floor.graph
    named = len(graph) <= _NAMED
    for chosen, colour in ((False, palette.INK), (True, STATION)):
        nodes = [name for name in graph if (name in unloading) == chosen]
        axes.scatter(
            [graph.nodes[name]["x"] for name in nodes],
            [graph.nodes[name]["y"] for name in nodes],
            s=(150 if named else 8),
            color="white" if named else colour,
            edgecolors=colour,
            linewidths=1.0 if not chosen else 1.8,
            zorder=3,
        )
        if named:
            for name in nodes:
                axes.text(
                    *_at(floor, name),
                    look.text(name if len(name) <= 6 else f"{name[:5]}…"),  # noqa: PLR2004 - fits the dot
                    ha="center",
                    va="center_baseline",
                    fontsize="x-small",
                    color=colour,
                    zorder=4,
                )


def _zones(axes: Axes, floor: Layout, model: Model) -> list[tuple[float, float]]:
    """The places of bays and stations beside their nodes; returns where they are."""
    from matplotlib.collections import LineCollection, PatchCollection
    from matplotlib.patches import Rectangle

    side = 2 * max(robot_radii(model))
    found: list[tuple[float, float]] = []
    for zone in zones(model, floor):
        colour = BAY if zone.kind == "bay" else STATION
        squares = [Rectangle((x - side / 2, y - side / 2), side, side) for x, y in zone.places]
        axes.add_collection(PatchCollection(squares, facecolor=colour, edgecolor="white", linewidth=0.5, zorder=3))
        joint = [(_at(floor, zone.node), zone.places[0])]
        axes.add_collection(LineCollection(joint, colors=colour, linewidths=1.0, zorder=1.5))
        found += zone.places
    return found


def frame(axes: Axes, floor: Layout, step: float, model: Model, beside: Sequence[tuple[float, float]] = ()) -> None:
    """The whole floor in sight, y downwards as in the model file, both axes alike, in its length unit."""
    nodes = [*(_at(floor, name) for name in floor.graph), *beside]
    xs, ys = [x for x, _ in nodes], [y for _, y in nodes]
    room = 0.25 * step
    axes.set_xlim(min(xs) - room, max(xs) + room)
    axes.set_ylim(max(ys) + room, min(ys) - room)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_xlabel(look.text(f"x ({model.units.length})"))
    axes.set_ylabel(look.text(f"y ({model.units.length})"))


def _key(axes: Axes, floor: Layout, model: Model) -> None:
    from matplotlib.lines import Line2D

    marks = [("unloading node", "o", "white", STATION)]
    if fetched_of(model):
        marks.append(("good to fetch", "s", FETCHED, FETCHED))
    marks.append(("storage place", "s", "white", GOOD))
    if floor.bays:
        marks.append(("bay place", "s", BAY, BAY))
    if floor.stations:
        marks.append(("station place", "s", STATION, STATION))
    handles = [
        Line2D([], [], linestyle="none", marker=mark, markerfacecolor=face, markeredgecolor=edge, label=label)
        for label, mark, face, edge in marks
    ]
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=len(handles))
