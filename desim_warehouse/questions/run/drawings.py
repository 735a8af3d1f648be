"""Drawings on the page of a run: its use of time, its course by the clock, and the floor with waiting times."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator
from typing import TYPE_CHECKING

from desim_warehouse import plot
from desim_warehouse.answer import numbers
from desim_warehouse.answer.course import by_robot, figure
from desim_warehouse.answer.parts import Bar, Rows
from desim_warehouse.errors import number_of
from desim_warehouse.layout import Layout
from desim_warehouse.look import html
from desim_warehouse.look.labels import LETTER, Sheet, Spot, box_around, boxes_along
from desim_warehouse.look.palette import WAITED_STEPS
from desim_warehouse.outcome.account import OF_ROBOTS, OF_TASKS, By, counted_tasks
from desim_warehouse.outcome.day import day, shares_of_robots
from desim_warehouse.outcome.rows import waits_by_row
from desim_warehouse.outcome.zones import Zone, zones
from desim_warehouse.plot.floor import ends, step_of
from desim_warehouse.plot.heat import edge_values, node_values, step_words
from desim_warehouse.run import RunData

if TYPE_CHECKING:
    from markupsafe import Markup

_MARGIN = 0.03
"""Margin around the floor, as a share of its width."""
_ROWS = 4
"""Number of rows of the floor that have their own bar."""
_ARROWS = 200
"""Number of lanes beyond which none has an arrow."""
_LANES = 3000
"""Number of lanes beyond which the drawing is a picture."""
_SIZES = (("", 1.3), ("small", 0.75))
"""Sizes of names on every screen, and on wide screens only, as shares of the margin around the floor (see report.css).
"""
_DOT = 0.4
"""Radius of a node, as a share of the margin around the floor."""
_SAME = 1e-6
"""Difference below which steps between places are equal."""
_LEAST = 0.005
"""Share of a task's time from which on a part has its own bar."""


def drawings(run: RunData, named: str = "", below: Markup | None = None) -> list[Rows | Markup]:
    """Draw the figures that every page of a run has: its course by the clock, and the floor, as far as the log tells.

    `named`: a name for the run among others, such as `the median of 33 days`. `below`: the course of another run, drawn
    below its own.
    """
    parts = (course(run, named), below, floor(run))
    return [drawing for drawing in parts if drawing is not None]


def course(run: RunData, named: str = "", *, in_short: bool = False) -> Markup | None:
    """Draw the course of a run by the clock; None if the evaluation period is empty.

    Args:
        run: the run.
        named: a name for the run among others.
        in_short: draw only two lanes, and name the worst hour even if no stretch stands out.
    """
    if not run.history.counted:
        return None
    return figure(day(run.history), run.model, run.history.chargers, named=named, in_short=in_short)


def robots(run: RunData) -> Markup | None:
    """Draw the shares of each robot's time by activity; None if the evaluation period is empty."""
    return by_robot(shares_of_robots(run.history)) if run.history.counted else None


