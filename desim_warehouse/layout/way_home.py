"""Search for plans by which robots that stand in each other's way all come home, before a run and during it.

Each robot has a trail of stands that it still has to use, which ends in a slot off the lanes. A *move* takes the first
robot of a stand along its trail, over stands that are free by then, either home or to a *refuge*. A refuge is a one-way
lane with room: a robot on it is clear of the nodes, and others come up behind it but never towards it. A plan is a list
of moves after which no robot is out (`world.traffic.home_plan`). The search never takes a move back, so it may miss a
plan.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Generic, Protocol, TypeVar

R = TypeVar("R")
"""A robot."""
S = TypeVar("S")
"""A stand: a node, a lane, or the mark of one direction of a zone, held by the robots that drive in this direction."""
T_co = TypeVar("T_co", covariant=True)


class Way(Protocol[T_co]):
    """The trail of a robot, and its position `at` on the trail; the robot still has to use the stands beyond."""

    @property
    def trail(self) -> Sequence[T_co]:
        """The stands in order; the robot may have passed some already."""

    @property
    def at(self) -> int:
        """The position on the trail where the robot stands."""


def room(length: float, headway: float) -> int:
    """Return the number of robots that can stand on a lane: D (`headway`) apart, and D clear of its ends."""
    return math.floor(length / headway + 1e-9) - 1


class Stands(Generic[R, S]):
    """The positions of robots in order, and the robots that have still to use each stand.

    `ways`: every robot's trail. `users`: by stand, the robots that still have to use it, including those in slots.
    `lines`: by stand, the robots that are out, those ahead first. `held`: for each robot its stand, then the mark of a
    zone's direction. `refuges`: the lanes on which robots may make way for others, with their room.
    """

    __slots__ = ("held", "lines", "refuges", "users", "ways")

    def __init__(self, ways: Mapping[R, Way[S]], users: Mapping[S, Collection[R]], refuges: Mapping[S, int]) -> None:
        self.ways = ways
        self.users = users
        self.refuges = refuges
        self.lines: dict[S, list[R]] = {}
        self.held: dict[R, tuple[S, ...]] = {}

    def put(self, robot: R, held: tuple[S, ...]) -> None:
        """Put a robot last on each of the stands that it holds."""
        self.held[robot] = held
        for stand in held:
            self.lines.setdefault(stand, []).append(robot)

    def take(self, robot: R) -> list[tuple[S, int]]:
        """Remove a robot from its stands, and return them with its position in each, for `put_back`."""
        places = []
        for stand in self.held.pop(robot):
            line = self.lines[stand]
            place = line.index(robot)
            del line[place]
            if not line:
                del self.lines[stand]
            places.append((stand, place))
        return places

    def put_back(self, robot: R, places: Iterable[tuple[S, int]]) -> None:
        """Put a robot back to its former positions, with the same robots ahead of it."""
        self.held[robot] = tuple(stand for stand, _ in places)
        for stand, place in places:
            self.lines.setdefault(stand, []).insert(place, robot)


class HomeSearch(Generic[R, S]):
    """A plan for a group of robots and for all robots that stand in their way, directly or through others.

    `moves`: robots and positions on their trails, in order. `left`: the robots still out after the moves; empty if a
    plan was found. No other robot is in the way of the group, so the plan holds whatever other robots do.

    A robot whose whole way home is free goes home. If there is none, a robot in the way of others drives on to the
    farthest refuge that it can reach, and the search goes on. Every move shortens a trail, so the search ends.
    """

    __slots__ = ("at", "blocked", "free", "left", "lines", "moves", "own", "stands", "to_try", "waiting")

    def __init__(self, stands: Stands[R, S], robots: Iterable[R]) -> None:
        self.stands = stands
        self.moves: list[tuple[R, int]] = []
        self.lines = {stand: line.copy() for stand, line in stands.lines.items()}
        self.at: dict[R, int] = {}
        self.own: dict[R, S] = {}  # the stand of a robot
        self.blocked: dict[R, int] = {}  # how often others are in the way of a robot
        self.waiting: dict[S, dict[R, None]] = {}  # robots that have still to use a stand, by stand
        self._gather(robots)
        # Robots with the shortest way left come first: likely to be home first, they keep the plan valid for longer.
        ways, positions = stands.ways, self.at
        order = sorted(self.blocked, key=lambda robot: len(ways[robot].trail) - positions[robot])
        self.left = dict.fromkeys(order)
        self.free = deque(robot for robot in order if not self.blocked[robot])
        self.to_try = deque(order)
        self._go_home()
        while self.left and self._make_way():
            self._go_home()

    def _gather(self, robots: Iterable[R]) -> None:
        """Collect the robots, those in their way, those in the way of these, and so on; count how many block each."""
        lines, ways, held = self.lines, self.stands.ways, self.stands.held
        blocked, waiting = self.blocked, self.waiting
        to_follow = list(robots)
        blocked.update(dict.fromkeys(to_follow, 0))
        while to_follow:
            member = to_follow.pop()
            way, own = ways[member], held[member][0]
            self.at[member], self.own[member] = way.at, own
            number = 0
            for step in dict.fromkeys([step for step in way.trail[way.at + 1 :] if step in lines]):
                if step in waiting:
                    waiting[step][member] = None
                else:
                    waiting[step] = {member: None}
                for other in lines[step]:
                    if other is not member:
                        number += 1
                        if other not in blocked:
                            blocked[other] = 0
                            to_follow.append(other)
            for other in lines[own]:
                if other is member:
                    break
                number += 1
                if other not in blocked:
                    blocked[other] = 0
                    to_follow.append(other)
            blocked[member] = number

    # Moves

    def _go_home(self) -> None:
        free, ways = self.free, self.stands.ways
        while free:
            robot = free.popleft()
            del self.left[robot]
            self.moves.append((robot, len(ways[robot].trail)))
            self._leave(robot)

    def _leave(self, robot: R) -> None:
        """Take a robot from the head of its stands: it no longer blocks robots behind it and users of the stands."""
        blocked, free, left, own = self.blocked, self.free, self.left, self.own[robot]
        held = self.stands.held[robot]
        for stand in held if held[0] is own else (own,):  # a refuge is in no zone
            line = self.lines[stand]
            line.remove(robot)
            for others in (self.waiting.get(stand, ()), line if stand is own else ()):
                for other in others:
                    if other is not robot and other in left:
                        blocked[other] -= 1
                        if not blocked[other]:
                            free.append(other)

    def _make_way(self) -> bool:
        """Move one robot that blocks others on to a refuge, and return whether any could move. Robots take turns."""
        for _ in range(len(self.to_try)):
            robot = self.to_try.popleft()
            if robot not in self.left:
                continue
            self.to_try.append(robot)
            if self.lines[self.own[robot]][0] is robot and self._blocks_others(robot):
                refuge = self._refuge(robot)
                if refuge is not None:
                    self._move(robot, refuge)
                    return True
        return False

    def _blocks_others(self, robot: R) -> bool:
        own = self.own[robot]
        if len(self.lines[own]) > 1:
            return True
        return any(other is not robot and other in self.left for other in self.waiting.get(own, ()))

    def _refuge(self, robot: R) -> int | None:
        """Return the farthest refuge that the first robot of a stand can reach, as a position on its trail."""
        lines, refuges, trail, refuge = self.lines, self.stands.refuges, self.stands.ways[robot].trail, None
        for index in range(self.at[robot] + 1, len(trail)):
            step = trail[index]
            line = lines.get(step, ())
            if step in refuges and len(line) < refuges[step]:
                refuge = index
            if line and (len(line) > 1 or line[0] is not robot):
                break
        return refuge

    def _move(self, robot: R, index: int) -> None:
        """Move a robot to a refuge, behind the robots there; as many robots as before are in its way."""
        self.moves.append((robot, index))
        trail = self.stands.ways[robot].trail
        passed, refuge = trail[self.at[robot] + 1 : index + 1], trail[index]
        # Added to its new stand before it leaves the old one, lest a robot come free that it blocks again.
        line = self.lines.setdefault(refuge, [])
        waiting = self._waiting_for(refuge)
        for other in waiting:
            if other is not robot and other in self.left:
                self.blocked[other] += 1
        if refuge in trail[index + 1 :]:  # the robot uses the refuge again later: robots ahead are in its way twice
            self.blocked[robot] += sum(other is not robot for other in line)
        line.append(robot)
        for step in passed:
            if step in self.waiting and robot in self.waiting[step] and step not in trail[index + 1 :]:
                del self.waiting[step][robot]
        self._leave(robot)
        self.at[robot], self.own[robot] = index, refuge

    def _waiting_for(self, refuge: S) -> dict[R, None]:
        """Return the robots that still have to use a refuge, even if no robot has stood there so far."""
        users = self.waiting.get(refuge)
        if users is None:
            users = self.waiting[refuge] = {}
            for user in self.stands.users.get(refuge, ()):
                if user in self.left:
                    way, index = self.stands.ways[user], self.at[user]
                    if index == way.at or refuge in way.trail[index + 1 :]:
                        users[user] = None
        return users
