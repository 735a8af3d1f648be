"""An auditor that rebuilds what happened from the log alone and says what cannot have happened.

It shares no code with the traffic model: lanes are checked by positions over time, intersections by the
paper's literal rule (a robot that drives towards another which is nearer than D and within theta of its
heading should have stopped). In a gridlock rotation robots follow each other as a train, D apart along the way.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import defaultdict
from dataclasses import dataclass, field
from itertools import pairwise

from tests.audit_work import Work

TOL = 1e-6


@dataclass
class Visit:
    """One robot on one edge: piecewise linear positions; `leave` inf while it is still there."""

    robot: int
    edge: tuple[str, str]
    enter: float
    leave: float = math.inf
    times: list[float] = field(default_factory=list)
    places: list[float] = field(default_factory=list)

    def at(self, time):
        i = bisect_right(self.times, time)
        if i == 0:
            return self.places[0]
        if i == len(self.times):
            return self.places[-1]
        t0, t1, p0, p1 = self.times[i - 1], self.times[i], self.places[i - 1], self.places[i]
        return p1 if t1 <= t0 else p0 + (p1 - p0) * (time - t0) / (t1 - t0)


class Audit(Work):
    """Problems found in a run, one line each; an empty list is a clean bill."""

    def __init__(self, run):
        self.run = run
        self.problems = []
        model = run.model
        fleet = model.fleet
        shapes = [
            (kind.radius or fleet.robot.radius, kind.speed or fleet.robot.speed)
            for kind in fleet.kinds.values()
            for _ in range(kind.count)
        ]
        shapes += [(fleet.robot.radius, fleet.robot.speed)] * (fleet.size - len(shapes))
        self.speed = [speed for _, speed in shapes]
        self.contact = 2 * max(radius for radius, _ in shapes) + fleet.robot.margin  # the largest pair's, for all
        self.theta = math.radians(model.traffic.collision_angle)
        self.graph = run.layout.graph
        self.visits = defaultdict(list)
        self.trains = defaultdict(set)
        for time, robots, _ in run.record.rings:
            for robot in robots:
                self.trains[robot].add(time)

    def check(self):
        self.rebuild()
        for visits in self.by_edge().values():
            self.check_lane(visits)
        self.check_nodes()
        self.check_work()
        return self.problems

    def fault(self, time, text):
        self.problems.append(f"{time:g}: {text}")

    # Positions over time

    def rebuild(self):
        rows = sorted(self.run.record.rows, key=lambda row: row[0])
        where = {}
        for time, kind, robot, _, node, edge, value, until, _ in rows:
            if kind == "enter":
                self.enters(where, time, robot, edge)
            elif kind == "drive":
                self.drives(where.get(robot), time, robot, edge, value, until)
            elif kind in {"parked", "docked"} and robot in where:
                visit = where.pop(robot)
                visit.leave = time
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
        where[robot] = Visit(robot, edge, time, times=[time], places=[0.0])
        self.visits[robot].append(where[robot])

    def drives(self, visit, time, robot, edge, value, until):
        if visit is None or visit.edge != edge:
            self.fault(time, f"robot {robot} drives on {edge}, where it is not")
            return
        place = visit.places[-1]
        limit = min(self.speed[robot], self.graph.edges[edge]["speed"])
        if time < visit.times[-1] - TOL or value < place - TOL:
            self.fault(time, f"robot {robot} sets off on {edge} before it had arrived")
        if value > self.graph.edges[edge]["length"] + TOL or (value - place) > limit * (until - time) + TOL:
            self.fault(time, f"robot {robot} drives from {place} to {value} on {edge} in {until - time}")
        visit.times += [time, until]
        visit.places += [place, value]

    def by_edge(self):
        edges = defaultdict(list)
        for visits in self.visits.values():
            for visit in visits:
                edges[visit.edge].append(visit)
        for visits in edges.values():
            visits.sort(key=lambda visit: visit.enter)
        return edges

    # Lanes: D apart, in order

    def check_lane(self, visits):
        for first, then in pairwise(visits):
            if first.leave > then.leave + TOL:
                self.fault(then.leave, f"robot {then.robot} overtook robot {first.robot} on {then.edge}")
            begin, end = then.enter, min(first.leave, then.leave)
            if end <= begin + TOL:
                continue
            end = min(end, max(first.times[-1], then.times[-1], begin))
            for time in sorted({begin, end, *first.times, *then.times}):
                if begin <= time <= end and first.at(time) - then.at(time) < self.contact - TOL:
                    gap = first.at(time) - then.at(time)
                    self.fault(time, f"robots {first.robot} and {then.robot} are {gap:g} apart on {then.edge}")
                    break

    # Intersections: one at a time, and the literal rule for the next

    def check_nodes(self):
        """For every robot that leaves a node: whoever comes through next keeps away from it."""
        passages = defaultdict(list)
        for visits in self.visits.values():
            for before, after in zip([None, *visits], visits, strict=False):
                follows = before is not None and abs(before.leave - after.enter) <= TOL
                passages[after.edge[0]].append((after.enter, before if follows else None, after))
            for visit in visits:
                if math.isfinite(visit.leave) and not any(v.enter == visit.leave for v in visits):
                    passages[visit.edge[1]].append((visit.leave, visit, None))
        for node, items in passages.items():
            items.sort(key=lambda item: (item[0], item[2] is not None))
            for (left, _, away), (_, via, onward) in pairwise(items):
                if away is not None:
                    self.check_passage(node, left, away, via, onward)

    def check_passage(self, node, left, away, via, onward):
        robot, other = (via or onward).robot, away.robot
        need = self.contact
        if via is None:
            gap = away.at(onward.enter) if onward.enter < away.leave else math.inf
            if gap < need - TOL:
                self.fault(onward.enter, f"robot {robot} came out of a bay at {node}, {gap:g} from robot {other}")
            return
        length = self.graph.edges[via.edge]["length"]
        begin = next((t for t, p in zip(via.times, via.places[1:], strict=False) if p > length - need + TOL), via.leave)
        if begin < left - TOL:
            self.fault(begin, f"robot {robot} drove onto {node} while robot {other} was there")
        train = any(abs(time - begin) <= TOL for time in self.trains[robot])
        for step in range(41):
            time = begin + (via.leave - begin) * step / 40
            if train:
                gap = length - via.at(time) + away.at(time)
                if time < away.leave and gap < need - TOL:
                    self.fault(time, f"robot {robot} on {via.edge} is {gap:g} behind robot {other} on {away.edge}")
                continue
            if time < away.leave and away.at(time) < need - TOL:  # D beyond the node it is clear of it
                self.literal(time, via, away, need)

    def literal(self, time, via, away, need):
        """The paper's rule for the robot on `via` and the one on `away`, where edges are drawn straight."""
        (x1, y1), (x2, y2) = self.point(via, time), self.point(away, time)
        distance = math.dist((x1, y1), (x2, y2))
        moving = via.at(time + 1e-4) > via.at(time) + 1e-9
        if not moving or distance >= need - 1e-4 or distance < 1e-9:
            return
        heading = self.run.layout.heading(via.edge)
        bearing = math.atan2(y2 - y1, x2 - x1)
        angle = abs((bearing - heading + math.pi) % (2 * math.pi) - math.pi)
        if angle < self.theta - 1e-4 or angle < 1e-6:
            self.fault(
                time,
                f"robot {via.robot} on {via.edge} drives at robot {away.robot} on {away.edge}, "
                f"{distance:g} away at {math.degrees(angle):g} degrees",
            )

    def point(self, visit, time):
        return self.run.layout.position(visit.edge, visit.at(time))


def audit(run):
    """All that cannot have happened in a run of level `all`, one line each."""
    return Audit(run).check()