def floor(run: RunData) -> Markup | None:
    """Draw the map of waits of a run with goods, stations and bays; None if no robot waited."""
    if not run.kpis["S"]:
        return None
    if len(run.layout.lanes) > _LANES:
        return html.picture(plot.congestion(run))
    layout, step = run.layout, step_of(run.layout)
    lanes: defaultdict[int, list[str]] = defaultdict(list)
    for edge, waited in edge_values(run, "blocked").items():
        (x0, y0), (x1, y1) = ends(layout, edge, step)
        lanes[_step(run, waited)].append(f"M{_short(x0)} {_short(y0)}l{_short(x1 - x0)} {_short(y1 - y0)}")
    nodes = [
        (data["x"], data["y"], _step(run, waited))
        for (_, data), waited in zip(layout.graph.nodes(data=True), node_values(run, "blocked").values(), strict=True)
    ]
    places = zones(run.model, layout)
    slots = [(x, y, zone.room, zone.kind) for zone in places for x, y in zone.places]
    xs = [x for x, *_ in nodes] + [x for x, *_ in slots]
    ys = [y for _, y, _ in nodes] + [y for _, y, *_ in slots]
    room = _MARGIN * (max(xs) - min(xs) or 1.0)
    names = names_of_zones(layout, places, room)
    boxes = [spot.box for _, _, spot in names]
    xs += [x for left, _, right, _ in boxes for x in (left, right)]
    ys += [y for _, top, _, bottom in boxes for y in (top, bottom)]
    box = min(xs) - room, min(ys) - room, max(xs) - min(xs) + 2 * room, max(ys) - min(ys) + 2 * room
    side = 0.8 * (layout.goods_size or 0.09 * step) / 2
    rooms: defaultdict[tuple[str, float], list[str]] = defaultdict(list)
    for x, y, size, kind in slots:
        rooms[kind, size].append(f"M{_short(x)} {_short(y)}h0")
    goods = _columns([(place.x, place.y) for place in layout.storage], 2 * side)
    most = list(waits_by_row(run.history).items())[:1] if run.record.level == "all" else []
    title = f"Where robots wait: {numbers.PERCENT.value(run.kpis['share_waiting'])} of their time"
    title += "".join(f", at {row} alone {numbers.PERCENT.value(share)}" for row, share in most)
    return html.figure(
        *("floor", title, box, sorted(lanes.items()), _arrows(run, step), nodes, goods, 2 * side, rooms.items(), names),
        *(step_words(), room),
    )


def rows_of_floor(run: RunData) -> Rows | None:
    """Draw the rows of the floor in which robots wait; None if no row has 1 % of their time, or there are no rows."""
    by_row = waits_by_row(run.history) if run.record.level == "all" else {}
    if next(iter(by_row.values()), 0.0) < WAITED_STEPS[0]:
        return None
    most, kind = list(by_row.items())[:_ROWS], next(iter(by_row)).split()[0]
    rest = max(run.kpis["share_waiting"] - math.fsum(share for _, share in most), 0.0)
    marks = tuple(
        Bar(label=name, mean=share, text=f"{numbers.PERCENT.value(share)} of the fleet's time", standing="part")
        for name, share in (*most, ("all else", rest))
    )
    return Rows(title=f"Waiting in traffic, by {kind}", rows=marks)


def _columns(centres: list[tuple[float, float]], side: float) -> list[tuple[str, str]]:
    """Return paths of squares, each with its dashes: squares above one another at equal steps are one dashed line."""
    across = defaultdict(list)
    for x, y in centres:
        across[_short(x)].append(y)
    paths: defaultdict[str, list[str]] = defaultdict(list)
    for column, ys in across.items():
        for start, count, pitch in _even(sorted(set(ys))):
            gap = f"{_short(side)} {_short(pitch - side)}" if count > 1 else ""
            paths[gap].append(f"M{column} {_short(start - side / 2)}v{_short((count - 1) * pitch + side)}")
    return [("".join(path), gap) for gap, path in paths.items()]


def _even(values: list[float]) -> Iterator[tuple[float, int, float]]:
    """Yield the first value, the length and the step of each stretch of values with equal steps."""
    start = 0
    while start < len(values):
        end, step = start + 1, values[start + 1] - values[start] if start + 1 < len(values) else 0.0
        while end < len(values) and math.isclose(values[end] - values[end - 1], step, abs_tol=_SAME):
            end += 1
        yield values[start], end - start, step
        start = end


def _short(value: float) -> str:
    """Return a coordinate with at most three decimals, without superfluous zeros."""
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    if text in {"-0", ""}:
        return "0"
    return text.replace("0.", ".", 1) if text.lstrip("-").startswith("0.") else text


