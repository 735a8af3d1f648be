"""The part of the auditor for intersections: one robot at a time, and the paper's rule for the next robot.

Nodes joined by edges shorter than D are one intersection. A robot is in it from when it sets out for the first node
until it leaves the last.
"""

import math
from collections import defaultdict
from dataclasses import dataclass, field
from itertools import pairwise

import networkx as nx

TOL = 1e-6
STEPS = 40


@dataclass
class Stay:
    """A robot in an intersection: it came by the visit `via` (None: from a bay) and left on `away` (None: to a bay)."""

    via: object = None
    inside: list = field(default_factory=list)
    begin: float = -math.inf
    left: float = math.inf
    away: object = None
    who: int = -1

    @property
    def robot(self):
        if self.who >= 0:
            return self.who
        return next(visit.robot for visit in (self.via, *self.inside, self.away) if visit is not None)

    def visit(self, time):
        """Return the robot's visit at a time before it left."""
        visits = [visit for visit in (self.via, *self.inside) if visit is not None]
        return next((visit for visit in visits if time < visit.leave), visits[-1])


class Nodes:
    """Checks of intersections, for `Audit`, which knows where robots were."""

    def check_nodes(self):
        """A robot that crosses an intersection keeps its distance from all robots that have left it."""
        for node, stays in self.stays().items():
            near = []
            for stay in sorted(stays, key=lambda stay: (stay.left, stay.begin)):
                near = [other for other in near if self.clear(other) > stay.begin - TOL]
                for other in near:
                    self.check_passage(node, stay, other)
                near.append(stay)

    def joined(self):
        """Return the name of the intersection of every node."""
        lengths = self.graph.edges(data="length")
        close = nx.Graph((one, other) for one, other, length in lengths if self.is_below(length, self.contact))
        for zone in self.run.model.traffic.zones.values():
            if zone.rule == "one-robot":
                nodes = [node for one in zone.members for node in ([one] if isinstance(one, str) else one)]
                close.add_edges_from(pairwise(nodes))
        close.add_nodes_from(self.graph)
        return {node: "+".join(sorted(part)) for part in nx.connected_components(close) for node in part}

    @staticmethod
    def is_below(length, exact):
        """Whether an edge is shorter than a limit by more than rounding."""
        return length < exact and abs(length - exact) > TOL

    def closed(self):
        """Return the edges in zones for one robot, on which a robot is still in the intersection."""
        zones = self.run.model.traffic.zones.values()
        drawn = [one for zone in zones if zone.rule == "one-robot" for one in zone.members if not isinstance(one, str)]
        return {edge for a, b in drawn for edge in ((a, b), (b, a))}

    def stays(self):
        """Return all stays by intersection."""
        of, inside = self.joined(), self.closed()
        stays = defaultdict(list)
        for visits in self.visits.values():
            stay = None
            for before, visit in pairwise([None, *visits]):
                start, end = of[visit.edge[0]], of[visit.edge[1]]
                follows = before is not None and abs(before.leave - visit.enter) <= TOL
                if before is None and visit.enter < 0:  # the robot starts on the edge
                    stay = Stay(via=visit, begin=self.sets_out(visit), left=visit.leave)
                    self.add(stays[end], stay)
                    continue
                if stay is None or not follows:  # out of a bay
                    stay = Stay(begin=self.comes_out(before, visit))
                    stays[start].append(stay)
                if start == end and (visit.edge in inside or self.length(visit) < 2 * self.contact - TOL):
                    stay.inside.append(visit)
                    stay.left = visit.leave
                    continue
                stay.left, stay.away = visit.enter, visit
                stay = Stay(via=visit, begin=self.sets_out(visit), left=visit.leave)
                self.add(stays[end], stay)
        for robot, node, begin, end in self.loads_on_nodes():
            self.add_load(stays[of[node]], robot, begin, end)
        return stays

    @staticmethod
    def add(stays, stay):
        """Add the stay of a robot on its way to a node, unless it never sets out for it or is cleared off before."""
        if math.isfinite(stay.begin) and not (stay.via.cleared and stay.begin >= stay.via.leave):
            stays.append(stay)

    def comes_out(self, before, visit):
        """Return when a robot is on the node from which it enters an edge: 0 if it starts there, or else on entry."""
        places = self.run.model.fleet.start_on_lanes[visit.robot : visit.robot + 1]
        if before is not None or not any(hasattr(place, "node") for place in places):
            return visit.enter
        mine = (
            row
            for row in self.run.record.rows
            if row[2] == visit.robot and row[1] in {"parked", "docked", "cleared", "enter"}
        )
        return 0.0 if next(mine)[1] == "enter" else visit.enter

    def add_load(self, stays, robot, begin, end):
        """Add the stay of a robot that came out of a bay and loads on the node, if no stay covers the load."""
        mine = (stay for stay in stays if stay.robot == robot)
        if not any(stay.begin <= begin + TOL and stay.left >= end - TOL for stay in mine):
            stays.append(Stay(begin=begin, left=end, who=robot))

    def loads_on_nodes(self):
        """Yield the loads of robots that stand on a node: robot, node, and the interval in which it is surely there."""
        good, begun = {}, {}
        for time, kind, robot, task, _, _, value, *_ in sorted(self.run.record.rows, key=lambda row: row[0]):
            if kind == "released" and value >= 0:
                good[task] = self.run.layout.storage[int(value)].edge
            elif kind == "loading" and task in good and good[task][0] == good[task][1]:
                begun[robot] = time, good[task][0]
            elif kind in {"enter", "parked", "docked", "cleared"} and robot in begun:
                since, node = begun.pop(robot)
                if time > since + TOL:
                    yield robot, node, since, time

    def length(self, visit):
        return self.graph.edges[visit.edge]["length"]

    def sets_out(self, via):
        """Return when a robot leaves the stop line, D before the end of its edge; inf if it never does."""
        line = self.length(via) - self.contact + TOL
        return next((t for t, p in zip(via.times, via.places[1:], strict=False) if p > line), via.leave)

    def clear(self, stay):
        """Return when a robot that has left is D beyond its node, or in a bay."""
        away = stay.away
        if away is None:
            return stay.left
        for (t0, p0), (t1, p1) in pairwise(zip(away.times, away.places, strict=True)):
            if p1 >= self.contact - self.slack:
                return t1 - (t1 - t0) * max(p1 - self.contact, 0) / (p1 - p0) if p1 > p0 else t1
        return away.leave

    def check_passage(self, node, stay, other):
        """The robot of `stay` crosses after the robot of `other` has left, and keeps its distance."""
        robot, leaver = stay.robot, other.robot
        away = other.away
        if stay.via is None:
            gap = away.at(stay.begin) if away is not None and stay.begin < away.leave else math.inf
            if stay.begin < other.left - self.delay or gap < self.contact - self.slack:
                self.fault(stay.begin, f"robot {robot} came out of a bay at {node}, {gap:g} from robot {leaver}")
        elif stay.begin < other.left - self.delay:
            self.fault(stay.begin, f"robot {robot} drove onto {node} while robot {leaver} was there")
        if away is None:
            return
        train = any(
            -2 * self.delay <= stay.begin - time <= 2 * self.delay + self.start_time and time in self.trains[leaver]
            for time in self.trains[robot]
        )
        end = min(stay.left, self.clear(other), self.run.record.end)  # at the end of a run both may still be there
        for step in range(STEPS + 1 if end > stay.begin else 0):
            time = stay.begin + (end - stay.begin) * step / STEPS
            via = stay.visit(time) if stay.via or stay.inside else None
            if via is None or time >= away.leave or away.at(time) >= self.contact - self.slack:
                continue
            if train:
                self.follows(time, via, away)
            else:
                self.literal(time, via, away)

    def follows(self, time, via, away):
        """In a rotation, robots follow each other as a train, D apart along their route."""
        gap = self.length(via) - via.at(time) + away.at(time)
        if via.edge[1] == away.edge[0] and gap < self.contact - self.slack:
            self.fault(time, f"robot {via.robot} on {via.edge} is {gap:g} behind robot {away.robot} on {away.edge}")

    def literal(self, time, via, away):
        """The robot on `via` obeys the paper's rule with respect to the robot on `away`, if edges are straight."""
        if not (self.is_straight(via) and self.is_straight(away)):
            return
        (x1, y1), (x2, y2) = self.point(via, time), self.point(away, time)
        distance = math.dist((x1, y1), (x2, y2))
        moving = via.at(time + 1e-4) > via.at(time) + 1e-9
        if not moving or distance >= self.contact - 1e-4 or distance < 1e-9:
            return
        heading = self.run.layout.headings[via.edge]
        bearing = math.atan2(y2 - y1, x2 - x1)
        angle = abs((bearing - heading + math.pi) % (2 * math.pi) - math.pi)
        if angle < self.theta - 1e-4 or angle < 1e-6:
            self.fault(
                time,
                f"robot {via.robot} on {via.edge} drives at robot {away.robot} on {away.edge}, "
                f"{distance:g} away at {math.degrees(angle):g} degrees",
            )

    def is_straight(self, visit):
        """Whether an edge is as long as drawn; on other edges a robot's position in the plane is unknown."""
        ends = [self.run.layout.position(visit.edge, along) for along in (0.0, self.length(visit))]
        return abs(math.dist(*ends) - self.length(visit)) <= TOL

    def point(self, visit, time):
        return self.run.layout.position(visit.edge, visit.at(time))
