"""The time of robots cut into pieces, each in one state or wait, on one edge or at one node. Needs `log: all`.

For the account of time, chains of waits, and the use of stations and chargers.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple
from weakref import WeakKeyDictionary

from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.records import StateSpan, Wait, Whereabouts
from desim_warehouse.states import APART

_known: WeakKeyDictionary[History, list[list[Piece]]] = WeakKeyDictionary()


class Piece(NamedTuple):
    """An interval of a robot's time that belongs to one `part`, on an `edge` (`A>B`) or at a `node`."""

    robot: int
    start: float
    end: float
    part: str
    edge: str | None
    node: str | None

    @property
    def length(self) -> float:
        """The length of the piece in time."""
        return self.end - self.start


def pieces(history: History) -> list[list[Piece]]:
    """Cut each robot's time into pieces, in order, which fill the run from 0 to its end. The result is cached."""
    if history not in _known:
        _known[history] = list(_cut(history))
    return _known[history]


def _cut(history: History) -> Iterator[list[Piece]]:
    waits: defaultdict[int, list[Wait]] = defaultdict(list)
    for wait in history.waits:
        waits[wait.robot].append(wait)
    for robot, (spans, stays) in enumerate(zip(history.states, history.stays, strict=True)):
        yield list(_pieces(history, spans, stays, sorted(waits[robot], key=lambda wait: wait.start)))


def _pieces(history: History, spans: list[StateSpan], stays: list[Whereabouts], waits: list[Wait]) -> Iterator[Piece]:
    """Cut a robot's time wherever its state or its edge changes, or a wait begins or ends."""
    cuts = {history.begin, *(stay.start for stay in stays)}
    cuts.update(time for span in spans for time in (span.start, span.end))
    cuts.update(time for wait in waits for time in (wait.start, wait.end))
    times = sorted(time for time in cuts if 0 <= time <= history.end)
    in_span = in_stay = in_wait = 0
    for start, end in pairwise(times):
        while spans[in_span].end <= start:
            in_span += 1
        while in_stay + 1 < len(stays) and stays[in_stay + 1].start <= start:
            in_stay += 1
        while in_wait < len(waits) and waits[in_wait].end <= start:
            in_wait += 1
        now, where = spans[in_span], stays[in_stay]
        part, edge, node = now.seen.name, where.edge, where.node
        if in_wait < len(waits) and waits[in_wait].start <= start:
            part, edge, node = _reason(waits[in_wait])
        if edge is None:
            yield Piece(now.robot, start, end, part, None, node)
        else:
            yield Piece(now.robot, start, end, part, ">".join(edge), None)


def _reason(wait: Wait) -> tuple[str, tuple[str, str] | None, str]:
    """Return the cause of a wait in traffic, and the edge or node that the robot waits for."""
    if wait.cause in APART:
        return wait.cause, None, wait.node or ""
    if wait.edge is not None:
        return "behind_robot", wait.edge, ""
    return "before_intersection", None, wait.node or ""
