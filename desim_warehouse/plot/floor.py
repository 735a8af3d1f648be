"""The warehouse drawn: nodes, lanes, goods, bays and stations.

For `plot.layout`, `desim draw` and `desim export`, and the page of a run.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

from desim_warehouse.errors import ReportError, reason, spoken
from desim_warehouse.folders import MAKER, refuse_other
from desim_warehouse.layout import Layout
from desim_warehouse.look import palette
from desim_warehouse.look.labels import Box, Sheet, box_around, boxes_along
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.model.facts.places import destinations
from desim_warehouse.outcome.zones import Zone, robot_radii, zones
from desim_warehouse.plot import cells
from desim_warehouse.plot import style as look
from desim_warehouse.plot.names import Name, write_names
from desim_warehouse.run import RunData

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from desim_warehouse.layout.layout import Lift


NAMED = 60
"""The most nodes that are labelled in a figure of usual size."""
_IN_DOT = 3
"""Characters of a name that fit into the dot of a node; longer ones stand beside it."""
_LETTER, _WIDEST = 0.1, 40.0
"""Inches for each letter between neighbouring nodes in a figure that is drawn to be read, and its greatest width."""
_ARROW = 0.085
"""Inches of an arrow head; half where there are many."""
_CABIN = 0.25
"""Side of a cabin, as a part of the shortest edge."""
_ENDINGS = (".png", ".svg", ".pdf")
BAY, CHARGER, STATION = palette.BAY, palette.CHARGER, palette.STATION
GOOD, FETCHED = "#BBBBBB", palette.PALETTES["safe"]["light"]["good"]


def layout(
    source: Model | RunData,
    *,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Draw the floor of a model: nodes, lanes with arrows, goods, slots of bays and stations with names, chargers.

    Goods that the task list fetches are filled, all others are outlined. Nodes are named if there are up to 60. A floor
    of many cells is drawn as a map: aisles light, shelves dark, with colours for storage places, bays and stations.
    """
    model, floor = _model_and_floor(source)
    return _drawn(model, floor, title, style, ax, size_of(floor), named=len(floor.graph) <= NAMED)


