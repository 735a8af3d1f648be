"""The part of the auditor that looks at speeds: no robot exceeds what it can reach by accelerating and braking.

Between two instants at which a robot stands for certain (it loads, unloads, is in a bay or station) it takes at least
the time of the fastest drive over what it has driven, from a stand to a stand.
"""

from __future__ import annotations

import math
from itertools import groupby

from tests.audit_work import STATES
from tests.world.closed_form import drive_time

TOL = 1e-6
STANDS = {"loading", "unloading", "parked", "docked", "cleared"}


class Motion:
    """Checks of how fast robots drive, for `Audit`."""

    def speed_of(self, robot, state):
        """Its speed on the way in a state."""
        spec = self.robots[robot]
        return spec.loaded_speed if state == "loaded" else spec.speed

    def start_time(self):
        """The most that gathering speed takes, and braking: what the robots of a ring wait for each other."""
        fastest = max(self.speed_of(i, state) for i in range(len(self.robots)) for state in ("loaded", "empty"))
        return fastest * (max(one.motion[0] for one in self.robots) + max(one.motion[1] for one in self.robots)) / 2

    def check_motion(self):
        if not any(any(one.motion) for one in self.robots):
            return
        rows = sorted(self.run.record.rows, key=lambda row: (row[2], row[0]))
        for robot, mine in groupby(rows, key=lambda row: row[2]):
            if robot >= 0:
                self.check_stretches(robot, mine)

    def check_braking(self, first, then):
        """On one edge `then` can stop D behind `first` at any time, if it keeps its braking distance.

        A ring of robots turns as one, D apart.
        """
        robot = self.robots[then.robot]
        if robot.keeps != "braking" or self.in_ring(then) or self.in_ring(first):
            return
        brakes = robot.motion[1]
        pieces = list(zip(then.times, then.places, then.times[1:], then.places[1:], strict=False))
        stop = math.inf
        for begin, place, end, to in reversed(pieces):
            if to <= place + self.slack:  # it stands
                stop = to if end > begin + self.delay else stop
                continue
            pace = (to - place) / (end - begin)
            braking = pace * pace * brakes / 2
            if end == then.times[-1] and then.leave > end + self.delay:  # it stands there, or was cleared off the edge
                stop = min(stop, to)
            moments = {begin, end, *(time for time in first.times if begin < time < end)}
            if place < stop - braking < to:
                moments.add(begin + (stop - braking - place) / pace)
            for time in sorted(moments):
                ahead, here = first.at(time), then.at(time)
                need = self.contact + min(braking, stop - here)
                if time <= min(first.leave, then.leave) and ahead - here < need - 10 * self.slack:
                    self.fault(time, f"robot {then.robot} drives {ahead - here:g} behind {first.robot}, not {need:g}")
                    return

    def in_ring(self, visit):
        """Whether a ring turned with the robot while it was on the edge, or came to it."""
        begin = visit.enter - self.start_time() - TOL
        return any(begin <= time <= visit.leave + TOL for time in self.trains[visit.robot])

    def check_stretches(self, robot, rows):
        """From stand to stand, each as long as it takes at least."""
        gathers, brakes = self.robots[robot].motion
        state, since, pieces, place = "idle", 0.0, [], {}
        for time, kind, _, _, _, edge, value, _, _ in rows:
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
        """Where it stood on an edge at the start of the run."""
        places = self.run.model.fleet.start_on_lanes[robot : robot + 1]
        return next((place.offset for place in places if getattr(place, "edge", None) == edge), 0.0)
