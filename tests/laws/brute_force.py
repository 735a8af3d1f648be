"""Exhaustive search over the states of a small fleet on two-way lanes for moves that bring all robots home.

It shares nothing with the rule but the declared routes of robots and their positions.
"""

import itertools
import math

import networkx as nx

from desim_warehouse.world.traffic.avoidance import Avoidance
from desim_warehouse.world.traffic.home_plan import HomePlan
from desim_warehouse.world.traffic.lane import Lane
from desim_warehouse.world.traffic.zones import ZoneDirection


class Watched(Avoidance):
    """The rule, which records its answers, with the states to which the requested steps would lead.

    Robots are out on the rest of their routes, which end in slots off the lanes. A state lists the robots at each stand
    (a node or a lane), the robot ahead first, each with the rest of its route, its stand included.
    """

    unsafe: list
    safe: list

    def watch(self, most):
        self.most, self.unsafe, self.safe, self.compared = most, [], [], 0
        self.granted, self.number = {}, itertools.count()
        return self

    @property
    def out(self):
        """The routes of the robots that are out."""
        return {robot: route for robot, route in self.declared.routes.items() if route.stands is not None}

    def admit(self, robot, node, onward):
        stand = node if onward is None else onward.lane_of_both
        asked = robot not in self._witness  # else the rule repeats an earlier answer
        before = self.state_after(robot, stand)
        last, self.granted[robot] = self.granted.get(robot), next(self.number)
        answer = super().admit(robot, node, onward)
        if not answer:
            self.granted[robot] = last
            self.compare()
        if asked and sum(map(len, before.values())) <= self.most:
            (self.safe if answer else self.unsafe).append(before)
        return answer

    def _moved(self, robot):
        """Compare after every grant, departure and change of a route."""
        super()._moved(robot)
        self.compare()

    def compare(self):
        """Check the current assumption of the guard: its plan, or a relation without a cycle."""
        self.compared += 1
        if isinstance(self.test, HomePlan):
            self.carry_out_plan()
        else:
            assert not self.has_cycle()

    def carry_out_plan(self):
        """Carry out the plan move by move from the current positions, and check each move."""
        routes, lines = self.out, self.lines()
        at = {robot: route.at for robot, route in routes.items()}
        moves = sorted((rank, robot.number, upto, robot) for robot in at for rank, upto in self.test.moves[robot])
        for _, _, upto, robot in moves:
            trail = routes[robot].trail
            line = lines[trail[at[robot]]]
            assert line[0] is robot, "not the first of its lane"
            del line[0]
            for step in trail[at[robot] + 1 : upto]:
                assert not lines.get(step), "drives over others"
                if isinstance(step, ZoneDirection):
                    assert all(routes[other].direction is not step.opposite for other in at if other is not robot)
            if upto == len(trail):
                del at[robot]
                continue
            onto, line = trail[upto], lines.setdefault(trail[upto], [])
            assert isinstance(onto, Lane), "stops at a node"
            assert onto.twin is None, "stops where others come towards it"
            assert len(line) < math.floor(onto.length / onto.headway + 1e-9) - 1, "no room"
            line.append(robot)
            at[robot] = upto
        assert not at, "some are left on the lanes"

    def has_cycle(self):
        """Whether the relation has a cycle: j stands on the rest of i's route, or ahead of i on its lane."""
        relation = nx.DiGraph()
        lines, out = self.lines(), self.out
        for i, route in out.items():
            ahead = lines[route.stands][: lines[route.stands].index(i)]
            for j, other in out.items():
                if j is not i and (other.stands in route.trail[route.at + 1 :] or j in ahead):
                    relation.add_edge(i, j)
        return not nx.is_directed_acyclic_graph(relation)

    def lines(self):
        """Return the robots on every stand in the order in which they were let onto it; none overtakes on a lane."""
        lines = {}
        for robot in sorted(self.out, key=self.granted.__getitem__):
            line = lines.setdefault(self.declared.routes[robot].stands, [])
            assert (
                robot.ahead not in self.out
                or self.out[robot.ahead].stands is not self.out[robot].stands
                or robot.ahead in line
            )
            line.append(robot)
        return lines

    def state_after(self, robot, stand):
        lines = {place: [other for other in line if other is not robot] for place, line in self.lines().items()}
        lines.setdefault(stand, []).append(robot)
        state = {}
        for place, line in lines.items():
            if line:
                state[place] = tuple(tuple(self.rest(other, robot, stand)) for other in line)
        return state

    def rest(self, robot, mover, stand):
        route = self.declared.routes[robot]
        return route.trail[route.trail.index(stand, route.at + 1) :] if robot is mover else route.trail[route.at :]


def all_come_home(state, most=30_000):
    """Whether some order of moves brings all robots of a state home; None if there are too many states.

    A move takes the first robot of a stand over any number of free stands to a stand with room.
    """
    routes = [route for line in state.values() for route in line]
    number = iter(range(len(routes)))
    start = tuple(sorted(((id(stand), tuple(next(number) for _ in line)) for stand, line in state.items())))
    stands = {id(stand): stand for route in routes for stand in route}
    seen = {(start, (0,) * len(routes))}
    left = list(seen)
    while left:
        lines, done = left.pop()
        if not lines:
            return True
        taken = dict(lines)
        for stand, line in lines:
            for following in moves(stand, line[0], taken, done, routes, stands):
                if following not in seen:
                    if len(seen) >= most:
                        return None
                    seen.add(following)
                    left.append(following)
    return False


def moves(stand, mover, taken, done, routes, stands):
    """Yield the states that follow if the first robot of a stand drives on."""
    route = routes[mover]
    rest = dict(taken)
    rest[stand] = rest[stand][1:]
    if not rest[stand]:
        del rest[stand]
    for at in range(done[mover] + 1, len(route) + 1):
        after = (*done[:mover], at, *done[mover + 1 :])
        if at == len(route):
            yield tuple(sorted(rest.items())), after
            return
        place, line = id(route[at]), taken.get(id(route[at]), ())
        if not may_stand(route, at):
            if line:
                return
            continue
        if not line or has_room(stands[place], line, mover, at, done, routes):
            yield tuple(sorted({**rest, place: (*line, mover)}.items())), after
        if line:
            return


def may_stand(route, at):
    """Whether a robot may stand: on lanes, and on nodes before lanes that are too short, which trails omit."""
    return isinstance(route[at], Lane) or (at + 1 < len(route) and not isinstance(route[at + 1], Lane))


def has_room(stand, line, mover, at, done, routes):
    """Whether a robot may follow others onto a lane, in their direction, and while the lane has room."""
    if not isinstance(stand, Lane):
        return False
    room = math.floor(stand.length / stand.headway + 1e-9) - 1
    first = line[0]
    return len(line) < room and routes[first][done[first] + 1] is routes[mover][at + 1]