def save(source: Model | RunData, path: str | Path, *, title: str | None = None, names: bool = False) -> Path:
    """Write the floor of a model to a PNG, SVG or PDF file: so large that the names of nodes can be read, or as a map.

    Where they could not be read even at the greatest width, nodes have no names. `names`: also those of storage places.

    Raises:
        ReportError: another ending, or a file that cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in _ENDINGS:
        raise ReportError(f"{path}: a picture of which kind? Expected a name that ends in {spoken(_ENDINGS, 'or')}")
    model, floor = _model_and_floor(source)
    width, height = size_of(floor)
    if cells.is_map(model, floor):
        across = cells.width(model, floor)
        size = across, across * (height - 1.2) / width + 1.2
        drawn = _drawn(model, floor, title or model.name, "light", None, size, named=False)
        return _written(_with_names(drawn, floor) if names else drawn, path)
    xs = [data["x"] for _, data in floor.graph.nodes(data=True)]
    letters = _LETTER * (2 + max(map(len, floor.graph))) * (max(xs) - min(xs))
    lengths = sorted(_lengths(floor))
    needed = letters / lengths[len(lengths) // 10]  # one very short edge does not make it a poster
    larger = min(max(needed / width, 1.4), _WIDEST / width)
    size = width * larger, (height - 1.2) * larger + 1.2
    readable = letters / median(_lengths(floor)) <= _WIDEST  # names on top of each other would only take time
    drawn = _drawn(model, floor, title or model.name, "light", None, size, named=readable)
    return _written(_with_names(drawn, floor) if names else drawn, path)


def _with_names(axes: Axes, floor: Layout) -> Axes:
    """Write the name, or else the number, of each storage place beside it."""
    for place in floor.storage:
        name = look.text(floor.called.get(place.number, str(place.number)))
        axes.text(place.x, place.y, name, fontsize=3, ha="center", va="center", color=palette.INK, zorder=5)
    return axes


def _written(axes: Axes, path: Path) -> Path:
    import matplotlib as mpl

    figure = axes.get_figure(root=True)
    assert figure is not None
    by = {"Software" if path.suffix.lower() == ".png" else "Creator": MAKER}
    try:
        refuse_other(path, "picture")
        with mpl.rc_context({"svg.fonttype": "none"}):  # names that can be searched for
            figure.savefig(path, dpi=cells.DPI, bbox_inches="tight", metadata=by)
    except OSError as error:
        raise ReportError(f"{path}: cannot be written ({reason(error)})") from error
    return path


def _model_and_floor(source: Model | RunData) -> tuple[Model, Layout]:
    return (source.model, source.layout) if isinstance(source, RunData) else (source, source.floor)


def _drawn(
    model: Model,
    floor: Layout,
    title: str | None,
    style: look.Style,
    ax: Axes | None,
    size: tuple[float, float],
    *,
    named: bool,
) -> Axes:
    step = step_of(floor)
    with look.drawing(ax, style, title, size, f"Layout of {model.name}") as axes:
        if cells.is_map(model, floor):
            cells.draw(axes, floor, model)
            return axes
        draw_goods(axes, floor, step, fetched_of(model))
        draw_edges(axes, floor, step, palette.FAINT)
        slots, names = _zones(axes, floor, model)
        names = [*names_of_floors(floor), *names]
        names += draw_nodes(axes, floor, set(destinations(model, floor)), named)
        names += [_name_of_lift(floor, lift) for lift in floor.lifts]
        frame(axes, floor, step, model, _corners(slots))
        boxes = write_names(axes, names, sheet(floor, step, slots))
        frame(axes, floor, step, model, _corners([*slots, *boxes]))
        _key(axes, floor, model)
        return axes


def step_of(floor: Layout) -> float:
    """Return the size of symbols on this floor: the length of its shortest edge as drawn."""
    return min(_lengths(floor))


def _lengths(floor: Layout) -> list[float]:
    """Return the lengths of all edges as drawn; 1 for a floor without edges."""
    lengths = [math.dist(_at(floor, a), _at(floor, b)) for a, b in floor.graph.edges]
    return [length for length in lengths if length > 0] or [1.0]


def size_of(floor: Layout) -> tuple[float, float]:
    """Return the size of a figure, in inches, in the proportions of the floor."""
    nodes = floor.graph.nodes(data=True)
    xs, ys = [data["x"] for _, data in nodes], [data["y"] for _, data in nodes]
    across, down = max(xs) - min(xs) or 1.0, max(ys) - min(ys) or 1.0
    return 7.2, min(max(5.6 * down / across + 1.2, 2.6), 8.0)


def fetched_of(model: Model) -> set[int]:
    """Return the goods that a task list names; none where goods are drawn."""
    goods = model.tasks.goods
    if not isinstance(goods, tuple):
        return set()
    return {item if isinstance(item, int) else item.good for item in goods}


def _at(floor: Layout, node: str) -> tuple[float, float]:
    data = floor.graph.nodes[node]
    return data["x"], data["y"]


def ends(floor: Layout, edge: tuple[str, str], step: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the two ends of an edge as drawn: beside its opposite direction where that is a lane of its own."""
    (x0, y0), (x1, y1) = _at(floor, edge[0]), _at(floor, edge[1])
    if not floor.graph.has_edge(edge[1], edge[0]) or floor.graph.edges[edge].get("two_way"):
        return (x0, y0), (x1, y1)
    length = math.dist((x0, y0), (x1, y1)) or 1.0
    by = 0.03 * step / length
    dx, dy = -(y1 - y0) * by, (x1 - x0) * by
    return (x0 + dx, y0 + dy), (x1 + dx, y1 + dy)


def draw_goods(axes: Axes, floor: Layout, step: float, fetched: set[int]) -> None:
    """Draw a square for each storage place; the ones in `fetched` filled."""
    from desim_warehouse.plot import paths

    side = 0.8 * (floor.goods_size or 0.09 * step)
    for wanted, inside, around in ((False, "white", GOOD), (True, FETCHED, FETCHED)):
        places = [(place.x, place.y) for place in floor.storage if (place.number in fetched) == wanted]
        paths.squares(axes, places, side, 1, facecolor=inside, edgecolor=around, linewidth=0.8)


