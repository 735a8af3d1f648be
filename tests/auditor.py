"""An auditor that reconstructs a run from its log alone, and lists everything that is impossible.

It shares no code with the traffic model. Lanes are checked by positions over time, intersections by the literal rule of
the paper: a robot must stop for a robot that is nearer than D and within theta of its heading. In a gridlock rotation
robots follow each other as a train, D apart along their route.
"""

import math
from bisect import bisect_right
from collections import defaultdict
from dataclasses import dataclass, field
from itertools import pairwise

import networkx as nx

from tests.audit_aside import Asides
from tests.audit_closures import Closures
from tests.audit_hours import Hours
from tests.audit_lifts import Lifts
from tests.audit_motion import Motion
from tests.audit_nodes import Nodes
from tests.audit_pickers import Pickers
from tests.audit_servers import Servers
from tests.audit_work import STATES, Work

TOL = 1e-6


@dataclass
class Visit:
    """A robot on an edge, with piecewise linear positions; `leave` is inf while it is still there."""

    robot: int
    edge: tuple[str, str]
    enter: float
    leave: float = math.inf
    times: list[float] = field(default_factory=list)
    places: list[float] = field(default_factory=list)
    into_bay: bool = False
    cleared: bool = False
    limit: float = math.inf
    asides: list[tuple[float, float]] = field(default_factory=list)
    whole: object = None
    stood: bool = False

    def part(self, begin, end, *, stands, stood):
        """Return the part of the visit between two times.

        `stood`, `stands`: whether the robot stood beside the lane before, or stands there afterwards.
        """
        inside = [(time, place) for time, place in zip(self.times, self.places, strict=True) if begin < time < end]
        points = [(begin, self.at(begin)), *inside, *([(end, self.at(end))] if end < math.inf else [])]
        if not stood and self.times[0] >= begin:
            points[0] = self.times[0], self.places[0]
        times, places = [time for time, _ in points], [place for _, place in points]
        leaves = stands or self.cleared
        return Visit(
            self.robot, self.edge, begin, end, times, places, self.into_bay, leaves, self.limit, [], self, stood
        )

    def at(self, time):
        i = bisect_right(self.times, time)
        if i == 0:
            return self.places[0]
        if i == len(self.times):
            return self.places[-1]
        t0, t1, p0, p1 = self.times[i - 1], self.times[i], self.places[i - 1], self.places[i]
        return p1 if t1 <= t0 else p0 + (p1 - p0) * (time - t0) / (t1 - t0)


