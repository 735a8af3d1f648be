"""Chains of waiting robots, followed to their root, which is the reason why they all wait.

For `Run.waits`, the page and answer of a run, its replay, and `desim why`.

A robot that waits in traffic waits for another, which may itself wait for a third. The chain ends at its root: a robot
at work, a queue for a server or charger, a closure, a person, a two-way lane that is taken, or the crossing itself.
Chains change while robots wait, so waits are cut whenever a robot of the chain changes its activity. Needs `log: all`.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator
from itertools import islice
from operator import attrgetter
from typing import NamedTuple
from weakref import WeakKeyDictionary

from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.pieces import Piece, pieces
from desim_warehouse.outcome.records import Wait
from desim_warehouse.states import APART, PICKER, SHOWN, TOO_LOW, Phase, names

TRAFFIC = ("behind_robot", "before_intersection")
"""Parts of the account in which a robot waits for another robot."""
CROSSING, LANE, TWO_WAY, RING = "crossing", "lane", "two_way_lane", "ring"
"""Roots other than states: robots cross, drive ahead, come the other way, or all wait for each other."""
QUEUES = frozenset(name for name, state in SHOWN.items() if state.queue is not None)
ANYWHERE = TOO_LOW | names(lambda state: state.queue == PICKER)
"""Queues for any free charger or picker, which have no place of their own."""
_MOVING = frozenset({Phase.TO_GOOD, Phase.TO_STATION, Phase.TO_BAY, Phase.REST})

_known: WeakKeyDictionary[History, list[Lost]] = WeakKeyDictionary()


class Root(NamedTuple):
    """The end of a chain of waits, and its place.

    `cause`: a state of a robot, a closure, a person, or a root listed above. `at`: a node, an edge (`A>B`) or a two-way
    lane (`A-B`); "" for queues for any charger or picker.
    """

    cause: str
    at: str


class Lost(NamedTuple):
    """Time that a robot waited, in traffic or in a queue, for one root."""

    robot: int
    start: float
    end: float
    root: Root


def lost(history: History) -> list[Lost]:
    """Cut all waiting times of the run, robot by robot, into parts with one root each. The result is cached."""
    if history not in _known:
        chains = Chains(history)
        pieces_of_waiting = (piece for robot in chains.fleet for piece in robot if _waits(piece))
        _known[history] = [part for piece in pieces_of_waiting for part in chains.follow(piece)]
    return _known[history]


def roots(history: History) -> list[Root]:
    """Return the root that each wait in traffic had for longest, in the order of `History.waits`."""
    chains = Chains(history)
    spent: defaultdict[tuple[int, float], defaultdict[Root, float]] = defaultdict(lambda: defaultdict(float))
    for robot in chains.fleet:
        for piece in robot:
            if piece.part in TRAFFIC or piece.part in APART:
                of_wait = spent[piece.robot, chains.wait(piece.robot, piece.start).start]
                for part in chains.follow(piece):
                    of_wait[part.root] += part.end - part.start
    roots_of_waits = (spent.get((wait.robot, wait.start)) for wait in history.waits)
    longest = (max(of_wait, key=of_wait.__getitem__) if of_wait else None for of_wait in roots_of_waits)
    return [root or _place(wait) for root, wait in zip(longest, history.waits, strict=True)]


def lost_to(history: History, until: float = math.inf) -> dict[Root, tuple[float, int]]:
    """Return the total waiting time and the number of waiting robots for each root, the longest time first.

    Only waiting before `until` counts.
    """
    spent: defaultdict[Root, list[float]] = defaultdict(list)
    robots: defaultdict[Root, set[int]] = defaultdict(set)
    for part in lost(history):
        if history.counts(part.start) and part.start < until:
            spent[part.root].append(min(part.end, until) - part.start)
            robots[part.root].add(part.robot)
    totals = {root: (math.fsum(times), len(robots[root])) for root, times in spent.items()}
    return dict(sorted(totals.items(), key=lambda item: -item[1][0]))


def _waits(piece: Piece) -> bool:
    return piece.part in TRAFFIC or piece.part in APART or piece.part in QUEUES


def _place(wait: Wait) -> Root:
    """Return the root of a wait whose chain ends here: the closure or person, or the traffic at its place."""
    if wait.cause in APART:
        return Root(wait.cause, ">".join(wait.into) if wait.into else wait.node or "")
    return Root(LANE, ">".join(wait.edge)) if wait.edge is not None else Root(CROSSING, wait.node or "")


class Chains:
    """The pieces and waits of all robots, by which chains of waits are followed."""

    def __init__(self, history: History) -> None:
        self.fleet = pieces(history)
        self.ends = [[piece.end for piece in robot] for robot in self.fleet]
        self.waits: list[list[Wait]] = [[] for _ in self.fleet]
        for wait in sorted(history.waits, key=attrgetter("start")):
            self.waits[wait.robot].append(wait)
        self.over = [[wait.end for wait in robot] for robot in self.waits]
        edges = history.layout.graph.edges
        self.ahead = {f"{a}>{b}": b for a, b in edges}
        self.picked = {">".join(place.edge) for place in history.layout.storage}
        self.two_way = {f"{a}>{b}": "-".join(sorted((a, b))) for a, b, both in edges(data="two_way") if both}
        self.shared = {node for lane in history.layout.two_way for node in lane}

    def wait(self, robot: int, time: float) -> Wait:
        """Return the wait of a robot at a time at which it waits in traffic."""
        return self.waits[robot][bisect_right(self.over[robot], time)]

    def follow(self, piece: Piece) -> Iterator[Lost]:
        """Cut a piece of waiting into parts, each with the root of its chain at that time; in no particular order."""
        todo: list[tuple[Piece, float, float, tuple[int, ...]]] = [(piece, piece.start, piece.end, ())]
        while todo:
            link, start, end, before = todo.pop()
            wait = None if link.part in QUEUES else self.wait(link.robot, start)
            chain = (*before, link.robot)
            if wait is None:
                place = "" if link.part in ANYWHERE else link.node or ""
                yield Lost(piece.robot, start, end, Root(link.part, place))
            elif wait.other < 0:
                yield Lost(piece.robot, start, end, self._nobody(wait))
            elif wait.other in chain:
                yield Lost(piece.robot, start, end, Root(RING, _place(wait).at))
            else:
                for part in self._between(wait.other, start, end):
                    since, until = max(start, part.start), min(end, part.end)
                    if _waits(part):
                        todo.append((part, since, until, chain))
                    else:
                        yield Lost(piece.robot, since, until, self._at_work(part, wait))

    def _between(self, robot: int, start: float, end: float) -> Iterator[Piece]:
        """Iterate over the pieces of a robot between two times."""
        for piece in islice(self.fleet[robot], bisect_right(self.ends[robot], start), None):
            if piece.start >= end:
                return
            yield piece

    def _nobody(self, wait: Wait) -> Root:
        """Return the root of a wait for no robot: a closure, a person, a lane that would be blocked, or a turn."""
        root = _place(wait)
        return Root(TWO_WAY, root.at) if root.cause == CROSSING and root.at in self.shared else root

    def _at_work(self, doing: Piece, wait: Wait) -> Root:
        """Return the root if the last robot of a chain does not wait: its work or, if it drives, the wait's place."""
        if SHOWN[doing.part].phase not in _MOVING:
            edge = doing.edge or ""
            beside = SHOWN[doing.part].phase is Phase.LOADING and edge in self.picked
            return Root(doing.part, doing.node or (edge if beside else self.ahead[edge]))
        if doing.edge in self.two_way:
            return Root(TWO_WAY, self.two_way[doing.edge])
        return _place(wait)