def draw_edges(axes: Axes, floor: Layout, step: float, colour: str) -> None:
    """Draw a line for each lane, with an arrow in its middle; a two-way lane has one each way. Lifts are dashed."""
    from desim_warehouse.plot import paths

    lanes = [edge for edge in floor.lanes if edge not in floor.rides]
    paths.lines(axes, (ends(floor, edge, step) for edge in lanes), colour, 1.0, 2)
    for both, part in ((False, 0.56), (True, 0.7)):
        some = [edge for edge, _, _, two_way in floor.edges if two_way == both and edge not in floor.rides]
        arrows(axes, [ends(floor, edge, step) for edge in some], colour, part)
    _draw_lifts(axes, floor, step, colour)


def _draw_lifts(axes: Axes, floor: Layout, step: float, colour: str) -> None:
    """Draw a broken line from floor to floor for each lift, and its cabin as a square on each floor."""
    from desim_warehouse.plot import paths

    for lift in floor.lifts:
        places = [_at(floor, node) for node in lift.nodes]
        axes.plot(*zip(*places, strict=True), color=colour, linewidth=1.0, linestyle=(0, (4, 4)), zorder=1.5)
        paths.squares(axes, places, _CABIN * step, 2.2, facecolor="white", edgecolor=colour, linewidth=1.0)


def _name_of_lift(floor: Layout, lift: Lift) -> Name:
    (x0, y0), (x1, y1) = (_at(floor, node) for node in lift.nodes[:2])
    return Name(f"lift {lift.name}", box_around((x0 + x1) / 2, (y0 + y1) / 2, 0.0), (1, 0), "x-small", palette.FAINT)


def names_of_floors(floor: Layout) -> list[Name]:
    """Return the names of floors that lifts join, to be written above them; none where there is one floor."""
    corners = defaultdict[int, list[tuple[float, float]]](list)
    cabins = {node for lift in floor.lifts for node in lift.nodes}
    for node in floor.graph if floor.lifts else ():
        if node not in cabins:
            corners[floor.floors[node]].append(_at(floor, node))
    names = []
    for number, points in sorted(corners.items()):
        xs, ys = zip(*points, strict=True)
        around = min(xs), min(ys), max(xs), max(ys)
        names.append(Name(floor.floor_titles[number], around, (0, -1), "medium", palette.INK))
    return names


def arrows(
    axes: Axes, lines: list[tuple[tuple[float, float], tuple[float, float]]], colour: str, part: float = 0.56
) -> None:
    """Draw an arrow head for each line, a little beyond its middle, of one size on all figures."""
    import numpy as np

    from desim_warehouse.plot import paths

    if not lines:
        return
    (x0, y0), (x1, y1) = np.array(lines, dtype=float).transpose(1, 2, 0)
    begin, end = x0 + 1j * y0, x1 + 1j * y1
    size = _ARROW if len(lines) <= 2 * NAMED else _ARROW / 2
    paths.heads(axes, (1 - part) * begin + part * end, end - begin, size, colour, 2.5)


def draw_nodes(axes: Axes, floor: Layout, unloading: set[str], named: bool) -> list[Name]:
    """Draw a dot for each node, with its name if it is short enough; returns the names to be written beside nodes.

    Unloading nodes have the colour of stations.
    """
    graph = floor.graph
    inside = named and max(map(len, graph)) <= _IN_DOT
    beside = []
    for chosen, colour in ((True, STATION), (False, palette.INK)):
        nodes = [name for name in graph if (name in unloading) == chosen]
        axes.scatter(
            [graph.nodes[name]["x"] for name in nodes],
            [graph.nodes[name]["y"] for name in nodes],
            s=(150 if inside else 8),
            color="white" if inside else colour,
            edgecolors=colour,
            linewidths=1.0 if not chosen else 1.8,
            zorder=3,
        )
        for name in nodes if named else ():
            if inside:
                axes.text(
                    *(*_at(floor, name), look.text(name)),
                    ha="center",
                    va="center_baseline",
                    fontsize="x-small",
                    color=colour,
                    zorder=4,
                )
            else:
                beside.append(Name(name, box_around(*_at(floor, name), 0.0), (1, -1), "xx-small", colour))
    return beside