class Audit(Nodes, Motion, Work, Closures, Hours, Servers, Lifts, Asides, Pickers):
    """The checks of a run; `check` returns its faults, one line each, and an empty list for a valid run."""

    def __init__(self, run):
        self.run = run
        self.problems = []
        model = run.model
        fleet = model.fleet
        self.robots = fleet.robots()
        speeds = [speed for robot in self.robots for speed in (robot.speed, robot.loaded_speed)]
        self.state = defaultdict(lambda: "idle")
        widest = 2 * max(robot.radius for robot in self.robots)
        self.contact = widest + fleet.robot.margin  # D, for all robots that of the largest pair
        limits = [limit for *_, limit in run.layout.graph.edges(data="speed")]
        slowest = min([*speeds, *limits, *(slow.speed for slow in model.traffic.slow.values())])
        self.slack = TOL * (1 + max(speeds))  # tolerance of lengths, if lengths and times agree within TOL
        self.delay = TOL * (1 + 1 / slowest)  # tolerance of times
        self.theta = math.radians(model.traffic.collision_angle)
        self.graph = run.layout.graph
        self.visits = defaultdict(list)
        self.trains = defaultdict(set)
        for time, robots, _ in run.record.rings:
            for robot in robots:
                self.trains[robot].add(time)

    def check(self):
        self.check_traffic()
        self.check_work()
        self.check_hours()
        self.check_servers()
        self.check_pickers()
        return self.problems

    def check_traffic(self):
        self.rebuild()
        edges = self.by_edge()
        for visits in edges.values():
            if any(visit.asides for visit in visits):
                self.check_wide_lane(visits)
            else:
                self.check_lane(visits)
        self.check_asides(edges)
        self.check_two_way(edges)
        self.check_turns()
        self.check_zones(edges)
        self.check_closures()
        self.check_held()
        self.check_nodes()
        self.check_lifts()
        self.check_motion()
        return self.problems

    def fault(self, time, text):
        self.problems.append(f"{time:g}: {text}")

    # Positions over time

    def rebuild(self):
        rows = sorted(self.run.record.rows, key=lambda row: row[0])
        self.delays = {(row[2], row[5], row[0]): row[6] for row in rows if row[1] == "collision" and row[5] is not None}
        where = {}
        self.rows_by_robot = defaultdict(list)
        for robot, place in enumerate(self.run.model.fleet.start_on_lanes):
            if hasattr(place, "edge"):  # the robot is there from the start
                where[robot] = Visit(robot, place.edge, -math.inf, times=[0.0], places=[place.offset])
                self.visits[robot].append(where[robot])
        for time, kind, robot, _, node, edge, value, until, _ in rows:
            self.rows_by_robot[robot].append((time, kind))
            if kind == "enter":
                self.enters(where, time, robot, edge)
            elif kind == "aside":
                self.steps_aside(where.get(robot), time, robot, edge, value)
            elif kind == "back":
                self.steps_back(where.get(robot), time, robot, edge, value)
            elif kind == "drive":
                self.drives(where.get(robot), time, robot, edge, value, until)
            elif kind in STATES:
                self.state[robot] = kind
            elif kind == "cleared" and robot in where:
                visit = where.pop(robot)
                visit.leave, visit.into_bay, visit.cleared = time, True, True
            elif kind in {"parked", "docked"} and robot in where:
                visit = where.pop(robot)
                visit.leave, visit.into_bay = time, True
                length = self.graph.edges[visit.edge]["length"]
                if abs(visit.at(time) - length) > TOL or visit.edge[1] != node:
                    self.fault(time, f"robot {robot} entered a bay at {node} from {visit.edge} at {visit.at(time)}")

    def enters(self, where, time, robot, edge):
        last = where.get(robot)
        if last is not None:
            length = self.graph.edges[last.edge]["length"]
            if last.edge[1] != edge[0] or abs(last.at(time) - length) > TOL:
                self.fault(time, f"robot {robot} jumped from {last.edge} at {last.at(time)} to {edge}")
            last.leave = time
        set_out = time - TOL
        if any(train <= time + TOL for train in self.trains[robot]):  # a ring turns as it started
            set_out = last.times[-2] if last is not None and len(last.times) > 1 else time
            set_out = min(set_out, time - self.delays.get((robot, edge, time), 0.0)) - self.start_time
        limit = self.slow_limit(edge, set_out, time + TOL)
        where[robot] = Visit(robot, edge, time, times=[time], places=[0.0], limit=limit)
        self.visits[robot].append(where[robot])

    def drives(self, visit, time, robot, edge, value, until):
        if visit is None or visit.edge != edge:
            self.fault(time, f"robot {robot} drives on {edge}, where it is not")
            return
        place = visit.places[-1]
        limit = min(self.speed_of(robot, self.state[robot]), self.graph.edges[edge]["speed"], visit.limit)
        if time < visit.times[-1] - TOL or value < place - TOL:
            self.fault(time, f"robot {robot} sets off on {edge} before it had arrived")
        if value > self.graph.edges[edge]["length"] + TOL or (value - place) > limit * (until - time) + TOL:
            self.fault(time, f"robot {robot} drives from {place} to {value} on {edge} in {until - time}")
        visit.times += [time, until]
        visit.places += [place, value]

    def stands_on(self, time, robot):
        """Return the nodes on which a robot stands at a time, or beside which it is in a bay; empty on an edge."""
        nodes = set()
        last = None
        for visit in self.visits[robot]:
            if visit.enter > time:
                break
            last = visit
            if visit.leave >= time - TOL:
                if visit.enter >= time - TOL:
                    nodes.add(visit.edge[0])
                if abs(visit.at(time) - self.graph.edges[visit.edge]["length"]) <= TOL:
                    nodes.add(visit.edge[1])
        if last is None:
            nodes.add(self.starts()[robot])
        elif last.leave < time:
            nodes.add(last.edge[1])
        return nodes

    def starts(self):
        """Return the node at which each robot starts, in a bay or on the lanes, or to which its edge leads."""
        fleet = self.run.model.fleet
        homes = fleet.start or tuple(self.run.layout.bays)
        nodes = [homes[number % len(homes)] for number in range(fleet.size)]
        for robot, place in enumerate(fleet.start_on_lanes):
            nodes[robot] = place.node if hasattr(place, "node") else place.edge[1]
        first = {}  # robots of a settled fleet begin where they charge
        for time, kind, robot, _, node, *_ in self.run.record.rows:
            if time > 0:
                break
            if kind == "idle" and node is not None:
                first.setdefault(robot, node)
        for robot, node in first.items():
            nodes[robot] = node
        return nodes

    def by_edge(self):
        edges = defaultdict(list)
        for visits in self.visits.values():
            for visit in visits:
                edges[visit.edge].append(visit)
        for visits in edges.values():
            visits.sort(key=lambda visit: (visit.enter, -visit.places[0]))
        return edges

    # Lanes: D apart, in order

    def check_lane(self, visits):
        for first, then in self.one_behind_the_other(visits):
            if first.leave > then.leave + TOL and not then.cleared:
                self.fault(then.leave, f"robot {then.robot} overtook robot {first.robot} on {then.edge}")
            begin, end = then.enter, min(first.leave, then.leave, self.run.record.end)
            if end <= begin + TOL:
                continue
            self.check_braking(first, then)
            end = min(end, max(first.times[-1], then.times[-1], begin))
            for time in sorted({begin, end, *first.times, *then.times}):
                if begin <= time <= end and first.at(time) - then.at(time) < self.contact - self.slack:
                    gap = first.at(time) - then.at(time)
                    self.fault(time, f"robots {first.robot} and {then.robot} are {gap:g} apart on {then.edge}")
                    break

    def one_behind_the_other(self, visits):
        """Yield each visit with the visit before it; if that was cleared off the edge, also with earlier visits."""
        before = []
        for visit in visits:
            yield from ((first, visit) for first in before)
            before = [*(before if visit.cleared else ()), visit]

    def check_turns(self):
        """Between two edges a robot spends at least the time of the node and of its turn.

        A robot that loads within the tolerance of the end of a short edge is already there, and spends no time.
        """
        traffic = self.run.model.traffic
        heading = self.run.layout.headings
        for visits in self.visits.values():
            for before, visit in pairwise(visits):
                if before.into_bay:
                    continue
                length = self.graph.edges[before.edge]["length"]
                reached = next(
                    (t for t, p in zip(before.times, before.places, strict=True) if p >= length - 1e-9), None
                )
                angle = math.degrees(abs(heading[before.edge] - heading[visit.edge]))
                least = traffic.node_time + traffic.turn_time * min(angle, 360 - angle) / 90
                if reached is not None and visit.enter < reached + least - self.delay:
                    spent = visit.enter - reached
                    self.fault(visit.enter, f"robot {visit.robot} spends {spent:g} of {least:g} at {visit.edge[0]}")

    def check_two_way(self, edges):
        """A two-way lane is used in one direction at a time, and no robot stands on it within D of a node.

        As robots are D apart, no more than floor(length / D) - 1 robots stand on it.
        """
        for a, b in self.run.layout.two_way:
            for visit in (*edges.get((a, b), ()), *edges.get((b, a), ())):
                self.check_clear_of_nodes(visit)
            there, back = (
                [part for visit in edges.get(edge, ()) for part in self.parts(visit)] for edge in ((a, b), (b, a))
            )
            for visit in there:
                for other in back:
                    begin, end = max(visit.enter, other.enter), min(self.is_off(visit), self.is_off(other))
                    if visit.robot != other.robot and end > begin + self.delay:
                        self.fault(begin, f"robots {visit.robot} and {other.robot} meet head-on between {a} and {b}")

    def check_clear_of_nodes(self, visit):
        length = self.graph.edges[visit.edge]["length"]
        if self.is_below(length, 2 * self.contact) or visit.edge in self.closed():
            return
        stands = zip(visit.times, visit.places, [*visit.times[1:], visit.leave], [*visit.places[1:], None], strict=True)
        for begin, place, end, then in stands:
            near = min(place, length - place)
            if then in {place, None} and end > begin + self.delay and self.slack < near < self.contact - self.slack:
                self.fault(begin, f"robot {visit.robot} stands on {visit.edge}, {near:g} from a node")

    def check_zones(self, edges):
        """In a zone for one robot there is at most one, and in a zone for one direction no two face each other."""
        for name, zone in self.run.model.traffic.zones.items():
            drawn = [tuple(member) for member in zone.members if not isinstance(member, str)]
            both = [edge for a, b in drawn for edge in ((a, b), (b, a))]
            parts = (part for edge in both for visit in edges.get(edge, ()) for part in self.parts(visit))
            signs = directions(drawn) if zone.rule == "one-direction" else {}
            present = []
            for visit in sorted(parts, key=lambda visit: visit.enter):
                present = [other for other in present if other.leave > visit.enter + self.delay]
                for other in present:
                    apart = zone.rule == "one-robot" or signs[visit.edge] != signs[other.edge]
                    if other.robot != visit.robot and apart:
                        self.fault(visit.enter, f"robots {visit.robot} and {other.robot} are both in zone {name}")
                present.append(visit)


def directions(edges):
    """Return +1 for each edge along a line, and -1 for each edge back."""
    line = nx.Graph(edges)
    start = next(node for node in line if line.degree(node) == 1)
    order = list(nx.dfs_preorder_nodes(line, start))
    return {pair[::step]: step for pair in pairwise(order) for step in (1, -1)}


def audit(run):
    """Return all faults of a run with `log: all`, one line each."""
    return Audit(run).check()
