"""Where a robot is, what it has committed to, and whom it waits for: all that traffic knows of it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from desim_warehouse.world.traffic.motion import Stretch
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from simpy.events import Event

    from desim_warehouse.world.robots.breakdowns import NodeDelays
    from desim_warehouse.world.traffic.closures import Closure
    from desim_warehouse.world.traffic.drive import Drive
    from desim_warehouse.world.traffic.intersection import Claim, Intersection
    from desim_warehouse.world.traffic.lane import Lane
    from desim_warehouse.world.traffic.motion import Motion

    Steps = Generator[Event, object, None]


class Driver(Protocol):
    """Who decides for a body and learns what happens to it: a robot."""

    def left_bay(self) -> None:
        """It has just left the bay it stood in."""

    def detour(self, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:
        """Another route for a robot held up before `route[index]`, or None to wait. Asked while `detours` are left."""

    def stands(self, waiting: bool) -> None:
        """It begins (or ends) to wait in traffic."""

    def will_stand(self, begin: float, end: float) -> None:
        """It is known that it will wait in traffic from `begin` to `end`."""

    def halt(self) -> Steps:
        """A breakdown is due: the robot stands until it is repaired. It never breaks down in a bay."""


class NoDriver:
    """For bodies that only follow routes."""

    def left_bay(self) -> None:
        """Nothing to do."""

    def detour(self, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:  # noqa: ARG002
        """None: it waits."""
        return None

    def stands(self, waiting: bool) -> None:
        """Nothing to do."""

    def will_stand(self, begin: float, end: float) -> None:
        """Nothing to do."""

    def halt(self) -> Steps:
        """It never breaks down."""
        yield from ()


class Delay(NamedTuple):
    """A wait that is known beforehand: from `begin` to `end`, so as to come no nearer to a slower robot, `other`."""

    lane: Lane
    other: Body | None
    begin: float
    end: float


class Body:
    """A robot on the floor.

    It is in one of three positions: in a bay (`lane` None, `at` its node), on a lane (`held` None), or on an
    intersection that it holds, at the end of the lane that it came by. It drives from `pos`, where it looked last, to
    `target`, the position on the lane that it is sure to reach without another reservation. It sets off at `since` and
    is there at `until`. `goal` is where it wants to go on this lane: its own stop or the stop line.

    It waits in one of two ways: for an intersection and room beyond it (`claim`), or for the robot ahead on its lane
    (`waiting_behind`, the drive to go on with). Standing on an intersection it faces its next lane at `ready_at`.
    `waited` is all time waited in traffic, of it `waited_apart` for closures and people, which are no collisions.
    `encounters` counts episodes of waiting for people. `limit` bounds its pace on its lane, `train_pace` that on the
    next, when it turns with a ring of slower robots. When it sets out from a stop line it is on the next lane already,
    though it passes the end of the one before only at `out_at` (with `out_pace`), and enters the next at `entered_at`.
    A `delay` is counted when it becomes known. From `recall_at` on it is wanted elsewhere: it stops on the next node
    that it comes to. From `halts_at` on it breaks down at its next decision: at its target, on a node, or before it
    sets off. While `broken`, it stands until it is repaired. `delays`: those it has at nodes. `stretch` is what it has
    driven since it stood, where gathering speed and braking take time, else None.
    """

    __slots__ = (
        "ahead",
        "at",
        "behind",
        "broken",
        "claim",
        "crossings",
        "delay",
        "delays",
        "detours",
        "driven",
        "driver",
        "encounters",
        "entered_at",
        "goal",
        "granted",
        "halts_at",
        "held",
        "lane",
        "limit",
        "mark",
        "moves",
        "number",
        "out_at",
        "out_pace",
        "pace",
        "pos",
        "ready_at",
        "rear_ends",
        "recall_at",
        "since",
        "speed",
        "stretch",
        "target",
        "task",
        "train_pace",
        "until",
        "waited",
        "waited_apart",
        "waiting_behind",
        "waiting_since",
        "waits_for",
    )

    def __init__(
        self,
        number: int,
        speed: float,
        at: Intersection,
        driver: Driver | None = None,
        motion: Motion | None = None,
    ) -> None:
        self.number = number
        self.speed = self.pace = speed
        self.at = at
        self.driver = driver or NoDriver()
        self.stretch: Stretch | None = None if motion is None else Stretch(motion)
        self.lane: Any = None  # a Lane; typed loosely, as the hot path knows when there is one
        self.held: Any = None  # an Intersection
        self.granted: Lane | None = None
        self.ahead: Body | None = None
        self.behind: Body | None = None
        self.pos = self.target = self.goal = 0.0
        self.since = self.until = self.entered_at = self.out_at = -math.inf
        self.out_pace = speed
        self.claim: Claim | None = None
        self.waiting_behind: Drive | None = None
        self.waiting_since = 0.0
        self.waits_for: Body | None = None
        self.delay: Delay | None = None
        self.recall_at = self.halts_at = self.train_pace = self.limit = math.inf
        self.delays: NodeDelays | None = None
        self.broken = False
        self.ready_at = -math.inf
        self.mark = 0
        self.detours = 0
        self.task = -1
        self.moves = self.rear_ends = self.crossings = 0
        self.driven = self.waited = 0.0
        self.waited_apart: dict[str, float] = {}
        self.encounters = 0

    # Where it is

    def position(self, now: float) -> float:
        """Where it is on its lane."""
        if now >= self.until:
            return self.target
        return max(self.pos, self.target - (self.until - max(now, self.since)) * self.pace)

    def passes(self, position: float) -> float:
        """The time at which it passes `position` on its lane, no farther than its target, or a past time."""
        if position <= self.pos:
            return self.since if position == self.pos else -math.inf
        return self.until - (self.target - position) / self.pace

    def distance(self, now: float) -> float:
        """Length driven so far."""
        before = max(self.out_at - now, 0.0) * self.out_pace
        if self.stretch is not None and self.lane is not None:
            before = min(before, self.lane.headway)  # it may stand at the stop line still
        return self.driven + self.position(now) - before

    def place(self, now: float) -> str:
        """Where it is, in words."""
        if self.lane is None:
            return f"in the bay at {self.at.name}"
        if self.held is not None and self.position(now) >= self.lane.length:
            return f"on node {self.lane.edge[1]}"
        return f"on edge {self.lane.edge[0]}>{self.lane.edge[1]} at {self.position(now):g}"

    def pace_on(self, lane: Lane) -> float:
        """Its own speed, the lane's limit, or the pace of the ring that it turns with: the smallest of them."""
        train, self.train_pace = self.train_pace, math.inf
        self.limit = min(lane.limit, train)
        return min(self.speed, self.limit)

    # Gathering speed and braking

    def change_speed(self, speed: float) -> None:
        """Standing, it has loaded or unloaded, and drives at another speed from now on."""
        if speed != self.speed:
            self.speed = speed
            self.pace = min(speed, self.limit)

    def going_on(self, now: float) -> tuple[float, Stretch]:
        """When a robot that may go on now does, and its stretch then: if it had to stop it has braked first."""
        assert self.stretch is not None
        if now > self.until + EPS:
            return max(now, self.until + self.stretch.braking), self.stretch.anew()
        return max(now, self.until), self.stretch

    def sets_off(self, length: float, now: float) -> float:
        """When it sets off over a further length on its lane that it may drive now."""
        begin, stretch = self.going_on(now)
        more, self.stretch = stretch.further(length, self.pace)
        return begin + more

    def keeps_pace(self, length: float) -> bool:
        """Whether a robot under way drives on over a further length as fast as it does now."""
        if self.stretch is None:
            return True
        more, stretch = self.stretch.further(length, self.pace)
        if more > 0:
            return False
        self.stretch = stretch
        return True

    def stands(self, now: float) -> float:
        """When a robot that stops where it is, or is sure to get to, has braked."""
        if self.stretch is None:
            return now
        braked = max(now, self.until + self.stretch.braking)
        self.stretch = self.stretch.anew()
        return braked

    @property
    def is_on_lanes(self) -> bool:
        """Whether it is on a lane or stands on a node."""
        return self.lane is not None or self.held is not None

    # Waiting

    @property
    def is_waiting(self) -> bool:
        """Whether it waits in traffic now."""
        return self.claim is not None or self.waiting_behind is not None

    @property
    def blocker(self) -> Body | None:
        """The one robot that it waits for, or None if it is not blocked or only waits for time to pass."""
        if self.waiting_behind is not None:
            return self.ahead
        claim = self.claim
        if claim is None or claim.shut_by is not None:
            return None
        holder = claim.node.holder
        if holder is not None and holder is not self:
            return holder
        lane = claim.lane
        if lane is None or lane.entering is not None or lane.last is None or lane.has_room(self):
            return None
        return lane.last

    def waited_by(self, now: float) -> float:
        """Time waited in traffic so far, the present episode included."""
        waited = self.waited if self.delay is None else self.waited - self.delay_after(now)
        return waited + (now - self.waiting_since) if self.is_waiting else waited

    def waited_for(self, wait: str, now: float) -> float:
        """Time waited for closures of one kind so far, which is a part of `waited_by`, the present episode included."""
        waited = self.waited_apart.get(wait, 0.0)
        claim = self.claim
        if claim is not None and claim.because is not None and claim.because.wait == wait:
            waited += now - self.waiting_since
        return waited

    def kept_out(self, closure: Closure, duration: float) -> None:
        """An episode of waiting for a lane that was closed as it began: no collision, and counted apart."""
        self.waited += duration
        self.waited_apart[closure.wait] = self.waited_apart.get(closure.wait, 0.0) + duration
        self.encounters += closure.is_person

    def delay_after(self, now: float) -> float:
        """The part of its delay that is still to come."""
        delay = self.delay
        return 0.0 if delay is None or delay.end <= now else delay.end - max(delay.begin, now)

    def moves_by(self, now: float) -> int:
        """Lanes entered so far."""
        return self.moves - (self.entered_at > now)

    def rear_ends_by(self, now: float) -> int:
        """Episodes behind other robots that have ended."""
        return self.rear_ends - (self.delay is not None and self.delay.end > now)

    def wait_behind(self, drive: Drive, now: float) -> None:
        """Wait until the robot ahead makes way: `drive` goes on when this one has then moved up."""
        self.waiting_behind = drive
        self.waiting_since = now
        self.waits_for = self.ahead
        self.driver.stands(waiting=True)

    def stop_waiting(self, now: float) -> Drive:
        """It has waited behind another and may go on. The caller says when its drive is due."""
        drive, self.waiting_behind = self.waiting_behind, None
        assert drive is not None
        self.driver.stands(waiting=False)
        if now > self.waiting_since + EPS:
            self.lane.count_wait(self, self.waits_for, now - self.waiting_since, now)
        return drive

    def end_waits(self, now: float) -> None:
        """At the end of a run: the episode that is under way ends here, and one that was to come does not begin."""
        if self.delay is not None and self.delay.end > now:
            self.delay.lane.cut_delay(self, self.delay, now)
            self.delay = None
        if self.waiting_since >= now - EPS:
            return
        if self.claim is not None:
            node = self.claim.node
            node.count_claim(self.claim, node.holder, now - self.waiting_since, now)
        elif self.waiting_behind is not None:
            self.lane.count_wait(self, self.waits_for, now - self.waiting_since, now)
        self.waiting_since = now