def sheet(floor: Layout, step: float, slots: Sequence[Box] = (), dot: float = 0.0) -> Sheet:
    """Return the boxes that names on a drawing may not cover, and those that they should not.

    `dot`: least radius of nodes.
    """
    nodes = [box_around(*_at(floor, node), max(0.02 * step, dot)) for node in floor.graph]
    cabins = [box_around(*_at(floor, node), _CABIN * step / 2) for lift in floor.lifts for node in lift.nodes]
    lanes = [box for edge in floor.lanes for box in boxes_along(*ends(floor, edge, step), 0.1 * step)]
    side = 0.8 * (floor.goods_size or 0.09 * step)
    return Sheet([*nodes, *cabins, *slots], [*lanes, *(box_around(item.x, item.y, side / 2) for item in floor.storage)])


def _corners(boxes: Sequence[Box]) -> list[tuple[float, float]]:
    return [(x, y) for left, top, right, bottom in boxes for x, y in ((left, top), (right, bottom))]


def _zones(axes: Axes, floor: Layout, model: Model) -> tuple[list[Box], list[Name]]:
    """Draw the slots of bays and stations beside their nodes; returns where they are, and the names to be written."""
    from desim_warehouse.plot import paths

    largest = max(robot_radii(model))
    chargers = chargers_at(model, floor) if model.battery is not None else {}
    written: dict[str, Name] = {}
    slots: defaultdict[tuple[str, float], list[tuple[float, float]]] = defaultdict(list)
    joints: defaultdict[str, list[tuple[tuple[float, float], tuple[float, float]]]] = defaultdict(list)
    for zone in zones(model, floor):
        colour, side = BAY if zone.kind == "bay" else STATION, 2 * min(largest, zone.room)
        charging = chargers.get(zone.node, 0) if zone.kind == "bay" else 0
        slots[CHARGER, side] += zone.places[:charging]
        slots[colour, side] += zone.places[charging:]
        joints[colour].append((_at(floor, zone.node), zone.places[0]))
        if zone.name not in written:  # once: the colour says which others belong to it
            written[zone.name] = _name_of(floor, zone, side, CHARGER if charging == len(zone.places) else colour)
    for (colour, side), places in slots.items():
        paths.squares(axes, places, side, 3, facecolor=colour, edgecolor="white", linewidth=0.5)
    for colour, lines in joints.items():
        paths.lines(axes, lines, colour, 1.0, 1.5)
    boxes = [box_around(x, y, side / 2) for (_, side), places in slots.items() for x, y in places]
    return boxes, list(written.values())


def _name_of(floor: Layout, zone: Zone, side: float, colour: str) -> Name:
    """Return the name of a bay or station, to be written beyond its slots if it can be."""
    x, y = _at(floor, zone.node)
    dx, dy = zone.places[0][0] - x, zone.places[0][1] - y
    xs, ys = zip(*zone.places, strict=True)
    around = min(xs) - side / 2, min(ys) - side / 2, max(xs) + side / 2, max(ys) + side / 2
    outward = (0, 1 if dy >= 0 else -1) if abs(dy) >= abs(dx) else (1 if dx > 0 else -1, 0)
    return Name(zone.name, around, outward, "small", colour)


def frame(axes: Axes, floor: Layout, step: float, model: Model, beside: Sequence[tuple[float, float]] = ()) -> None:
    """Set the limits of the axes so that the whole floor is shown."""
    nodes = [*(_at(floor, name) for name in floor.graph), *beside]
    xs, ys = [x for x, _ in nodes], [y for _, y in nodes]
    room = 0.25 * step
    look.floor_axes(axes, model, (min(xs) - room, max(xs) + room), (min(ys) - room, max(ys) + room))


def _key(axes: Axes, floor: Layout, model: Model) -> None:
    from matplotlib.lines import Line2D

    marks = [("unloading node", "o", "white", STATION)]
    if fetched_of(model):
        marks.append(("item to pick", "s", FETCHED, FETCHED))
    marks.append(("storage place", "s", "white", GOOD))
    if floor.bays:
        marks.append(("bay", "s", BAY, BAY))
    if model.battery is not None and chargers_at(model, floor):
        marks.append(("charger", "s", CHARGER, CHARGER))
    if floor.stations:
        marks.append(("station", "s", STATION, STATION))
    handles = [
        Line2D([], [], linestyle="none", marker=mark, markerfacecolor=face, markeredgecolor=edge, label=label)
        for label, mark, face, edge in marks
    ]
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0.0), borderaxespad=4.5, ncols=len(handles))
