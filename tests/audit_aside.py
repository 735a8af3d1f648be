"""The part of the auditor for wide aisles: robots beside lanes, and robots on these lanes.

A robot is beside its lane from its row `aside` to its row `back`, both at one position. On the lane, before and after,
it keeps its distance from all other robots, in any order.
"""

import math
from collections import defaultdict
from itertools import pairwise

TOL = 1e-6
HANDLES = {"loading", "unloading", "awaiting_picker"}


class Asides:
    """Checks of robots beside lanes, for `Audit`, which knows where robots were."""

    def steps_aside(self, visit, time, robot, edge, value):
        """Note that a robot leaves its lane; a fault if it does not stand there on the lane."""
        if visit is None or visit.edge != edge or abs(visit.at(time) - value) > TOL:
            self.fault(time, f"robot {robot} leaves {edge} at {value}, where it is not")
            return
        if visit.asides and visit.asides[-1][1] == math.inf:
            self.fault(time, f"robot {robot} leaves {edge}, beside which it stands already")
        visit.asides.append((time, math.inf))

    def steps_back(self, visit, time, robot, edge, value):
        """Note that a robot is on its lane again; a fault if it was not beside the lane, or returns elsewhere."""
        if visit is None or visit.edge != edge or not visit.asides or visit.asides[-1][1] < math.inf:
            self.fault(time, f"robot {robot} comes back onto {edge}, beside which it does not stand")
            return
        if abs(visit.at(time) - value) > TOL:
            self.fault(time, f"robot {robot} comes back onto {edge} at {value}, not where it left that")
        visit.asides[-1] = visit.asides[-1][0], time

    def check_asides(self, edges):
        """Robots stand only beside wide aisles, one at each place, and only load or unload there."""
        layout = self.run.layout
        beside = defaultdict(list)
        for edge, visits in edges.items():
            for visit in visits:
                for begin, end in visit.asides:
                    width, length = layout.widths.get(edge, 0.0), self.graph.edges[edge]["length"]
                    if width < 2 * self.contact - TOL or self.is_below(length, 2 * self.contact):
                        self.fault(begin, f"robot {visit.robot} stands beside {edge}, which has no room for it")
                    lane = min(edge, edge[::-1]) if self.graph.edges[edge].get("two_way") else edge
                    place = visit.at(begin) if lane == edge else length - visit.at(begin)
                    beside[lane, round(place, 8)].append((begin, end, visit.robot))
                    if any(begin + TOL < time < end - TOL for time in self.sets_off(visit)):
                        self.fault(begin, f"robot {visit.robot} drives while it stands beside {edge}")
                    self.check_handles(visit, begin)
        for (lane, place), stays in beside.items():
            for (_, end, first), (begin, _, then) in pairwise(sorted(stays)):
                if begin < end - TOL:
                    self.fault(begin, f"robots {first} and {then} stand beside {lane} at {place}, where one has room")

    @staticmethod
    def sets_off(visit):
        return [
            time
            for time, then, place, to in zip(visit.times, visit.times[1:], visit.places, visit.places[1:], strict=False)
            if to > place + TOL and then > time + TOL
        ]

    def check_handles(self, visit, begin):
        """A robot leaves its lane only to load, to unload, or to wait for a picker who does so."""
        rows = self.rows_by_robot[visit.robot]
        begins = {*HANDLES, "awaiting_picker"}
        if not any(kind in begins and abs(time - begin) <= TOL for time, kind in rows):
            self.fault(begin, f"robot {visit.robot} leaves {visit.edge} and does not load there")

    def check_wide_lane(self, visits):
        """On a lane beside which robots stand, the robots on it keep D apart, regardless of the order of entry."""
        pieces = sorted((piece for visit in visits for piece in self.parts(visit)), key=lambda piece: piece.enter)
        present = []
        for piece in pieces:
            present = [other for other in present if other.leave > piece.enter + TOL]
            for other in present:
                self.check_pair(other, piece)
            present.append(piece)

    def check_pair(self, one, other):
        """Of two robots that are on a lane at one time, one is always at least D behind the other."""
        begin, end = max(one.enter, other.enter), min(one.leave, other.leave, self.run.record.end)
        end = min(end, max(one.times[-1], other.times[-1], begin))
        first, then = (one, other) if one.at(begin + TOL) >= other.at(begin + TOL) else (other, one)
        self.check_braking(first, then)
        for time in sorted({begin, end, *first.times, *then.times}):
            if begin <= time <= end and first.at(time) - then.at(time) < self.contact - self.slack:
                gap = first.at(time) - then.at(time)
                self.fault(time, f"robots {first.robot} and {then.robot} are {gap:g} apart on {then.edge}")
                return

    def is_off(self, visit):
        """Return when a robot is off a lane: in a wide aisle, when it reaches the node at the end.

        There, other robots may come back onto the lane while it stands on the node. Elsewhere they enter by this node,
        after it has left.
        """
        length = self.graph.edges[visit.edge]["length"]
        if visit.edge not in self.run.layout.widths:
            return visit.leave
        points = zip(visit.times, visit.places, strict=True)
        return min([visit.leave, *(time for time, place in points if place >= length - TOL)])

    def parts(self, visit):
        """Yield the parts of a visit in which the robot was not beside the lane."""
        begin = visit.enter
        for left, back in [*visit.asides, (visit.leave, None)]:
            if left > begin + TOL or not visit.asides:
                yield visit.part(begin, left, stands=left < visit.leave, stood=begin > visit.enter)
            begin = back