def _arrows(run: RunData, step: float) -> str:
    """Return the path of arrowheads in the middle of one-way lanes; empty if there are too many lanes."""
    edges, size = run.layout.graph.edges, 0.06 * step
    if len(run.layout.lanes) > _ARROWS:
        return ""
    heads = []
    for edge in run.layout.lanes:
        if not edges[edge].get("two_way"):
            (x0, y0), (x1, y1) = ends(run.layout, edge, step)
            long = math.hypot(x1 - x0, y1 - y0) or 1.0
            dx, dy = size * (x1 - x0) / long, size * (y1 - y0) / long
            x, y = (x0 + x1) / 2 + dx, (y0 + y1) / 2 + dy
            points = (x, y), (-2 * dx - dy, dx - 2 * dy), (2 * dy, -2 * dx)
            heads.append(
                "".join(f"{by}{_short(a)} {_short(b)}" for by, (a, b) in zip("Mll", points, strict=True)) + "z"
            )
    return "".join(heads)


def _step(run: RunData, waited: float) -> int:
    """Return the step of the colour scale for a waiting time; 0 if it is too short for a colour."""
    return bisect_right(WAITED_STEPS, waited / (run.history.counted or 1.0))


def names_of_zones(layout: Layout, places: list[Zone], room: float) -> list[tuple[str, str, Spot]]:
    """Return classes, name and spot of each zone that has room for its name, beyond its slots or beside them.

    A name that fits only in its smaller size is shown on wide screens only. `room`: the margin around the floor, to
    which sizes of names and nodes are relative.
    """
    step = step_of(layout)
    point_of = {node: (data["x"], data["y"]) for node, data in layout.graph.nodes(data=True)}
    slots = [[box_around(x, y, zone.room) for x, y in zone.places] for zone in places]
    sheet = Sheet([box_around(x, y, _DOT * room) for x, y in point_of.values()])
    sheet.marks += [box for boxes in slots for box in boxes]
    sheet.lines += [box for edge in layout.lanes for box in boxes_along(*ends(layout, edge, step), room)]
    sheet.lines += [box_around(place.x, place.y, layout.goods_size / 2) for place in layout.storage]
    names: list[tuple[str, str, Spot]] = []
    for zone, boxes in zip(places, slots, strict=True):
        x, y = point_of[zone.node]
        lefts, tops, rights, bottoms = zip(*boxes, strict=True)
        around = min(lefts), min(tops), max(rights), max(bottoms)
        dx, dy = (around[0] + around[2]) / 2 - x, (around[1] + around[3]) / 2 - y
        side = (1 if dx > 0 else -1, 0) if abs(dx) > abs(dy) else (0, 1 if dy > 0 else -1)
        sizes = [(LETTER * part * room * len(zone.name), part * room) for _, part in _SIZES]
        again = any(name == zone.name for _, name, _ in names)
        if put := sheet.put(sizes, around, room / 4, side, again=again):
            spot, size = put
            names.append((f"{zone.kind} {_SIZES[size][0]}".strip(), zone.name, spot))
    return names


def account(run: RunData) -> Rows | None:
    """Draw where the time of a task goes, or of a robot if there are no tasks; None without a full log."""
    if run.record.level != "all":
        return None
    by: By = "task" if counted_tasks(run.history) else "robot"
    shares = OF_TASKS if by == "task" else OF_ROBOTS
    table = run.account(by)
    parts = table.mean().sort_values(ascending=False)
    whole = float(parts.sum())
    if not whole:
        return None
    unit = numbers.times(run.model.units.time, [float(parts.iloc[0])])
    marks = tuple(
        Bar(
            label=shares[str(name)].doing,
            mean=float(part),
            text=f"{unit.value(float(part))} · {100 * part / whole:.0f} %",
            standing="part",
        )
        for name, part in parts.items()
        if part >= _LEAST * whole
    )
    many = number_of(len(table), by)
    return Rows(title=f"Where the {unit.value(whole)} of a {by} go, mean of {many}", rows=marks)
