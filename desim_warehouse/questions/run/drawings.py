"""Drawings of a run inside its page: the floor, coloured by how long robots wait there, and where the time goes."""

from __future__ import annotations

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
from desim_warehouse.outcome.zones import Zone, zones
from desim_warehouse.plot.floor import ends, step_of
from desim_warehouse.plot.heat import edge_values, node_values, step_words
from desim_warehouse.run import RunData

_MARGIN = 0.03
"""Room around the floor, as a part of its width."""
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
    return html.figure("floor", box, sorted(lanes.items()), nodes, goods, 2 * side, slots, names, step_words(), room)


def _step(run: RunData, waited: float) -> int:
    """The step of the scale of a time waited: 0 where nobody waits."""
    return 1 + bisect_right(WAITED_STEPS, waited / (run.history.counted or 1.0)) if waited else 0


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
