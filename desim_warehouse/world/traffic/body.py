"""The state of a robot in traffic: its position, its commitments, and the robot it waits for."""

from __future__ import annotations

from functools import partial
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

from desim_warehouse.states import IN_LIFT
from desim_warehouse.world.traffic.drive import Drive
from desim_warehouse.world.traffic.events import Clock
from desim_warehouse.world.traffic.intersection import Claim, Intersection
from desim_warehouse.world.traffic.motion import LookAhead, Motion, NodeDelays, Stretch
from desim_warehouse.world.traffic.rulebook import Driver, NoDriver
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from desim_warehouse.world.traffic.closures import Closure
    from desim_warehouse.world.traffic.lane import Lane


class Delay(NamedTuple):
    """A wait known in advance: from `begin` to `end`, to keep the distance from a slower robot, `other`."""

    lane: Lane
    other: Body | None
    begin: float
    end: float

    @property
    def in_lift(self) -> bool:
        """Whether the wait is time at a lift rather than a collision."""
        return False


class LiftTime(Delay):
    """A wait for a lift's cabin at the end of a lane, or a ride along a lane: counted apart from collisions."""

    __slots__ = ()

    @property
    def in_lift(self) -> bool:
        """Return True: the wait is time at a lift."""
        return True


class Body:
    """A robot on the floor. Other objects read its attributes and change them only through its methods.

    The robot is in a bay (`lane` and `held` None, `at` its node), on a `lane`, or on an intersection. It has `held` the
    intersection since before it set out for it, from a bay or the end of its lane, together with room on the lane
    `granted`. It drives from `pos`, its latest known position, to `target`, which it can reach without another
    reservation, from `since` to `until`. `goal` is where it wants to go on this lane: its own stop or the stop line. It
    waits either for a `claim` or for the robot ahead on its lane (`waiting_behind`, the drive to resume), never for
    both.

    The robot sets out from a stop line onto its next lane at once: `out_at` and `out_pace` are when and how fast it
    passes the end of the lane before, `entered_at` is when it is on the new lane, `line_at` when it comes to the stop
    line. A `delay` is counted as soon as it is known. On a node it faces its next lane at `ready_at`. `limit` bounds
    its pace on its lane, `train_pace` that on the next, when it turns with a ring of slower robots. `stretch` is its
    drive since it last stood, or None if it accelerates and brakes instantly. `look_ahead` keeps its braking distance,
    which at its pace is `braking` (0 in a turning ring); if None, it keeps only D. Once it has begun to brake for its
    target it stands there, ready to go on, at `stands_at`. From `recall_at` on it stops at the next node. From
    `halts_at` on it breaks down at its next decision: at its target, on a node, or before it sets off. While `broken`
    it stands until it is repaired. `cleared`: it is off the lanes for a repair, or on its way back. `delays`: its
    delays at nodes. `waited` is its total waiting time in traffic, `waited_apart` the part for closures and people,
    which are no collisions. `encounters` counts episodes of waiting for people.
    """

    __slots__ = (
        "ahead",
        "at",
        "behind",
        "braking",
        "broken",
        "claim",
        "cleared",
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
        "line_at",
        "look_ahead",
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
        "stands_at",
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
        node: Intersection,
        driver: Driver | None = None,
        motion: Motion | None = None,
        delays: NodeDelays | None = None,
    ) -> None:
        self.number = number
        self.speed = self.pace = speed
        self.at = node
        self.driver = driver or NoDriver()
        self.task = -1
        # Drive
        self.stretch: Stretch | None = None if motion is None else Stretch(motion)
        self.lane: Any = None  # a Lane; typed loosely, as the hot path knows when it is set
        self.held: Any = None  # an Intersection
        self.granted: Lane | None = None
        self.ahead: Body | None = None
        self.behind: Body | None = None
        self.pos = self.target = self.goal = 0.0
        self.since = self.until = self.entered_at = self.out_at = self.line_at = self.ready_at = -inf
        self.out_pace = speed
        self.limit = self.train_pace = inf
        self.look_ahead: LookAhead | None = None
        self.braking = 0.0
        self.stands_at = -inf
        self.delays = delays
        self.detours = self.moves = 0
        self.driven = 0.0
        # Waits
        self.claim: Claim | None = None
        self.waiting_behind: Drive | None = None
        self.waiting_since = 0.0
        self.waits_for: Body | None = None
        self.delay: Delay | None = None
        self.rear_ends = self.crossings = self.encounters = 0
        self.waited = 0.0
        self.waited_apart: dict[str, float] = {}
        # Breakdowns, and recalls to a charger
        self.recall_at = self.halts_at = inf
        self.broken = self.cleared = False

    # Position

    def position(self, now: float) -> float:
        """Return the position of the robot on its lane."""
        if now >= self.until:
            return self.target
        return max(self.pos, self.target - (self.until - max(now, self.since)) * self.pace)

    def passes(self, position: float) -> float:
        """Return when the robot passes `position` on its lane, at most its target; possibly a past time."""
        if position <= self.pos:
            return self.since if position == self.pos else -inf
        return self.until - (self.target - position) / self.pace

    def distance(self, now: float) -> float:
        """Return the distance driven so far."""
        before = max(self.out_at - now, 0.0) * self.out_pace
        if self.stretch is not None and self.lane is not None:
            # The robot may still stand at the stop line, or be on its way to it.
            before = min(before, self.lane.headway + max(self.line_at - now, 0.0) * self.out_pace)
        return self.driven + self.position(now) - before

    def place(self, now: float) -> str:
        """Return where the robot is, in words."""
        if self.lane is None:
            return f"{'off the lanes' if self.cleared else 'in the bay'} at {self.at.name}"
        if self.held is not None and self.position(now) >= self.lane.length:
            return f"on node {self.lane.edge[1]}"
        return f"on edge {self.lane.edge[0]}>{self.lane.edge[1]} at {self.position(now):g}"

    # Entering and leaving lanes and nodes

    def begin_on_node(self, node: Intersection) -> None:
        """Stand on a node at the start of a run."""
        self.at = node

    def begin_on_lane(self, lane: Lane, ahead: Body | None, position: float) -> None:
        """Stand on a lane at the start of a run, last in its queue."""
        self._join(lane, ahead)
        self.pos = self.target = self.goal = position
        self.driven = -position
        self.take_pace_of(lane, 0.0)

    def take_pace_of(self, lane: Lane, time: float) -> None:
        """Set the pace on the lane being entered: the smallest of the robot's speed, the limit and its ring's pace.

        A ring keeps the pace at which it started, whatever limits apply meanwhile.
        """
        train = self.train_pace
        if train < inf:
            limit = self.limit = min(lane.limit, train)
        else:
            limit = self.limit = lane.limit_at(time) if lane.slow else lane.limit
        self.pace = min(self.speed, limit)
        if self.look_ahead is not None:
            self.limit = min(limit, self.look_ahead.limit_on(lane))
            self._take_pace()
        if train < inf:
            self.train_pace, self.braking = inf, 0.0

    def pace_on(self, lane: Lane, time: float) -> float:
        """Return the pace that the robot will have on a lane that it enters at a time."""
        pace = min(self.speed, lane.limit_at(time) if lane.slow else lane.limit, self.train_pace)
        return pace if self.look_ahead is None else min(pace, self.look_ahead.limit_on(lane))

    def _take_pace(self) -> None:
        self.pace = min(self.speed, self.limit)
        if self.look_ahead is not None:
            self.braking = self.look_ahead.distance(self.pace)

    def hold(self, node: Intersection, room: Lane | None) -> None:
        """Take an intersection granted to the robot, with room on the lane beyond."""
        self.held = node
        self.granted = room
        self.claim = None

    def give_up_room(self) -> None:
        """Give back the granted room on the next lane: the robot stays where it is, and leaves its ring, if any."""
        if self.granted is not None:
            self.granted.entering = None
            self.granted = None
        self.train_pace = inf

    def off_lane(self, out: float) -> None:
        """Leave the lane's queue, which closes the gap, and pass the lane's end at time `out`."""
        lane, front, behind = self.lane, self.ahead, self.behind
        self.driven += lane.length
        self.out_at = out
        self.out_pace = self.pace
        if lane.rules.exits_matter and out > lane.out_at:  # the last to pass counts
            lane.out_at = out
            lane.out_pace = self.pace
        if lane.zone_direction is not None and lane.rules.guard is not None:
            lane.rules.guard.leaves(self)
        if front is not None:  # in a rotation it may go before the robot ahead, which is on its node
            front.behind = behind
        if behind is None:
            lane.last = front
        else:
            behind.ahead = front
            self.behind = None

    def onto_lane(self, lane: Lane, ahead: Body | None, goal: float, target: float, since: float, until: float) -> None:
        """Enter the lane from the intersection at its start, last in its queue, and drive to the first target there."""
        self.lane = lane
        self.ahead = ahead
        self.held = self.granted = None
        self.goal = goal
        self.pos = 0.0
        self.target = target
        self.since = self.entered_at = since
        self.until = until
        self.moves += 1

    def onto_short_lane(self, lane: Lane, ahead: Body | None, since: float) -> None:
        """Enter a short lane from the node at its start at `since`, holding its end, without a target yet."""
        self._join(lane, ahead)
        self.pos = self.target = self.goal = 0.0
        self.entered_at = self.line_at = since
        self.moves += 1

    def leave_queue(self) -> None:
        """Leave the queue of the lane to stand beside it; the robot still counts as on the lane."""
        if self.ahead is not None:
            self.ahead.behind = self.behind
        if self.behind is not None:
            self.behind.ahead = self.ahead
        self.ahead = self.behind = None

    def queue_between(self, ahead: Body | None, behind: Body | None) -> None:
        """Return to the queue of the lane, between two other robots."""
        self.ahead, self.behind = ahead, behind
        if ahead is not None:
            ahead.behind = self
        if behind is not None:
            behind.ahead = self

    def be_on_lane_again(self, now: float) -> None:
        """Stand on the lane where the robot left it, with no farther goal yet."""
        self.goal = self.target = self.pos
        self.since = self.until = now

    def into_bay(self, node: Intersection) -> None:
        """Move from the held intersection into the bay or station beside it."""
        self.lane = self.held = self.ahead = None
        self.at = node
        self.pos = self.target = 0.0

    def _join(self, lane: Lane, ahead: Body | None) -> None:
        self.lane = lane
        self.ahead = ahead
        if ahead is not None:
            ahead.behind = self

    # Driving along a lane

    def head_for(self, goal: float) -> None:
        """Set the goal of the robot on its lane: its stop or the stop line."""
        self.goal = goal

    def drive_on(self, target: float, until: float) -> None:
        """Extend the drive to a further target without a stop."""
        self.target = target
        self.until = until

    def arrive(self) -> None:
        """Take the position of the target that the robot was sure to reach."""
        self.pos = self.target

    def arrive_on_node(self) -> None:
        """Stand on the node at the lane's end; without room granted beyond, the robot drives on at its own pace.

        The ring that may have brought it there goes on without it.
        """
        self.pos = self.target
        if self.granted is None:
            self.train_pace = inf

    def turn_on_node(self, time: float, now: float) -> None:
        """Turn to face the next lane within a time, standing; if there is nothing to turn, the robot need not stop."""
        self.ready_at = (self.brake_to_stand(now) if time else now) + time

    def turn_with_ring(self, pace: float) -> None:
        """Move with a ring of waiting robots on its lane and, if it leaves that, on the next."""
        self.pace = pace
        self.braking = 0.0
        if self.claim is not None:
            self.train_pace = pace

    def start_with_ring(self, time: float, stretch: Stretch) -> None:
        """Start at a given time with a ring, once the ring has braked and accelerated."""
        self.line_at = self.until
        self.until = time
        self.stretch = stretch

    # Tasks, recalls and repairs

    def work_on(self, task: int) -> None:
        """Attribute the drive from now on to a task, by its number in the log; -1: to none."""
        self.task = task

    def recall_from(self, time: float) -> None:
        """Recall the robot from a time on: it stops at the next node; inf: no recall."""
        self.recall_at = time

    def turn_off(self) -> None:
        """Leave the route for good at the next node."""
        self.recall_at = -inf

    @property
    def is_turned_off(self) -> bool:
        """Whether the robot has left its route for good, so that its driver must provide another."""
        return self.recall_at == -inf

    def break_down_at(self, time: float) -> None:
        """Let the robot break down at its first decision from a time on."""
        self.halts_at = time

    def break_down(self) -> None:
        """Begin a breakdown: the robot stands until it is repaired."""
        self.broken = True

    def be_cleared(self, node: Intersection) -> None:
        """Leave the lane's queue and the held node; from now on the robot is beside a node."""
        lane = self.lane
        if lane is not None:
            self.driven -= lane.length - self.pos
            self.off_lane(-inf)  # it has not passed the lane's end
        self.give_up_room()
        self.into_bay(node)
        self.cleared = True

    def come_back(self) -> None:
        """Return to a node after a repair off the lanes."""
        self.cleared = False

    def be_repaired(self) -> None:
        """End the breakdown: the robot works again."""
        self.broken = False

    def allow_detours(self, number: int) -> None:
        """Set how many detours the robot may take on the drive that begins."""
        self.detours = number

    def count_detour(self) -> None:
        """Count a detour that the robot takes."""
        self.detours -= 1

    # Acceleration and braking

    def change_speed(self, speed: float) -> None:
        """Change the speed from now on, while the robot stands: it has loaded or unloaded."""
        if speed != self.speed:
            self.speed = speed
            self._take_pace()

    @property
    def run_up(self) -> float:
        """Return the distance in which the robot accelerates from a stand to its speed."""
        assert self.stretch is not None
        return self.pace * self.pace * self.stretch.motion.gathers / 2

    def keep_braking_distance(self, env: Clock) -> None:
        """Look one braking distance ahead from now on, so that the robot can always stop before it may have to."""
        assert self.stretch is not None
        self.look_ahead = LookAhead(env, self, self.stretch.motion.brakes)

    def begin_to_brake(self) -> None:
        """Brake to a stand at the target, even if the robot could go on meanwhile."""
        assert self.stretch is not None
        braking, self.stretch = self.stretch.stopped
        self.stands_at = self.until + braking

    def going_on(self, now: float) -> tuple[float, Stretch]:
        """Return when a robot that may go on sets off, and its stretch then: if it had to stop, it brakes first."""
        assert self.stretch is not None
        if now > self.until + EPS:
            braking, anew = self.stretch.stopped
            return max(now, self.until + braking, self.stands_at), anew
        return max(now, self.until, self.stands_at), self.stretch

    def commit_stretch(self, stretch: Stretch) -> None:
        """Leave the lane by a stretch worked out before."""
        self.stretch = stretch
        if self.train_pace == inf:  # else the ring starts at `until`
            self.line_at = self.until

    def commit_length(self, length: float, now: float) -> float:
        """Commit to drive a further length on the lane, and return when the robot sets off."""
        begin, stretch = self.going_on(now)
        more, self.stretch = stretch.further(length, self.pace)
        return begin + more

    def commit_length_under_way(self, length: float) -> bool:
        """Commit to a further length at the present pace; returns False, without any change, if impossible."""
        if self.stretch is None:
            return True
        if self.stands_at >= self.until:  # it brakes for its target
            return False
        more, stretch = self.stretch.further(length, self.pace)
        if more > 0:
            return False
        self.stretch = stretch
        return True

    def put_off(self, time: float, pace: float) -> float:
        """Postpone the start by a time, and return the part of it that acceleration takes anyway."""
        if self.stretch is None:
            return 0.0
        part, self.stretch = self.stretch.later(time, pace)
        return part

    def start_at_pace(self, length: float) -> None:
        """Accelerate to the robot's pace from a stand while it waits to drive a length."""
        if self.stretch is not None:
            _, self.stretch = self.stretch.at_speed(self.pace).further(length, self.pace)

    def brake_to_stand(self, now: float) -> float:
        """Stop where the robot is, or is sure to get to, and return when it has braked."""
        if self.stretch is None:
            return now
        braking, self.stretch = self.stretch.stopped
        return max(now, self.until + braking, self.stands_at)

    @property
    def is_on_lanes(self) -> bool:
        """Whether the robot is on a lane or stands on a node."""
        return self.lane is not None or self.held is not None

    @property
    def is_at_lift(self) -> bool:
        """Whether the robot comes to a lift next, or is in its cabin: it goes on from there, even if recalled."""
        node = self.lane.end if self.lane is not None else self.held
        return node is not None and node.is_lift

    @property
    def time_left(self) -> float:
        """Return the time that the robot needs at its pace to the end of its lane."""
        lane = self.lane
        return 0.0 if lane is None else (lane.length - self.position(lane.rules.env.now)) / self.pace

    # Waiting

    @property
    def is_waiting(self) -> bool:
        """Whether the robot waits in traffic now."""
        return self.claim is not None or self.waiting_behind is not None

    @property
    def blocker(self) -> Body | None:
        """The robot that this one waits for; None if it is not blocked, or only waits for time to pass."""
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
        """Return the time waited in traffic so far, including the present episode."""
        waited = self.waited if self.delay is None else self.waited - self.delay_after(now)
        return waited + (now - self.waiting_since) if self.is_waiting else waited

    def waited_for(self, wait: str, now: float) -> float:
        """Return the time waited for closures of one kind, or at lifts, including the present episode.

        It is a part of `waited_by`.
        """
        waited = self.waited_apart.get(wait, 0.0)
        claim = self.claim
        if claim is not None and claim.because is not None and claim.because.wait == wait:
            waited += now - self.waiting_since
        if wait == IN_LIFT and self.delay is not None and self.delay.in_lift:
            waited -= self.delay_after(now)
        return waited

    def kept_out(self, closure: Closure, duration: float) -> None:
        """Count an episode of waiting for a closed lane, separately from collisions."""
        self.waited += duration
        self.waited_apart[closure.wait] = self.waited_apart.get(closure.wait, 0.0) + duration
        self.encounters += closure.is_person

    def uses_lift(self, lane: Lane, begin: float, end: float) -> None:
        """Note a wait for a cabin at the end of a lane, or a ride along a lane, from `begin` to `end`."""
        if end > begin:
            self.delay_is_known(LiftTime(lane, None, begin, end))
            self._log_lift(lane, end, end - begin)
            self.waited += end - begin
            self.waited_apart[IN_LIFT] = self.waited_apart.get(IN_LIFT, 0.0) + end - begin

    def _leave_out_of_lift(self, delay: Delay, now: float) -> None:
        """Deduct the rest of a delay at a lift that is not over when the run ends."""
        left = self.delay_after(now)
        self.waited -= left
        self.waited_apart[IN_LIFT] -= left
        if delay.begin < now - EPS:
            self._log_lift(delay.lane, now, now - delay.begin)

    def _log_lift(self, lane: Lane, end: float, duration: float) -> None:
        if lane.rules.log.everything:
            lane.rules.log.kept_out(end, self, IN_LIFT, lane.edge[1], lane.edge, duration)

    def delay_after(self, now: float) -> float:
        """Return the part of the robot's delay that is still to come."""
        delay = self.delay
        return 0.0 if delay is None or delay.end <= now else delay.end - max(delay.begin, now)

    def moves_by(self, now: float) -> int:
        """Return the number of lanes entered so far."""
        return self.moves - (self.entered_at > now)

    def rear_ends_by(self, now: float) -> int:
        """Return the number of episodes behind other robots that have ended."""
        return self.rear_ends - (self.delay is not None and self.delay.end > now and not self.delay.in_lift)

    def wait_for(self, claim: Claim, now: float) -> None:
        """Begin to wait for an intersection and room beyond it, until the claim is granted."""
        self.claim = claim
        self.waiting_since = now

    def resume(self) -> None:
        """End the wait for room on a lane, or beside it."""
        self.claim = None

    def waits_anew(self, now: float) -> None:
        """Begin a new episode of waiting, for something else."""
        self.waiting_since = now

    def count_wait_at_node(self, duration: float) -> None:
        """Count a finished episode of waiting before an intersection."""
        self.waited += duration
        self.crossings += 1

    def cut_wait_behind(self, left: float, *, begun: bool) -> None:
        """Cut an episode counted in advance that is not over when the run ends: its remainder does not count."""
        self.waited -= left
        self.rear_ends -= not begun

    def delay_is_known(self, delay: Delay) -> None:
        """Note a future wait behind a slower robot."""
        self.delay = delay
        self.driver.notice_delay(delay.begin, delay.end)

    def wait_behind(self, drive: Drive, now: float) -> None:
        """Wait until the robot ahead makes way: this robot then moves up, and `drive` goes on."""
        self.waiting_behind = drive
        self.waiting_since = now
        self.waits_for = self.ahead
        self.driver.notice_wait(waiting=True)

    def ride(self, since: float, until: float) -> None:
        """Stand in the cabin of a lift for the time of a ride."""
        self.since = since
        self.until = until

    def stop_waiting(self, now: float) -> Drive:
        """Stop waiting behind another robot, whose way is clear. The caller schedules the drive."""
        drive, self.waiting_behind = self.waiting_behind, None
        assert drive is not None
        self.driver.notice_wait(waiting=False)
        if now > self.waiting_since + EPS:
            self.lane.count_wait(self, self.waits_for, now - self.waiting_since, now)
        return drive

    def end_waits(self, now: float) -> None:
        """End the current episode at the end of a run; a future one does not begin."""
        if self.delay is not None and self.delay.end > now:
            cut = self._leave_out_of_lift if self.delay.in_lift else partial(self.delay.lane.cut_delay, self)
            cut(self.delay, now)
            self.delay = None
        if self.waiting_since >= now - EPS:
            return
        if self.claim is not None:
            node = self.claim.node
            node.count_claim(self.claim, node.holder, now)
        elif self.waiting_behind is not None:
            self.lane.count_wait(self, self.waits_for, now - self.waiting_since, now)
        self.waiting_since = now
