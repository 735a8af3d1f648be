"""Where a robot is, what it has committed to, and whom it waits for: all that traffic knows of it."""

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
    """A wait that is known beforehand: from `begin` to `end`, so as to come no nearer to a slower robot, `other`."""

    lane: Lane
    other: Body | None
    begin: float
    end: float

    @property
    def in_lift(self) -> bool:
        """Whether the wait is time at a lift, and no collision."""
        return False


class LiftTime(Delay):
    """A wait for the cabin of a lift at the end of a lane, or a ride along one: no collision, and counted apart."""

    __slots__ = ()

    @property
    def in_lift(self) -> bool:
        """Return True: the wait is time at a lift."""
        return True


class Body:
    """A robot on the floor. What happens to it is one of its verbs: others read its fields, and do not set them.

    It is in a bay (`lane` and `held` None, `at` its node), on a `lane`, or on an intersection that it has `held` since
    before it set out for it: out of a bay, or at the end of its lane. With that it has room on the lane `granted`.
    It drives from `pos`, where it looked last, to `target`, which it is sure to reach without another reservation:
    from `since` to `until`. `goal` is where it wants to go on this lane: its own stop or the stop line.
    It waits for a `claim`, or for the robot ahead on its lane (`waiting_behind`, the drive to go on with), never both.

    It sets out from a stop line on its next lane at once: `out_at`, `out_pace` say when and how fast it passes the end
    of the one before, `entered_at` when it is really there, and `line_at` when it comes to the stop line. A `delay` is
    counted when it becomes known. On a node it faces its next lane at `ready_at`.
    `limit` bounds its pace on its lane, `train_pace` that on the next, when it turns with a ring of slower robots.
    `stretch` is what it has driven since it stood, or None if it gathers speed and brakes in no time.
    `look_ahead` keeps its braking distance, `braking` at its pace (0 in a ring that turns). None: it keeps only D. Once
    it has begun to brake for its target it stands there, and can go on, at `stands_at`.
    From `recall_at` on it stops at the next node. From `halts_at` on it breaks down at its next decision: at its
    target, on a node, or before it sets off. While `broken`, it stands until it is repaired. `cleared`: it is off the
    lanes for a repair, or comes back from it. `delays`: those at nodes.
    `waited` is all time waited in traffic, of it `waited_apart` for closures and people, which are no collisions.
    `encounters` counts episodes of waiting for people.
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
        # Of its drive
        self.stretch: Stretch | None = None if motion is None else Stretch(motion)
        self.lane: Any = None  # a Lane; typed loosely, as the hot path knows when there is one
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
        # Of its waits
        self.claim: Claim | None = None
        self.waiting_behind: Drive | None = None
        self.waiting_since = 0.0
        self.waits_for: Body | None = None
        self.delay: Delay | None = None
        self.rear_ends = self.crossings = self.encounters = 0
        self.waited = 0.0
        self.waited_apart: dict[str, float] = {}
        # Of a breakdown, and a call back to a charger
        self.recall_at = self.halts_at = inf
        self.broken = self.cleared = False

    # Where it is

    def position(self, now: float) -> float:
        """Return the position of the robot on its lane."""
        if now >= self.until:
            return self.target
        return max(self.pos, self.target - (self.until - max(now, self.since)) * self.pace)

    def passes(self, position: float) -> float:
        """Return when the robot passes `position` on its lane, no farther than its target, or a past time."""
        if position <= self.pos:
            return self.since if position == self.pos else -inf
        return self.until - (self.target - position) / self.pace

    def distance(self, now: float) -> float:
        """Return the length driven so far."""
        before = max(self.out_at - now, 0.0) * self.out_pace
        if self.stretch is not None and self.lane is not None:
            # It may stand at the stop line still, or be on its way there.
            before = min(before, self.lane.headway + max(self.line_at - now, 0.0) * self.out_pace)
        return self.driven + self.position(now) - before

    def place(self, now: float) -> str:
        """Return where the robot is, in words."""
        if self.lane is None:
            return f"{'off the lanes' if self.cleared else 'in the bay'} at {self.at.name}"
        if self.held is not None and self.position(now) >= self.lane.length:
            return f"on node {self.lane.edge[1]}"
        return f"on edge {self.lane.edge[0]}>{self.lane.edge[1]} at {self.position(now):g}"

    # Onto lanes and nodes, and off them

    def begin_on_node(self, node: Intersection) -> None:
        """Stand on a node at the start of a run."""
        self.at = node

    def begin_on_lane(self, lane: Lane, ahead: Body | None, position: float) -> None:
        """Stand on a lane at the start of a run, as the last of its queue."""
        self._join(lane, ahead)
        self.pos = self.target = self.goal = position
        self.driven = -position
        self.take_pace_of(lane, 0.0)

    def take_pace_of(self, lane: Lane, time: float) -> None:
        """Set the robot's pace on a lane that it enters: the smallest of its speed, the limit, and its ring's pace.

        A ring turns as it started, whatever limits hold meanwhile.
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
        """Take an intersection that the robot is granted, with room on the lane beyond."""
        self.held = node
        self.granted = room
        self.claim = None

    def give_up_room(self) -> None:
        """Give back the room on the next lane that the robot was granted: it stays where it is."""
        if self.granted is not None:
            self.granted.entering = None
            self.granted = None

    def off_lane(self, out: float) -> None:
        """Leave the lane's queue, where the gap closes, and pass the lane's end at the time `out`."""
        lane, front, behind = self.lane, self.ahead, self.behind
        self.driven += lane.length
        self.out_at = out
        self.out_pace = self.pace
        if lane.rules.exits_matter and out > lane.out_at:  # the last to pass it counts
            lane.out_at = out
            lane.out_pace = self.pace
        if front is not None:  # in a rotation it may go before the robot ahead, which is on its node
            front.behind = behind
        if behind is None:
            lane.last = front
        else:
            behind.ahead = front
            self.behind = None

    def onto_lane(self, lane: Lane, ahead: Body | None, goal: float, target: float, since: float, until: float) -> None:
        """Go from the intersection at the lane's start, as the last of its queue, on to its first target there."""
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
        """Go from the node at its start, holding its end, at `since`; it has committed to no target yet."""
        self._join(lane, ahead)
        self.pos = self.target = self.goal = 0.0
        self.entered_at = self.line_at = since
        self.moves += 1

    def leave_queue(self) -> None:
        """Leave the queue of the lane to stand beside it; the robot counts as on the lane still."""
        if self.ahead is not None:
            self.ahead.behind = self.behind
        if self.behind is not None:
            self.behind.ahead = self.ahead
        self.ahead = self.behind = None

    def queue_between(self, ahead: Body | None, behind: Body | None) -> None:
        """Stand in the queue of the lane again, between two other robots."""
        self.ahead, self.behind = ahead, behind
        if ahead is not None:
            ahead.behind = self
        if behind is not None:
            behind.ahead = self

    def be_on_lane_again(self, now: float) -> None:
        """Stand on the lane where the robot left it, and want to go no farther yet."""
        self.goal = self.target = self.pos
        self.since = self.until = now

    def into_bay(self, node: Intersection) -> None:
        """Go from the intersection that it held into the bay or station beside it."""
        self.lane = self.held = self.ahead = None
        self.at = node
        self.pos = self.target = 0.0
        self.train_pace = inf  # it leaves its ring, if it came in with one

    def _join(self, lane: Lane, ahead: Body | None) -> None:
        self.lane = lane
        self.ahead = ahead
        if ahead is not None:
            ahead.behind = self

    # Along a lane

    def head_for(self, goal: float) -> None:
        """Set the goal of the robot on its lane: its stop or the stop line."""
        self.goal = goal

    def drive_on(self, target: float, until: float) -> None:
        """Go on under way to a further target, without a stop."""
        self.target = target
        self.until = until

    def arrive(self) -> None:
        """Be at the target that the robot was sure to reach."""
        self.pos = self.target

    def turn_on_node(self, time: float, now: float) -> None:
        """Turn to face the next lane within a time, standing; without a turn the robot need not stop."""
        self.ready_at = (self.brake_to_stand(now) if time else now) + time

    def turn_with_ring(self, pace: float) -> None:
        """Move with a ring of waiting robots, on its lane and, if it leaves that, on the next."""
        self.pace = pace
        self.braking = 0.0
        if self.claim is not None:
            self.train_pace = pace

    def start_with_ring(self, time: float, stretch: Stretch) -> None:
        """Start at a time with a ring that has braked and gathered speed."""
        self.line_at = self.until
        self.until = time
        self.stretch = stretch

    # What it is wanted for

    def work_on(self, task: int) -> None:
        """Drive from now on for a task, which rows of the log name; -1: for none."""
        self.task = task

    def recall_from(self, time: float) -> None:
        """Have the robot stop at the next node from a time on; inf: not at all."""
        self.recall_at = time

    def turn_off(self) -> None:
        """Leave the route for good, at the node that the robot comes to next."""
        self.recall_at = -inf

    @property
    def is_turned_off(self) -> bool:
        """Whether the robot has left its route for good, and its driver knows another."""
        return self.recall_at == -inf

    def break_down_at(self, time: float) -> None:
        """Have the robot break down at its next decision from a time on."""
        self.halts_at = time

    def break_down(self) -> None:
        """Begin to stand broken down, until the robot is repaired."""
        self.broken = True

    def be_cleared(self, node: Intersection) -> None:
        """Leave the lane's queue and the node that the robot held; it is beside a node from now on."""
        lane = self.lane
        if lane is not None:
            self.driven -= lane.length - self.pos
            self.off_lane(-inf)  # it has not passed the lane's end
        self.give_up_room()
        self.into_bay(node)
        self.cleared = True

    def come_back(self) -> None:
        """Stand on a node again, after a repair off the lanes."""
        self.cleared = False

    def be_repaired(self) -> None:
        """End the breakdown: the robot works again."""
        self.broken = False

    def allow_detours(self, number: int) -> None:
        """Allow so many detours on the drive that begins."""
        self.detours = number

    def count_detour(self) -> None:
        """Count a detour that the robot takes."""
        self.detours -= 1

    # Gathering speed and braking

    def change_speed(self, speed: float) -> None:
        """Drive at another speed from now on: standing, it has loaded or unloaded."""
        if speed != self.speed:
            self.speed = speed
            self._take_pace()

    @property
    def run_up(self) -> float:
        """Return the length over which the robot gathers its speed from a stand."""
        assert self.stretch is not None
        return self.pace * self.pace * self.stretch.motion.gathers / 2

    def keep_braking_distance(self, env: Clock) -> None:
        """Make the robot look its braking distance ahead, so that it can always stop before it may have to."""
        assert self.stretch is not None
        self.look_ahead = LookAhead(env, self, self.stretch.motion.brakes)

    def begin_to_brake(self) -> None:
        """Brake to a stand at its target, even if it could go on meanwhile."""
        assert self.stretch is not None
        braking, self.stretch = self.stretch.stopped
        self.stands_at = self.until + braking

    def going_on(self, now: float) -> tuple[float, Stretch]:
        """Return when a robot that may go on now does, and its stretch then: if it had to stop it has braked first."""
        assert self.stretch is not None
        if now > self.until + EPS:
            braking, anew = self.stretch.stopped
            return max(now, self.until + braking, self.stands_at), anew
        return max(now, self.until, self.stands_at), self.stretch

    def commit_stretch(self, stretch: Stretch) -> None:
        """Leave the lane by a stretch that was worked out before."""
        self.stretch = stretch
        if self.train_pace == inf:  # else the ring starts at `until`
            self.line_at = self.until

    def commit_length(self, length: float, now: float) -> float:
        """Drive a further length on its lane, and return when it sets off."""
        begin, stretch = self.going_on(now)
        more, self.stretch = stretch.further(length, self.pace)
        return begin + more

    def commit_length_under_way(self, length: float) -> bool:
        """Drive a further length as fast as now, under way; False: not possible, and nothing has changed."""
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
        """Start later by a time, and return the part of it that gathering speed takes anyway."""
        if self.stretch is None:
            return 0.0
        part, self.stretch = self.stretch.later(time, pace)
        return part

    def start_at_pace(self, length: float) -> None:
        """Gather the robot's pace from a stand while it waits to drive a length."""
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
        at = self.lane.end if self.lane is not None else self.held
        return at is not None and at.is_lift

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
        """Return the time waited in traffic so far, the present episode included."""
        waited = self.waited if self.delay is None else self.waited - self.delay_after(now)
        return waited + (now - self.waiting_since) if self.is_waiting else waited

    def waited_for(self, wait: str, now: float) -> float:
        """Return the time waited for closures of one kind, or at lifts, the present episode included.

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
        """Count an episode of waiting for a lane that was closed: no collision, and counted apart."""
        self.waited += duration
        self.waited_apart[closure.wait] = self.waited_apart.get(closure.wait, 0.0) + duration
        self.encounters += closure.is_person

    def uses_lift(self, lane: Lane, begin: float, end: float) -> None:
        """Note a wait for a cabin at the end of a lane, or a ride along one, from `begin` to `end`."""
        if end > begin:
            self.delay_is_known(LiftTime(lane, None, begin, end))
            self._log_lift(lane, end, end - begin)
            self.waited += end - begin
            self.waited_apart[IN_LIFT] = self.waited_apart.get(IN_LIFT, 0.0) + end - begin

    def _leave_out_of_lift(self, delay: Delay, now: float) -> None:
        """Take the rest of a delay at a lift off the counts, as the run ends before the robot is through."""
        left = self.delay_after(now)
        self.waited -= left
        self.waited_apart[IN_LIFT] -= left
        if delay.begin < now - EPS:
            self._log_lift(delay.lane, now, now - delay.begin)

    def _log_lift(self, lane: Lane, end: float, duration: float) -> None:
        if lane.rules.log.everything:
            lane.rules.log.kept_out(end, self, IN_LIFT, lane.edge[1], lane.edge, duration)

    def delay_after(self, now: float) -> float:
        """Return the part of its delay that is still to come."""
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
        """End the wait for room beside a lane, or on it."""
        self.claim = None

    def waits_anew(self, now: float) -> None:
        """Begin a new episode of waiting, for something else."""
        self.waiting_since = now

    def count_wait_at_node(self, duration: float) -> None:
        """Count an episode of waiting before an intersection that is over."""
        self.waited += duration
        self.crossings += 1

    def cut_wait_behind(self, left: float, *, begun: bool) -> None:
        """Cut an episode that was known and is not over when the run ends: what is left of it does not count."""
        self.waited -= left
        self.rear_ends -= not begun

    def delay_is_known(self, delay: Delay) -> None:
        """Note a wait behind a slower robot that is to come."""
        self.delay = delay
        self.driver.notice_delay(delay.begin, delay.end)

    def wait_behind(self, drive: Drive, now: float) -> None:
        """Wait until the robot ahead makes way: `drive` goes on when this one has then moved up."""
        self.waiting_behind = drive
        self.waiting_since = now
        self.waits_for = self.ahead
        self.driver.notice_wait(waiting=True)

    def ride(self, since: float, until: float) -> None:
        """Stand in the cabin of a lift, which carries the robot, for a time."""
        self.since = since
        self.until = until

    def stop_waiting(self, now: float) -> Drive:
        """Stop waiting behind another, as it may go on. The caller says when its drive is due."""
        drive, self.waiting_behind = self.waiting_behind, None
        assert drive is not None
        self.driver.notice_wait(waiting=False)
        if now > self.waiting_since + EPS:
            self.lane.count_wait(self, self.waits_for, now - self.waiting_since, now)
        return drive

    def end_waits(self, now: float) -> None:
        """End, at the end of a run, the episode that is under way; one that was to come does not begin."""
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
