"""How robots that stand in each other's way all come home: searched for before a run, and at steps during it.

Each robot has a trail of stands that it still has to use, which ends in a slot off the lanes. A *move* takes the first
robot of a stand on along its trail, over stands that are free by then: home, or to a *refuge*. That is a one-way lane
with room, where it stands clear of the nodes and robots come up behind it but never towards it. Moves after which
nobody is out are a plan (see `world.traffic.plan`). The search never takes a move back, so it may miss a plan.
"""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping, Sequence

R = TypeVar("R")
"""A robot."""
S = TypeVar("S")
"""A stand: a node or a lane; or the mark of one direction of a zone, on which those stand that drive the other way."""
T_co = TypeVar("T_co", covariant=True)


class Way(Protocol[T_co]):
    """What a robot has still to use: its trail beyond `at`, where it stands."""

    @property
    def trail(self) -> Sequence[T_co]: ...
    @property
    def at(self) -> int: ...


def room(length: float, headway: float) -> int:
    """How many robots can stand on a lane: D (`headway`) apart, and D clear of its ends."""
    return math.floor(length / headway + 1e-9) - 1


class Stands(Generic[R, S]):
    """Who stands where, and who has still to use what.

    `ways` has every robot with a trail. `users` are robots by what they still have to use, those in slots included.
    `lines` are the robots out by stand, those ahead first. `held` is what a robot stands on: its stand, and after that
    the mark of a zone's direction. `refuges` are the lanes on which robots may make way for others, with their room.
    """

    __slots__ = ("held", "lines", "refuges", "users", "ways")

    def __init__(
        self, ways: Mapping[R, Way[S]], users: Mapping[S, Collection[R]], refuges: Mapping[S, int]
    ) -> None:
        self.ways = ways
        self.users = users
        self.refuges = refuges
        self.lines: dict[S, list[R]] = {}
        self.held: dict[R, tuple[S, ...]] = {}

    def put(self, robot: R, held: tuple[S, ...]) -> None:
        """A robot stands there, as the last."""
        self.held[robot] = held
        for stand in held:
            self.lines.setdefault(stand, []).append(robot)

    def take(self, robot: R) -> list[tuple[S, int]]:
        """A robot stands nowhere any more. Returned is where it stood, for `put_back`."""
        found = []
        for stand in self.held.pop(robot):
            line = self.lines[stand]
            place = line.index(robot)
            del line[place]
            if not line:
                del self.lines[stand]
            found.append((stand, place))
        return found

    def put_back(self, robot: R, places: Iterable[tuple[S, int]]) -> None:
        """A robot stands where it did before, with the same robots ahead of it."""
        self.held[robot] = tuple(stand for stand, _ in places)
        for stand, place in places:
            self.lines.setdefault(stand, []).insert(place, robot)


