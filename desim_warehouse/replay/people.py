"""Pickers on the replay page (`desim replay`): their walks, their work for robots, and the busiest picker."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from desim_warehouse.answer import numbers
from desim_warehouse.errors import number_of
from desim_warehouse.layout.walking import Spot, at_start, walking_on, zones_of
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.records import PickerSpan
from desim_warehouse.replay.scale import MapScale
from desim_warehouse.values.arrays import Ints


def picker_columns(history: History, scale: MapScale) -> dict[str, Any]:
    """Return the columns of pickers; empty without pickers.

    A spot is the number of an edge (or -1 - n for node n), and the distance from the start of the edge in grains.

    `picker_edge`, `picker_at`: the initial spot of each picker. `act_count`: the number of each picker's acts (walks
    and picks) in the window. For each act, in order: `act_time`, `act_length`, `act_robot`, and `act_nodes`, the number
    of nodes (`act_node`) on a walk, or -1 for a pick. `act_edge`, `act_at`: the end of each walk.
    """
    spec, layout = history.model.pickers, history.layout
    if spec is None:
        return {}
    number = {edge: i for i, edge in enumerate(layout.graph.edges)}
    node = {name: i for i, name in enumerate(layout.graph)}
    number |= {(name, name): -1 - i for name, i in node.items()}
    walking = walking_on(layout)
    begins, acts, ways = [], [], []
    for picker, (_, spot) in enumerate(at_start(spec.count, zones_of(layout, spec.zones))):
        mine = [span for span in history.pickers_work if span.picker == picker]
        before = [span for span in mine if span.end < scale.start]
        now = (before[-1].edge, before[-1].offset) if before else spot
        begins.append(now)
        shown = [span for span in mine[len(before) :] if span.start <= scale.end]
        acts.append(shown)
        for span in shown:
            ways.append(None if span.picks else walking.nodes(now, (span.edge, span.offset)))
            now = span.edge, span.offset
    spans = [span for shown in acts for span in shown]
    walks = [(span.edge, span.offset) for span in spans if not span.picks]
    begin = scale.times([span.start for span in spans])
    return {
        **_spots("picker", begins, number, scale),
        "act_count": [len(shown) for shown in acts],
        "act_time": np.diff(begin, prepend=0),
        "act_length": scale.times([span.end for span in spans]) - begin,
        "act_robot": [span.robot for span in spans],
        "act_nodes": [-1 if way is None else len(way) for way in ways],
        "act_node": [node[name] for way in ways for name in way or ()],
        **_spots("act", walks, number, scale),
    }


def _spots(
    name: str, spots: Sequence[Spot], number: dict[tuple[str, str], int], scale: MapScale
) -> dict[str, list[int] | Ints]:
    return {
        f"{name}_edge": [number[edge] for edge, _ in spots],
        f"{name}_at": scale.lengths([offset for _, offset in spots]),
    }


def busiest_picker(history: History, scale: MapScale) -> dict[str, Any] | None:
    """Return the stop at the longest walk of the busiest picker in the window; None if no picker worked."""
    begin, end = max(history.begin, scale.start), min(history.end, scale.end)
    if history.model.pickers is None or begin >= end:
        return None
    by_picker: dict[int, list[PickerSpan]] = {}
    for span in history.pickers_work:
        if span.end > begin and span.start < end:
            by_picker.setdefault(span.picker, []).append(span)
    if not by_picker:
        return None

    def spent(spans: Iterable[PickerSpan]) -> float:
        return sum(min(span.end, end) - max(span.start, begin) for span in spans)

    picker, spans = max(by_picker.items(), key=lambda item: (spent(item[1]), -item[0]))
    picks, walks = [span for span in spans if span.picks], [span for span in spans if not span.picks]
    hours = history.model.hours(history.model.pickers.hours)
    whole = (hours.open_time(end) - hours.open_time(begin)) or end - begin
    picking, walking = (numbers.PERCENT.value(spent(some) / whole) for some in (picks, walks))
    lines = number_of(len(picks), "line")
    text = f"The busiest picker: {picker}, {lines}, {picking} of the time picking, {walking} walking."
    longest = max(walks or picks, key=lambda span: min(span.end, end) - max(span.start, begin))
    time = (max(longest.start, begin) + min(longest.end, end)) / 2
    return {"said": text, "time": time, "robots": [history.model.fleet.size + picker]}
