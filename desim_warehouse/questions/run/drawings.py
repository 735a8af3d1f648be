"""Drawings of a run inside its page: where the time goes, the course by the clock, and the floor by waiting."""

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
from desim_warehouse.look import html
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
"""Room around the floor, as a part of its width."""
_ROWS = 4
"""Rows that have a bar of their own."""
_ARROWS = 200
"""Of more lanes none has an arrow."""
_LANES = 3000
"""Of more lanes the drawing is a picture."""
_LETTER = 0.45
"""Width of a letter in the names of zones, as a part of the room around the floor."""
_SIDES = {"end": -1, "middle": 0, "start": 1}
"""Where a text lies beside its point, by its anchor."""
_SAME = 1e-6
"""Steps between places that differ by less are the same."""
_LEAST = 0.005
"""Part of a task's time from which on it has a bar of its own."""


def drawings(run: RunData, named: str = "", below: Markup | None = None) -> list[Rows | Markup]:
    """Draw what every page has of a run: its course by the clock, and the floor, as far as the log tells.

    `named`: what the run is among others, as `the median of 33 days`; `below` its course: that of another.
    """
    parts = (course(run, named), below, floor(run))
    return [drawing for drawing in parts if drawing is not None]


def course(run: RunData, named: str = "", *, in_short: bool = False) -> Markup | None:
    """Draw how the run went by the clock; None where no time was counted.

    Args:
        run: the run.
        named: what it is among others.
        in_short: draw two lanes alone, and name the worst hour also where no stretch stands out.
    """
    if not run.history.counted:
        return None
    return figure(day(run.history), run.model, run.history.chargers, named=named, in_short=in_short)


def robots(run: RunData) -> Markup | None:
    """Draw for which parts of its time each robot did what; None where no time was counted."""
    return by_robot(shares_of_robots(run.history)) if run.history.counted else None


def floor(run: RunData) -> Markup | None:
    """Draw the map of waits of a run with goods, stations and bays; None where nobody waited."""
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
    names = _names(run, places, (min(ys) + max(ys)) / 2, room)
    xs += [x + _SIDES[anchor] * _LETTER * room * len(name) for _, x, _, name, anchor in names]
    ys += [y for _, _, y, _, _ in names]
    box = min(xs) - 2 * room, min(ys) - room, max(xs) - min(xs) + 4 * room, max(ys) - min(ys) + 2 * room
    side = 0.8 * (layout.goods_size or 0.09 * step) / 2
    rooms: defaultdict[tuple[str, float], list[str]] = defaultdict(list)
    for x, y, size, kind in slots:
        rooms[kind, size].append(f"M{_short(x)} {_short(y)}h0")
    goods = _columns([(one.x, one.y) for one in layout.storage], 2 * side)
    most = list(waits_by_row(run.history).items())[:1] if run.record.level == "all" else []
    title = f"Where robots wait: {numbers.PERCENT.value(run.kpis['share_waiting'])} of their time"
    title += "".join(f", at {row} alone {numbers.PERCENT.value(share)}" for row, share in most)
    return html.figure(
        *("floor", title, box, sorted(lanes.items()), _arrows(run, step), nodes, goods, 2 * side, rooms.items(), names),
        *(step_words(), room),
    )


def rows_of_floor(run: RunData) -> Rows | None:
    """Draw in which rows of the floor robots wait; None where none has 1 % of their time, or there are no rows."""
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
    """Return the paths of squares with the dashes of each: places that stand above one another are one dashed line."""
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
    """Yield the first, the number and the step of each stretch of values with one step between them."""
    start = 0
    while start < len(values):
        end, step = start + 1, values[start + 1] - values[start] if start + 1 < len(values) else 0.0
        while end < len(values) and math.isclose(values[end] - values[end - 1], step, abs_tol=_SAME):
            end += 1
        yield values[start], end - start, step
        start = end


def _short(value: float) -> str:
    """Write a coordinate with three decimals at most, without zeros that say nothing."""
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    if text in {"-0", ""}:
        return "0"
    return text.replace("0.", ".", 1) if text.lstrip("-").startswith("0.") else text


def _arrows(run: RunData, step: float) -> str:
    """Return the path of arrowheads in the middle of one-way lanes, where there is room for them."""
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
    """Return the step of the scale for a time waited: 0 where it is too short for a colour."""
    return bisect_right(WAITED_STEPS, waited / (run.history.counted or 1.0))


def _names(run: RunData, places: list[Zone], middle: float, room: float) -> list[tuple[str, float, float, str, str]]:
    """Return kind, point, name and anchor of each zone: beyond its slots, else away from the middle."""
    names = []
    for zone in places:
        node = run.layout.graph.nodes[zone.node]
        xs, ys = zip(*zone.places, strict=True)
        x, y, away = sum(xs) / len(xs), sum(ys) / len(ys), 0.8 * room + zone.room
        if abs(x - node["x"]) > abs(y - node["y"]):
            anchor = "start" if x > node["x"] else "end"
            beside = max(xs) + away / 2 if x > node["x"] else min(xs) - away / 2
            names.append((zone.kind, beside, y, zone.name, anchor))
        else:
            edge = max(ys) if y > node["y"] else min(ys)
            names.append((zone.kind, x, edge + (away if edge > middle else -away), zone.name, "middle"))
    return names


def account(run: RunData) -> Rows | None:
    """Draw where the time of a task goes, or of a robot without tasks, in one unit; None: the log does not say."""
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