class Search(Generic[R, S]):
    """A plan for some robots and for all that stand in their way, directly or through others.

    `moves` are robots and positions on their trails, in order, and `left` who is still out after them: nobody, if a
    plan is found. Nobody else is in the way of any of the group, so whatever others do it is a plan for these.

    Who finds the whole way home free goes home. If nobody does, a robot in the way of others drives on to the farthest
    refuge that it can reach, and the search goes on. Every move shortens a trail, so it ends.
    """

    __slots__ = ("at", "blocked", "free", "left", "lines", "moves", "stands", "waiting")

    def __init__(self, stands: Stands[R, S], robots: Iterable[R]) -> None:
        self.stands = stands
        self.moves: list[tuple[R, int]] = []
        self.blocked: dict[R, int] = {}  # how often a robot is in the way of this one
        self.waiting: dict[S, dict[R, None]] = {}  # by stand, who has still to use it
        self.at: dict[R, int] = {}  # of robots that have moved to a refuge
        self.lines: dict[S, list[R]] = {}  # of the stands that are not as they were
        self._gather(robots)
        self.left = dict.fromkeys(self.blocked)
        self.free = deque(robot for robot, number in self.blocked.items() if not number)
        self._go_home()
        while self.left and self._make_way():
            self._go_home()

    def _gather(self, robots: Iterable[R]) -> None:
        """The robots, those in their way, those in the way of these, and so on; and how many block each."""
        lines, ways, held = self.stands.lines, self.stands.ways, self.stands.held
        blocked, waiting = self.blocked, self.waiting
        to_follow = list(robots)
        blocked.update(dict.fromkeys(to_follow, 0))
        while to_follow:
            member = to_follow.pop()
            way = ways[member]
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
            for other in lines[held[member][0]]:
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
            self._leave(robot, self._stand(robot))

    def _leave(self, robot: R, own: S) -> None:
        """A robot drives off from the head of its stand: one robot less in the way of those behind, and of users."""
        blocked, free, left = self.blocked, self.free, self.left
        for stand in (own,) if robot in self.at else self.stands.held[robot]:  # a refuge is in no zone
            line = self._line(stand)
            line.remove(robot)
            for others in (self.waiting.get(stand, ()), line if stand is own else ()):
                for other in others:
                    if other is not robot and other in left:
                        blocked[other] -= 1
                        if not blocked[other]:
                            free.append(other)

    def _make_way(self) -> bool:
        """Let one robot that blocks others drive on to a refuge, and return whether any could."""
        for robot in self.left:
            stand = self._stand(robot)
            line = self._seen(stand)
            if line[0] is robot and (
                len(line) > 1 or any(other in self.left for other in self.waiting.get(stand, ()) if other is not robot)
            ):
                refuge = self._refuge(robot)
                if refuge is not None:
                    self._move(robot, refuge)
                    return True
        return False

    def _refuge(self, robot: R) -> int | None:
        """The farthest refuge that the first robot of a stand can drive to, as a position on its trail."""
        refuges, trail, found = self.stands.refuges, self.stands.ways[robot].trail, None
        for index in range(self._at(robot) + 1, len(trail)):
            line = self._seen(trail[index])
            if len(line) < refuges.get(trail[index], 0):
                found = index
            if line and (len(line) > 1 or line[0] is not robot):
                break
        return found

    def _move(self, robot: R, index: int) -> None:
        """To a refuge, behind those that are there."""
        self.moves.append((robot, index))
        trail = self.stands.ways[robot].trail
        passed, refuge, rest = trail[self._at(robot) + 1 : index + 1], trail[index], trail[index + 1 :]
        # There before it has left: none may come free that it blocks again.
        self._line(refuge).append(robot)
        for other in self._waiting_for(refuge):
            if other is not robot and other in self.left:
                self.blocked[other] += 1
        for step in passed:
            if step in self.waiting and step not in rest:
                self.waiting[step].pop(robot, None)
        self._leave(robot, self._stand(robot))
        self.at[robot] = index
        in_the_way = [other for step in dict.fromkeys(rest) for other in self._seen(step) if other is not robot]
        self.blocked[robot] = len(in_the_way) + len(self._seen(refuge)) - 1

    def _waiting_for(self, refuge: S) -> dict[R, None]:
        """Who has still to use a refuge, also if nobody has stood there up to now."""
        found = self.waiting.get(refuge)
        if found is None:
            ways = self.stands.ways
            found = self.waiting[refuge] = {
                user: None
                for user in self.stands.users.get(refuge, ())
                if user in self.left and refuge in ways[user].trail[self._at(user) + 1 :]
            }
        return found

    # Where they are by now

    def _at(self, robot: R) -> int:
        at = self.at.get(robot)
        return self.stands.ways[robot].at if at is None else at

    def _stand(self, robot: R) -> S:
        at = self.at.get(robot)
        return self.stands.held[robot][0] if at is None else self.stands.ways[robot].trail[at]

    def _seen(self, stand: S) -> Sequence[R]:
        line = self.lines.get(stand)
        return self.stands.lines.get(stand, ()) if line is None else line

    def _line(self, stand: S) -> list[R]:
        """The robots on a stand, those ahead first, for a change."""
        line = self.lines.get(stand)
        if line is None:
            line = self.lines[stand] = list(self.stands.lines.get(stand, ()))
        return line
