"""The part of the auditor for lifts: one robot rides at a time, and no cabin is faster than it can be.

The cabin is followed from passage to passage: from where the last robot got out, from where it rests, or on its way
there. If rings turn, it may have come earlier, but not before it was free. People and repairs have it in between, as
logged, one after the other, and never while a robot has it.
"""

import math
from dataclasses import dataclass
from itertools import pairwise, takewhile

from desim_warehouse.states import BROKEN, STATES
from tests.audit_nodes import Stay


@dataclass
class Passage:
    """The use of a lift by a robot: it calls the cabin to `node` at `called`, drives in at `start`, rides, gets out.

    If doors take no time, two consecutive rides take as long as one, and a route may have either.
    """

    robot: int
    node: str
    called: float
    start: float
    rides: list
    out: object


def ride_times(ride):
    """Return when a ride begins and ends; inf if it had not begun when the run ended."""
    return ride.times[1:3] if len(ride.times) > 1 else (math.inf, math.inf)


class Lifts:
    """Checks of lifts, for `Audit`."""

    def check_lifts(self):
        for lift in self.run.layout.lifts:
            name = lift.name
            passages = sorted(self.passages_of(name, lift), key=lambda passage: (passage.start, passage.called))
            for passage in passages:
                for ride in passage.rides:
                    self.check_ride(name, lift, ride)
                self.check_way_out(name, passage)
            self.check_cabin(name, lift, passages)

    def passages_of(self, name, lift):
        """Yield the passage of every robot that drove into the cabin, by its visits and the rows of its waits."""
        calls = [row for row in self.run.record.rows if row[1] == "in_lift" and row[5][1] in lift.nodes]
        causes = {"collision", "waiting_closed", "waiting_person"}
        waits = [row for row in self.run.record.rows if row[1] in causes and row[4] in lift.nodes]
        for robot, visits in self.visits.items():
            for rank, visit in enumerate(visits[:-1]):
                if visit.edge[1] not in lift.nodes or visit.edge[0] in lift.nodes or visit.cleared:
                    continue
                start, later = self.sets_out(visit), visits[rank + 1 :]
                rides = list(takewhile(lambda ride: {*ride.edge} <= {*lift.nodes}, later))
                if not rides:
                    self.fault(later[0].enter, f"robot {robot} drove through lift {name} on one floor")
                    continue
                early, late = visit.enter - self.delay, start + self.delay
                began = [row[0] - row[6] for row in calls if row[2] == robot and row[5] == visit.edge]
                held_up = [row[0] for row in waits if row[2] == robot and early <= row[0] <= late]
                line = self.length(visit) - self.contact - self.slack
                line_since = next((t for t, p in zip(visit.times, visit.places, strict=True) if p >= line), start)
                repaired = [time for time in self.repairs(robot) if early <= time <= late]
                at_line = max([line_since, *held_up, *repaired])
                called = next((time for time in began if early <= time <= late), min(at_line, start))
                out = later[len(rides)] if len(rides) < len(later) else None
                yield Passage(robot, visit.edge[1], called, start, rides, out)

    def repairs(self, robot):
        """Return the times at which a robot continued after its breakdowns."""
        states = [(row[0], row[1]) for row in self.run.record.rows if row[2] == robot and row[1] in STATES]
        return [then for (_, state), (then, _) in pairwise(states) if state in BROKEN]

    def check_ride(self, name, lift, ride):
        """A ride takes as long as doors and cabin take."""
        begin, until = ride_times(ride)
        takes = 2 * lift.doors + lift.ride * abs(lift.nodes.index(ride.edge[0]) - lift.nodes.index(ride.edge[1]))
        if math.isfinite(until) and abs(until - begin - takes) > self.delay:
            self.fault(begin, f"robot {ride.robot} rides in lift {name} for {until - begin:g}, not {takes:g}")

    def check_way_out(self, name, passage):
        """Each ride begins where the previous ride ended, not before, and the robot gets out at the last stop."""
        for ride, then in pairwise([*passage.rides, *([passage.out] if passage.out else [])]):
            if then.edge[0] != ride.edge[1] or then.enter < ride_times(ride)[1] - self.delay:
                self.fault(then.enter, f"robot {passage.robot} left lift {name} before it was there")

    def users_of(self, lift):
        """Yield uses by people and repairs, in order of time: begin, end, last node, least duration, and wait."""
        for begin, kind, _, _, node, edge, waited, until, _ in self.run.record.rows:
            if kind == "lift_fails" and node in lift.nodes:
                yield begin, until, lift.rests or node, 0.0, 0.0
            elif kind == "person_rides" and node in lift.nodes:
                way = abs(lift.nodes.index(edge[0]) - lift.nodes.index(edge[1])) * lift.ride
                yield begin, until, edge[1], way + 4 * lift.doors, waited

    def check_users(self, name, lift, after, before, users, floor):
        """Replay uses by people and repairs up to a call; return the floor of the cabin, and when it was free."""
        while users and users[0][0] < before:
            begin, until, node, least, waited = users.pop(0)
            if begin < after - self.delay or waited < 0 or until - begin < least - self.delay:
                self.fault(begin, f"others have lift {name} from {begin:g} to {until:g}, free at {after:g}")
            floor, after = float(lift.nodes.index(node)), until
        return floor, after

    def check_cabin(self, name, lift, passages):
        """The cabin is called when it is free, comes from where it is, and serves one robot at a time."""
        floor, free, rings = float(lift.nodes.index(lift.rests or lift.nodes[0])), -math.inf, self.run.record.rings
        users = list(self.users_of(lift))
        for passage in passages:
            floor, called = self.check_users(name, lift, free, passage.start, users, floor)
            others, free = called > free, called
            to = lift.nodes.index(passage.node)
            early = passage.called - self.start_time - self.delay
            in_ring = any(early <= time <= passage.called + self.delay for time in self.trains[passage.robot])
            if passage.called < free - self.delay and not in_ring and not others:
                self.fault(passage.called, f"robot {passage.robot} calls lift {name}, which is free at {free:g}")
            begin = max(passage.called, free)
            rests = floor if lift.rests is None else lift.nodes.index(lift.rests)
            at = floor + math.copysign(min((begin - free) / lift.ride, abs(rests - floor)), rests - floor)
            ready = begin + abs(to - at) * lift.ride + lift.doors
            if rings and to == floor and in_ring:  # as one robot gets out, the next gets in
                ready = passage.called
            elif rings:
                ready = min(ready, max(free, 0.0) + min(abs(to - floor), abs(to - rests)) * lift.ride + lift.doors)
            if passage.start < ready - self.delay:
                self.fault(
                    passage.start, f"lift {name} is at {passage.node} for robot {passage.robot}, not before {ready:g}"
                )
            floor, free = float(lift.nodes.index(passage.rides[-1].edge[1])), math.inf
            if passage.out is not None:
                free = self.clear(Stay(left=passage.out.enter, away=passage.out)) + lift.doors
        self.check_users(name, lift, free, math.inf, users, floor)
