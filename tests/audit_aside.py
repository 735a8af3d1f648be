"""The part of the auditor that looks at wide aisles: who stands beside a lane, and who is on it.

A robot is off the lane from its row `aside` to its row `back`, both at one position. On the lane, before and after
that, it keeps its distance from all others, whoever came first.
"""

import math
from collections import defaultdict
from itertools import pairwise

TOL = 1e-6
HANDLES = {"loading", "unloading", "awaiting_picker"}


class Asides:
    """Checks of robots beside lanes, for `Audit`, which knows where robots were."""

    def steps_aside(self, visit, time, robot, edge, value):
        """A robot leaves its lane, on which it stands."""
        if visit is None or visit.edge != edge or abs(visit.at(time) - value) > TOL:
            self.fault(time, f"robot {robot} leaves {edge} at {value}, where it is not")
            return
        if visit.asides and visit.asides[-1][1] == math.inf:
            self.fault(time, f"robot {robot} leaves {edge}, beside which it stands already")
        visit.asides.append((time, math.inf))

    def steps_back(self, visit, time, robot, edge, value):
        """A robot that stood beside its lane is on it again, where it left it."""
        if visit is None or visit.edge != edge or not visit.asides or visit.asides[-1][1] < math.inf:
            self.fault(time, f"robot {robot} comes back onto {edge}, beside which it does not stand")
            return
        if abs(visit.at(time) - value) > TOL:
            self.fault(time, f"robot {robot} comes back onto {edge} at {value}, not where it left that")
        visit.asides[-1] = visit.asides[-1][0], time

    def check_asides(self, edges):
        """Robots stand beside wide aisles alone, at storage places, one at each, and do nothing but load there."""
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
        """It has left the lane to load or unload, perhaps when a picker comes."""
        rows = self.rows_by_robot[visit.robot]
        begins = {*HANDLES, "awaiting_picker"}
        if not any(kind in begins and abs(time - begin) <= TOL for time, kind in rows):
            self.fault(begin, f"robot {visit.robot} leaves {visit.edge} and does not load there")

    def check_wide_lane(self, visits):
        """On a lane beside which robots stand, those on it keep D apart, whoever entered it first."""
        pieces = sorted((piece for visit in visits for piece in self.parts(visit)), key=lambda piece: piece.enter)
        present = []
        for piece in pieces:
            present = [other for other in present if other.leave > piece.enter + TOL]
            for other in present:
                self.check_pair(other, piece)
            present.append(piece)

    def check_pair(self, one, other):
        """Two that are on the lane at one time: one is D behind the other all the while."""
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
        """When a robot is off a lane: in a wide aisle others may come back onto it while it stands on the node.

        Elsewhere they come in by that node, and it has left that first.
        """
        length = self.graph.edges[visit.edge]["length"]
        if visit.edge not in self.run.layout.widths:
            return visit.leave
        points = zip(visit.times, visit.places, strict=True)
        return min([visit.leave, *(time for time, place in points if place >= length - TOL)])

    def parts(self, visit):
        """A visit without the times at which the robot stood beside the lane."""
        begin = visit.enter
        for left, back in [*visit.asides, (visit.leave, None)]:
            if left > begin + TOL or not visit.asides:
                yield visit.part(begin, left, stands=left < visit.leave, stood=begin > visit.enter)
            begin = back
