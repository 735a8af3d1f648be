"""Drawings of a run inside its page: the floor, coloured by how long robots wait there, and where the time goes."""

from __future__ import annotations

import math
from base64 import b64encode
from bisect import bisect_right
from collections import defaultdict

from desim_warehouse.answer import numbers
from desim_warehouse.answer.course import figure
from desim_warehouse.answer.page import rows
from desim_warehouse.answer.parts import Bar, Rows
from desim_warehouse.errors import number_of
from desim_warehouse.look import html
from desim_warehouse.look.html import Html
from desim_warehouse.look.palette import WAITED_STEPS
from desim_warehouse.outcome.account import OF_ROBOTS, OF_TASKS, By, counted_tasks
from desim_warehouse.outcome.day import day
from desim_warehouse.outcome.rows import waits_by_row
from desim_warehouse.outcome.zones import Zone, zones
from desim_warehouse.plot.floor import ends, step_of
from desim_warehouse.plot.heat import edge_values, node_values, step_words
from desim_warehouse.run import RunData

_MARGIN = 0.03
"""Room around the floor, as a part of its width."""
_ROWS = 4
"""Rows that have a bar of their own."""
_ARROWS = 200
"""Of more lanes none has an arrow."""
_LANES = 3000
"""Of more lanes the drawing is a picture."""


def course(run: RunData) -> Html | None:
    """How the run went by the clock; None where no time was counted."""
    if not run.history.counted:
        return None
    return figure(day(run.history), run.model, run.history.chargers)


def floor(run: RunData) -> Html | None:
    """The map of waits of a run with goods, stations and bays; None where nobody waited."""
    if not run.kpis["S"]:
        return None
    if len(run.layout.lanes) > _LANES:
        return _picture(run)
    layout, step = run.layout, step_of(run.layout)
    lanes: defaultdict[int, list[str]] = defaultdict(list)
    for edge, waited in edge_values(run, "blocked").items():
        (x0, y0), (x1, y1) = ends(layout, edge, step)
        lanes[_step(run, waited)].append(f"M{x0:.4g} {y0:.4g}L{x1:.4g} {y1:.4g}")
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
    ys += [y for _, _, y, _ in names]
    box = min(xs) - 2 * room, min(ys) - room, max(xs) - min(xs) + 4 * room, max(ys) - min(ys) + 2 * room
    side = 0.8 * (layout.goods_size or 0.09 * step) / 2
    goods = "".join(f"M{one.x - side:.4g} {one.y:.4g}h{2 * side:.3g}" for one in layout.storage)
    title, by_row = _where(run)
    drawn = html.figure(
        *("floor", title, box, sorted(lanes.items()), _arrows(run, step), nodes, goods, 2 * side, slots, names),
        *(step_words(), room),
    )
    return drawn if by_row is None else drawn + by_row


def _where(run: RunData) -> tuple[str, Html | None]:
    """Say for which part of their time robots wait and in which row most, with bars of the rows if that is much."""
    share = run.kpis["share_waiting"]
    title = f"Where robots wait: {numbers.PERCENT.value(share)} of their time"
    found = waits_by_row(run.history) if run.record.level == "all" else {}
    if next(iter(found.values()), 0.0) < WAITED_STEPS[0]:
        return title, None
    most = list(found.items())[:_ROWS]
    title += f", {most[0][0]} alone {numbers.PERCENT.value(most[0][1])}"
    rest = max(share - math.fsum(part for _, part in most), 0.0)
    marks = tuple(
        Bar(label=name, mean=part, text=f"{numbers.PERCENT.value(part)} of the fleet's time", standing="part")
        for name, part in (*most, ("all else", rest))
    )
    return title, rows(Rows(title="The same, by rows of the floor", rows=marks))


def _arrows(run: RunData, step: float) -> str:
    """Heads of arrows in the middle of one-way lanes, where there is room for them."""
    edges, size = run.layout.graph.edges, 0.06 * step
    if len(run.layout.lanes) > _ARROWS:
        return ""
    drawn = []
    for edge in run.layout.lanes:
        if not edges[edge].get("two_way"):
            (x0, y0), (x1, y1) = ends(run.layout, edge, step)
            long = math.hypot(x1 - x0, y1 - y0) or 1.0
            dx, dy = size * (x1 - x0) / long, size * (y1 - y0) / long
            x, y = (x0 + x1) / 2 + dx, (y0 + y1) / 2 + dy
            drawn.append(f"M{x:.4g} {y:.4g}l{-2 * dx - dy:.3g} {-2 * dy + dx:.3g}l{2 * dy:.3g} {-2 * dx:.3g}z")
    return "".join(drawn)


def _step(run: RunData, waited: float) -> int:
    """The step of the scale of a time waited: 0 where nobody waits, or for so short a time that it has no colour."""
    return bisect_right(WAITED_STEPS, waited / (run.history.counted or 1.0))


def _names(run: RunData, places: list[Zone], middle: float, room: float) -> list[tuple[str, float, float, str]]:
    """Kind, point and name of each zone: beyond its slots, as seen from its node, away from the middle."""
    found = []
    for zone in places:
        node = run.layout.graph.nodes[zone.node]
        xs, ys = zip(*zone.places, strict=True)
        away = 0.8 * room + zone.room
        y = max(ys) if sum(ys) / len(ys) > node["y"] else min(ys)
        found.append((zone.kind, sum(xs) / len(xs), y + (away if y > middle else -away), zone.name))
    return found


def _picture(run: RunData) -> Html:
    from desim_warehouse import plot

    data, facts = plot.congestion(run)._repr_png_()  # type: ignore[attr-defined] # what Jupyter calls, too
    return html.picture(b64encode(data).decode("ascii"), facts["width"], facts["alt"])


_LEAST = 0.005
"""Part of a task's time from which on it has a bar of its own."""


def account(run: RunData) -> Html | None:
    """Where the time of a task goes, of a robot where there were none, in one unit; None: the log does not say."""
    if run.record.level != "all":
        return None
    by: By = "task" if counted_tasks(run.history) else "robot"
    of = OF_TASKS if by == "task" else OF_ROBOTS
    table = run.account(by)
    parts = table.mean().sort_values(ascending=False)
    whole = float(parts.sum())
    if not whole:
        return None
    unit = numbers.times(run.model.units.time, [float(parts.iloc[0])])
    marks = tuple(
        Bar(
            label=of[str(name)].doing,
            mean=float(part),
            text=f"{unit.value(float(part))} · {100 * part / whole:.0f} %",
            standing="part",
        )
        for name, part in parts.items()
        if part >= _LEAST * whole
    )
    many = number_of(len(table), by)
    return rows(Rows(title=f"Where the {unit.value(whole)} of a {by} go, mean of {many}", rows=marks))
