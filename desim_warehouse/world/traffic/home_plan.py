"""The plan by which all robots that are out come home, kept while they drive (proof: `avoidance`).

Robots declare the trail that they will use, so for each node and lane it is known which robots have still to use it. A
plan is a list of moves (`layout.way_home`), ordered by rank. A step is safe if there is a plan for the state after it.
Three methods find one, the cheapest first:

- *Put first*: the step, followed by the plan as it was. Until the robot's move beyond its new stand only its own place
  differs, so only robots that use the new stand before that move matter.
- *Goes on earlier*: the robot leaves the new stand just before the first that would meet it there.
- *Search*, for the robot and for all that stand in its way, directly or through others. As no other robot is in the way
  of any of these, their plan followed by the old plan of all others is a plan.

Steps that these miss are refused needlessly, without harm: the step of the plan's first move is always safe.
"""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import TypeAlias

from desim_warehouse.layout.way_home import HomeSearch, Stands
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.intersection import Intersection
from desim_warehouse.world.traffic.lane import Lane
from desim_warehouse.world.traffic.zones import Exit, ZoneDirection

Stand: TypeAlias = Intersection | Lane
Step: TypeAlias = Stand | ZoneDirection | Exit
Move: TypeAlias = tuple[float, int]
"""A move: its rank, and how far it goes on the robot's trail, to a refuge or home (the length of the trail)."""


class DeclaredRoute:
    """The trail that a robot has yet to use, in order, and its present stand on it: -1 while it is in a bay.

    A trail has a mark before the first lane of a one-direction zone, and another after the node at its end there.
    `direction` is the one in which the robot drives a zone now.
    """

    __slots__ = ("at", "direction", "stands", "trail")

    def __init__(self, trail: list[Step]) -> None:
        self.trail = trail
        self.at = -1
        self.stands: Stand | None = None
        self.direction: ZoneDirection | None = None


class Declared:
    """The declared routes of all robots.

    `users` counts, for each step of a trail, how often each robot has still to use it; robots in slots included.
    """

    __slots__ = ("routes", "users")

    def __init__(self) -> None:
        self.routes: dict[Body, DeclaredRoute] = {}
        self.users: dict[Step, dict[Body, int]] = defaultdict(dict)

    def add(self, robot: Body, route: DeclaredRoute) -> None:
        """Note a route that a robot has declared, or its replacement before the robot has set out."""
        if robot in self.routes:
            self.drop(robot)
        self.routes[robot] = route
        self.count(robot, route.trail[route.at + 1 :], 1)

    def replace(self, robot: Body, rest: list[Step]) -> list[Step]:
        """Give a robot that is out other steps to use, and return the steps that it had."""
        route = self.routes[robot]
        old = route.trail[route.at + 1 :]
        self.count(robot, old, -1)
        self.count(robot, rest, 1)
        route.trail[route.at + 1 :] = rest
        return old

    def drop(self, robot: Body) -> None:
        """Drop the route of a robot that is in a bay or station."""
        route = self.routes.pop(robot)
        self.count(robot, route.trail[route.at + 1 :], -1)

    def count(self, robot: Body, steps: Iterable[Step], change: int) -> None:
        """Count steps that a robot has still to use (1) or no longer has to (-1)."""
        for step in steps:
            users = self.users[step]
            number = users.get(robot, 0) + change
            if number:
                users[robot] = number
            else:
                del users[robot]


def trail_of(node: Intersection, route: Iterable[Lane], direction: ZoneDirection | None = None) -> list[Step]:
    """Return the nodes and lanes on which a robot can stand along a route from a node, in order, without short lanes.

    `direction`: of a zone in which the robot comes to the node, or stands on it.
    """
    trail: list[Step] = [node]
    for lane in route:
        if lane.inside:
            continue
        if lane.zone_direction is not direction:
            if direction is not None:
                trail.append(direction.exit)
            direction = lane.zone_direction
            if direction is not None:
                trail.append(direction)
        if not lane.short:
            trail.append(lane.lane_of_both)
        trail.append(lane.end)
    return trail


