"""The part of the auditor for speeds: no robot is faster than its acceleration and braking allow.

Between two instants at which a robot certainly stands (it loads, unloads, or is in a bay or station), it takes at least
the time of the fastest drive over its distance, from rest to rest.
"""

import math
from functools import cached_property
from itertools import groupby

from tests.audit_work import STATES
from tests.world.closed_form import drive_time

TOL = 1e-6
STANDS = {"loading", "unloading", "parked", "docked", "cleared"}


class Motion:
    """Checks of how fast robots drive, for `Audit`."""

    def speed_of(self, robot, state):
        """Return the speed of a robot in a state."""
        spec = self.robots[robot]
        return spec.loaded_speed if state == "loaded" else spec.speed

    @cached_property
    def start_time(self):
        """The longest time for gathering speed and braking, for which the robots of a ring may wait for each other."""
        fastest = max(self.speed_of(i, state) for i in range(len(self.robots)) for state in ("loaded", "empty"))
        gathers, brakes = zip(*(one.motion for one in self.robots), strict=True)
        return fastest * (max(gathers) + max(brakes)) / 2

    def check_motion(self):
        if not any(any(one.motion) for one in self.robots):
            return
        rows = sorted(self.run.record.rows, key=lambda row: (row[2], row[0]))
        for robot, mine in groupby(rows, key=lambda row: row[2]):
            if robot >= 0:
                self.check_stretches(robot, mine)

    def check_braking(self, first, then):
        """A robot that keeps its braking distance can always stop D behind the robot ahead on its edge.

        Its braking distance is shorter while it gathers speed, and before a stop. The robots of a ring turn together, D
        apart. At the instant at which `first` is cleared or steps beside the lane, `then` may drive on.
        """
        robot = self.robots[then.robot]
        if robot.keeps != "braking" or self.in_ring(then) or self.in_ring(first):
            return
        gathers, brakes = robot.motion
        last = min(first.leave - (TOL if first.cleared else 0.0), then.leave, self.run.record.end)
        for begin, end, place, to, stood, stop in self.drives_of(then):
            pace = (to - place) / (end - begin)
            run_up, braking = pace * pace * gathers / 2, pace * pace * brakes / 2
            bends = [begin + (bend - place) / pace for bend in (stood + run_up, stop - braking)]
            for time in sorted({begin, end, *(time for time in (*bends, *first.times) if begin < time < end)}):
                ahead, here = first.at(time), then.at(time)
                need = self.contact + min(braking, (here - stood) * brakes / gathers, stop - here)
                if time <= last and ahead - here < need - 10 * self.slack:
                    self.fault(time, f"robot {then.robot} drives {ahead - here:g} behind {first.robot}, not {need:g}")
                    return

    def drives_of(self, visit):
        """Yield the drives of a robot on an edge: begin, end, start, target, and its stands before and after."""
        pieces = self.pieces_of(visit)
        stands = [place for begin, end, place, to in pieces if to == place and end > begin + self.delay]
        stands += visit.places[-1:] if visit.cleared else []
        stands += visit.places[:1] if visit.stood else []
        for begin, end, place, to in pieces:
            if to > place:
                stood = max((stand for stand in stands if stand <= place), default=-self.run_before(visit))
                yield begin, end, place, to, stood, min((stand for stand in stands if stand >= to), default=math.inf)

    def pieces_of(self, visit):
        """Return the pieces of a visit as begin, end, start and target, with the stand at the end."""
        pieces = list(zip(visit.times, visit.times[1:], visit.places, visit.places[1:], strict=False))
        if visit.leave > visit.times[-1] + self.delay:
            pieces.append((visit.times[-1], visit.leave, visit.places[-1], visit.places[-1]))
        return pieces

    def run_before(self, visit):
        """Return how far a robot has driven since its last stand when it enters an edge, over several short edges."""
        visits = self.visits[visit.robot]
        index = next(i for i, other in enumerate(visits) if other is (visit.whole or visit))
        driven = 0.0
        for before in reversed(visits[:index]):
            if before.into_bay:
                return driven
            for begin, end, place, to in reversed(self.pieces_of(before)):
                if to == place and end > begin + self.delay:
                    return driven
                driven += to - place
            if driven > self.graph.edges[before.edge]["length"]:
                return driven
        return driven

    def in_ring(self, visit):
        """Whether the robot turned with a ring while it was on the edge, or as it came onto it."""
        begin = visit.enter - self.start_time - TOL
        return any(begin <= time <= visit.leave + TOL for time in self.trains[visit.robot])

    def check_stretches(self, robot, rows):
        """No drive from stand to stand is faster than possible."""
        gathers, brakes = self.robots[robot].motion
        state, since, pieces, place = "idle", 0.0, [], {}
        for time, kind, _, _, _, edge, value, *_ in rows:
            if kind == "enter":
                place = {edge: 0.0}
            elif kind == "drive":
                limit = min(self.speed_of(robot, state), self.graph.edges[edge]["speed"])
                begin = place.get(edge, self.started_at(robot, edge))
                if value > begin:
                    pieces.append((limit, value - begin))
                place[edge] = value
            elif kind in STATES | STANDS:
                state = kind
                if kind in STANDS and pieces:
                    together = [
                        (sum(length for _, length in some), limit)
                        for limit, some in groupby(pieces, key=lambda piece: piece[0])
                    ]
                    least = drive_time(together, 1 / gathers if gathers else 1e6, 1 / brakes if brakes else 1e6)
                    if time - since < least - 5 * TOL * (1 + least):
                        self.fault(time, f"robot {robot} takes {time - since:g} for a drive of at least {least:g}")
                if kind in STANDS or not pieces:
                    pieces, since = [], time

    def started_at(self, robot, edge):
        """Return the position of a robot on an edge at the start of the run."""
        places = self.run.model.fleet.start_on_lanes[robot : robot + 1]
        return next((place.offset for place in places if getattr(place, "edge", None) == edge), 0.0)