class HomePlan:
    """The safety test (banker's algorithm) where robots can make way on one-way lanes: a plan brings all home.

    It implements `Test` for the guard.

    `moves` are those of every robot that is out, each ending at home. A robot under way stands where it drives to.
    """

    __slots__ = ("_at_refuges", "_by_rank", "_ranks", "declared", "moves", "stands")

    def __init__(self, declared: Declared, refuges: Mapping[Step, int]) -> None:
        self.declared = declared
        self.stands: Stands[Body, Step] = Stands(declared.routes, declared.users, refuges)
        self.moves: dict[Body, list[Move]] = {}
        self._by_rank: dict[float, Body] = {}
        self._ranks: list[float] = []  # sorted; some belong to moves that were made or given up
        self._at_refuges: dict[Body, None] = {}  # robots with a move to a refuge, now or before

    # What happens on the lanes

    def starts(self, robot: Body) -> None:
        """Accept a robot on the lanes at the start of a run: `check` has verified that all there can come home."""
        self.stands.put(robot, _held(self.declared.routes[robot]))
        self._search([*self.stands.held])

    def left(self, robot: Body) -> None:
        """Drop the moves of a robot that is off the lanes."""
        if robot in self.stands.held:
            self.stands.take(robot)
            self._drop(robot)

    def first(self) -> Body | None:
        """Return the robot of the first move: no robot has to move before it, so its claim must always be heard."""
        ranks, by_rank = self._ranks, self._by_rank
        while ranks and ranks[0] not in by_rank:
            del ranks[0]
        return by_rank[ranks[0]] if ranks else None

    def after_step(self, robot: Body) -> Collection[Body] | None:
        """Return the robots for which no plan was found after a step of a robot; None if there is a plan."""
        route = self.declared.routes[robot]
        before = self.stands.take(robot) if robot in self.stands.held else None
        self.stands.put(robot, _held(route))
        if (before is not None and self._put_first(robot, route)) or self._goes_on_earlier(robot, route):
            return None
        blockers = self._search([robot])
        if blockers is not None:
            self.stands.take(robot)
            if before is not None:
                self.stands.put_back(robot, before)
        return blockers

    def after_change(self, robot: Body) -> Collection[Body] | None:
        """Replan a robot that changed its route, as its old moves no longer apply; see `after_step`."""
        return self._search([robot])

    # Put first

    def _put_first(self, robot: Body, route: DeclaredRoute) -> bool:
        """Whether the plan still holds with the step, just taken, put before it."""
        moves, target = self.moves[robot], route.at
        done = 0
        while moves[done][1] < target:
            done += 1
        leaves = moves[done][0]  # from then on the robot is where the plan has it
        for stand in self.stands.held[robot]:
            if self._is_used(stand, robot, leaves):
                return False
        if moves[done][1] == target:
            done += 1
        if done:
            for rank, _ in moves[:done]:
                del self._by_rank[rank]
            del moves[:done]
        return True

    def _is_used(self, stand: Step, robot: Body, before: float) -> bool:
        """Whether another robot stops at a stand or passes it before a given move of the plan."""
        for other in self.declared.users.get(stand, ()):
            moves = self.moves.get(other)
            if moves is not None and moves[0][0] < before and other is not robot:
                route = self.declared.routes[other]
                index = route.trail.index(stand, route.at + 1)
                for rank, upto in moves:
                    if upto >= index:
                        if rank < before:
                            return True
                        break
        return False

    # Goes on earlier

    def _goes_on_earlier(self, robot: Body, route: DeclaredRoute) -> bool:
        """Whether the plan holds if the robot leaves its new stand before the first that would meet it there.

        It then drives home, or to a refuge where no robot comes before it leaves again by the plan. A robot that was in
        a slot has a single move: home, after all others.
        """
        end = len(route.trail)
        later = [move for move in self.moves.get(robot, ()) if move[1] > route.at] or [(self._after_all(), end)]
        held = self.stands.held[robot]
        until = min((rank for stand in held for rank in self._uses(stand, robot)), default=math.inf)
        if until == math.inf:
            self._set(robot, later)
            return True
        for other in self.stands.lines[held[0]]:
            if other is robot:
                break
            if self.moves[other][0][0] >= until:
                return False
        rank = self._just_before(until)
        if rank is None:
            return False
        moves = self._from_then(robot, route, later, until, rank)
        if moves is None:
            return False
        self._set(robot, moves)
        return True

    def _from_then(
        self, robot: Body, route: DeclaredRoute, later: list[Move], when: float, rank: float
    ) -> list[Move] | None:
        """Return the moves of a robot that drives on just before a move of the plan, as far as its way is free then."""
        trail, refuges = route.trail, self.stands.refuges
        taken = self._refuges_taken(robot, when)
        refuges_ahead = []
        for index in range(route.at + 1, len(trail)):
            step = trail[index]
            if step in taken or self._is_there(step, robot, when):
                break
            if step in refuges:
                refuges_ahead.append(index)
        else:
            return [(rank, len(trail))]
        for index in reversed(refuges_ahead):
            rest = [move for move in later if move[1] > index]
            leaves = rest[0][0]
            if not any(when <= used < leaves for used in self._uses(trail[index], robot)):
                return [(rank, index), *rest]
        return None

    def _uses(self, stand: Step, robot: Body) -> Iterator[float]:
        """Iterate over the ranks of moves by which other robots come to a stand or pass it."""
        for other in self.declared.users.get(stand, ()):
            moves = self.moves.get(other)
            if moves is not None and other is not robot:
                route = self.declared.routes[other]
                place = route.at
                for rank, upto in moves:
                    if stand in route.trail[place + 1 : upto + 1]:
                        yield rank
                    place = upto

    def _is_there(self, step: Step, robot: Body, when: float) -> bool:
        """Whether another robot stands on a stand now and has not left it before a given move of the plan."""
        line = self.stands.lines.get(step, ())
        return any(other is not robot and self.moves[other][0][0] >= when for other in line)

    def _refuges_taken(self, robot: Body, when: float) -> set[Step]:
        """Return the refuges to which other robots have made way just before some move of the plan."""
        taken = set()
        for other in list(self._at_refuges):
            moves = self.moves.get(other, ())
            if len(moves) <= 1:
                del self._at_refuges[other]
            elif other is not robot and moves[0][0] < when:
                last = max(upto for rank, upto in moves if rank < when)
                trail = self.declared.routes[other].trail
                if last < len(trail):
                    taken.add(trail[last])
        return taken

    # Search

    def _search(self, robots: list[Body]) -> Collection[Body] | None:
        """Adopt a new plan for robots and all in their way; or return the robots for which none was found."""
        search = HomeSearch(self.stands, robots)
        if search.left:
            return search.left
        moves: dict[Body, list[Move]] = {}
        first = (self._ranks[0] if self._ranks else 0.0) - len(search.moves)
        for number, (robot, upto) in enumerate(search.moves):
            moves.setdefault(robot, []).append((first + number, upto))
        for robot, own in moves.items():
            self._drop(robot)
            self.moves[robot] = own
            if len(own) > 1:
                self._at_refuges[robot] = None
        self._ranks[:0] = [first + number for number in range(len(search.moves))]
        self._by_rank.update((first + number, robot) for number, (robot, _) in enumerate(search.moves))
        self._forget_old_ranks()
        return None

    # Ranks

    def _set(self, robot: Body, moves: list[Move]) -> None:
        """Replace the moves of a robot in the plan."""
        self._drop(robot)
        self.moves[robot] = moves
        for rank, _ in moves:
            self._by_rank[rank] = robot
            insort(self._ranks, rank)
        if len(moves) > 1:
            self._at_refuges[robot] = None
        self._forget_old_ranks()

    def _drop(self, robot: Body) -> None:
        for rank, _ in self.moves.pop(robot, ()):
            del self._by_rank[rank]

    def _after_all(self) -> float:
        return self._ranks[-1] + 1 if self._ranks else 0.0

    def _just_before(self, rank: float) -> float | None:
        """Return a rank just below a given one and above all lower ones; None if floats are too coarse for another."""
        index = bisect_left(self._ranks, rank)
        if not index:
            return rank - 1
        below = self._ranks[index - 1]
        between = (below + rank) / 2
        return between if below < between < rank else None

    def _forget_old_ranks(self) -> None:
        if len(self._ranks) > 4 * len(self._by_rank) + 16:
            self._ranks = sorted(self._by_rank)


def _held(route: DeclaredRoute) -> tuple[Step, ...]:
    """Return the stand that a robot occupies, and the mark of the direction that it keeps others from in a zone."""
    assert route.stands is not None
    return (route.stands,) if route.direction is None else (route.stands, route.direction.opposite)
