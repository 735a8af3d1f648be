"""A lane: the one-way edge between two intersections, its queue of robots, and the room on it.

A robot commits to a target on its lane that keeps it a headway behind the target of the robot ahead and drives there.
Nothing polls: when a robot makes way, those behind move up at once, down the queue, and at the lane's start the
intersection decides which robot gets the room (`Intersection.serve`).

The headway is D, the same for all robots (that of the largest pair), so that in a ring each can take any other's
position.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from desim_warehouse.world.traffic.body import Body, Delay
from desim_warehouse.world.traffic.closures import Closure, Slowness
from desim_warehouse.world.traffic.intersection import Intersection
from desim_warehouse.world.traffic.rulebook import Rules
from desim_warehouse.world.traffic.rules import EPS, turn
from desim_warehouse.world.traffic.zones import ZoneDirection


class Lane:
    """A queue of robots in order, where none overtakes.

    `last` is the robot that entered last and is still on the lane (maintained by `Body.off_lane`). `entering` is the
    robot that was granted room and has not yet set out for it. `wanted` counts the waiting claims for room on the lane.
    A *short* lane has no room to stand clear of both its ends (length < 2 D): a robot on it holds its end. An *inside*
    lane joins two nodes of one intersection, and counts as short. `stop_line` is D before the end, where a robot claims
    what comes next. `node_time` is spent at the end itself. A two-way lane is a pair of lanes, each the other's `twin`,
    with robots on at most one of them. `zone_direction` belongs to a zone used in one direction at a time. `tail` and
    `head` are the points that the lane joins (x + iy). `out_at` and `out_pace` are when and how fast the last robot
    left its end, `out_since` when it set out from the stop line if it stood there after leaving the queue.
    """

    __slots__ = (
        "blocked",
        "closings",
        "edge",
        "end",
        "entering",
        "head",
        "heading",
        "headway",
        "inside",
        "last",
        "length",
        "limit",
        "node_time",
        "out_at",
        "out_pace",
        "out_since",
        "passages",
        "rules",
        "short",
        "start",
        "stop_line",
        "tail",
        "turns",
        "twin",
        "waits",
        "wanted",
        "zone_direction",
    )

    closures: Sequence[Closure] = ()
    slow: Sequence[Slowness] = ()
    """The closures and speed limits of the lane (see `closures.RestrictedLane`)."""

    def __init__(
        self,
        rules: Rules,
        edge: tuple[str, str],
        *,
        length: float,
        limit: float,
        heading: float,
        tail: complex,
        head: complex,
        start: Intersection,
        end: Intersection,
        node_time: float,
        inside: bool = False,
        twin: Lane | None = None,
        zone_direction: ZoneDirection | None = None,
    ) -> None:
        self.rules = rules
        self.edge = edge
        self.tail = tail
        self.head = head
        self.length = length
        self.limit = limit
        self.heading = heading
        self.start = start
        self.end = end
        self.node_time = node_time
        self.headway = rules.headway
        self.short = inside or length < 2 * self.headway
        self.inside = self.short and start is end
        self.stop_line = 0.0 if self.short else length - self.headway
        self.closings: dict[tuple[Lane, float], float] = {}
        self.turns: dict[Lane, float] = {}
        self.last: Body | None = None
        self.entering: Body | None = None
        self.zone_direction = zone_direction
        self.twin = twin
        if twin is not None:
            twin.twin = self
        self.wanted = 0
        self.out_at = self.out_since = -math.inf
        self.out_pace = 1.0
        self.passages = self.waits = 0
        self.blocked = 0.0

    def limit_at(self, time: float) -> float:  # noqa: ARG002 - see RestrictedLane
        """Return the speed limit for a robot that enters the lane at a time."""
        return self.limit

    def turn_to(self, onward: Lane) -> float:
        """Return how long a robot that comes by this lane turns on the node before it can leave by another."""
        time = self.turns.get(onward)
        if time is None:
            time = self.turns[onward] = self.rules.turn_time * turn(self.heading, onward.heading) / (math.pi / 2)
        return time

    # Room

    def has_room(self, robot: Body) -> bool:
        """Whether a robot can come to a stand D beyond the lane's start, with no other on the way in."""
        # The robot in `entering` was granted the room and has not set out yet.
        if self.entering is not None or (self.twin is not None and not self._is_clear_for(robot)):
            return False
        last = self.last
        return last is None or last.target >= 2 * self.headway - EPS  # one D for each of the two

    def shut_by(self, robot: Body) -> Closure | None:  # noqa: ARG002 - see RestrictedLane
        """Return the closure that keeps a robot out of the lane now, if it is closed."""
        return None

    def _is_clear_for(self, robot: Body) -> bool:
        """Whether no robot comes towards a given one on a two-way lane. A robot that turns back meets only itself."""
        assert self.twin is not None
        other = self.twin.last
        return self.twin.entering is None and (other is None or (other is robot and robot.ahead is None))

    @property
    def lane_of_both(self) -> Lane:
        """The lane that stands for both directions of a two-way lane."""
        return self if self.twin is None or self.edge < self.twin.edge else self.twin

    def clear_stop(self, stop: float) -> float:
        """Return where a robot that wants to stop at `stop` does stop: no nearer than D to the nodes.

        Any nearer, it would keep others off the node while it loads, and a ring could not turn past it.
        """
        if self.inside:
            return stop
        # Below 2 D it cannot be clear of both ends: it stops D from the start, and holds the end. The length may have
        # been rounded down to D or 2 D: a good next to its end is at its end.
        return max(min(stop, self.length) if self.short else min(stop, self.stop_line), self.headway)

    def made_room(self, behind: Body | None, now: float) -> None:
        """Let waiting robots move up: those from `behind` on, or if None the robots at the lane's start."""
        if behind is None:
            if self.wanted:
                self.start.serve(now)
        else:
            self.move_up(behind, now)

    # The queue

    def enter(self, robot: Body, clear: float, stop: float | None, now: float) -> None:
        """Add a robot as the last on the lane: it leaves the node at `clear`, for `stop` or the stop line.

        Behind a slower robot it leaves later, at `robot.since`, rather than drive slower. So it keeps D all the way,
        and one event still takes it there.
        """
        ahead = self.last
        target = goal = self.stop_line if stop is None else stop
        if ahead is not None:
            target = min(target, max(ahead.target - self.headway, 0.0))  # in a rotation there may be no room yet
            ahead.behind = robot  # here, where there is one: this is the hot path
        if not self.rules.mixed:
            robot.onto_lane(self, ahead, goal, target, clear, clear + target / robot.pace)
        else:  # paces differ, or robots accelerate: not before it keeps clear of the one ahead
            late = self._late(robot, ahead, target, clear)
            until = clear + target / robot.pace
            if late > EPS:
                self._put_off(robot, ahead, robot.pace, clear, late, now + (clear + late - now))
                clear += late
                until += late
            robot.onto_lane(self, ahead, goal, target, clear, until)
            if robot.look_ahead is not None:
                robot.look_ahead.expect()
        self.last = robot
        self.entering = None
        self.passages += 1

    def _late(self, robot: Body, ahead: Body | None, target: float, clear: float) -> float:
        """Return how much later than at `clear` a robot enters, at the pace that it has from now on."""
        robot.take_pace_of(self, clear)
        if ahead is None and self.out_at <= clear >= self.out_since and not robot.braking:
            return 0.0  # the last that left is off the lane by then
        return self.free_at(robot, ahead, 0.0, target, clear) - (clear + target / robot.pace)

    def first_target(self, stop: float | None) -> float:
        """Return how far a robot that enters the lane now commits to drive on it (see `enter`)."""
        goal = self.stop_line if stop is None else stop
        last = self.last
        return goal if last is None else min(goal, max(last.target - self.headway, 0.0))

    def enter_standing(self, robot: Body, since: float) -> None:
        """Put a robot from the node at the lane's start onto this short lane, standing at 0 from `since` on."""
        if self.rules.mixed:
            robot.take_pace_of(self, since)
        robot.onto_short_lane(self, self.last, since)
        self.last = robot
        self.passages += 1

    def place(self, robot: Body, position: float) -> None:
        """Put a robot onto the lane at the start of a run, as the last."""
        robot.begin_on_lane(self, self.last, position)
        self.last = robot

    def commit(self, robot: Body, target: float, now: float) -> None:
        """Let a robot drive on to `target`, and start all robots that gain room by it."""
        self.set_off(robot, target, now)
        self.made_room(robot.behind, now)

    def move_up(self, robot: Body | None, now: float) -> None:
        """Move up the robots behind one that has made way, down the queue: waiting ones set off, others drive on.

        So every robot's target is as far as its goal and the robot ahead allow, even while it drives: a platoon flows
        as one. Each robot wakes at its new target: a queue moves up with one event per robot.
        """
        while robot is not None:
            ahead = robot.ahead
            limit = robot.goal if ahead is None else min(robot.goal, ahead.target - self.headway)
            if limit - robot.target <= EPS:  # in the terms of `Drive.roll`, so that no rounding comes between them
                return
            if robot.waiting_behind is not None:
                drive = robot.stop_waiting(now)
                self.set_off(robot, limit, now)
                drive.due(robot.until)
            elif not self._drive_on(robot, limit, now):
                return
            robot = robot.behind
            if robot is None and self.wanted:
                self.start.serve(now)

    def set_off(self, robot: Body, target: float, now: float) -> None:
        """Start a robot towards `target`, `now` or late enough to come no closer to a slower robot."""
        rules, since = self.rules, now
        mixed = rules.mixed
        if mixed and robot.stretch is not None:
            since = robot.commit_length(target - robot.pos, now)
        until = since + (target - robot.pos) / robot.pace
        if mixed and (late := self.free_at(robot, robot.ahead, robot.target, target, since) - until) > EPS:
            self._put_off(robot, robot.ahead, robot.pace, since, late, since + late)
            since += late
            until += late
        # It sets off for a further target. Separate calls for this and the wait below cost a full floor 3 %.
        robot.since = since
        robot.until = until
        robot.target = target
        if mixed and robot.look_ahead is not None:
            robot.look_ahead.expect()
        if rules.log.everything:
            rules.log.drive(robot, since)

    def _put_off(self, robot: Body, ahead: Body | None, pace: float, since: float, late: float, end: float) -> None:
        """Postpone the start of a robot behind a slower one, or behind one that still accelerates."""
        if robot.stretch is not None:
            part = robot.put_off(late, pace)
            since, late = since + part, late - part
            if late <= EPS:
                return
        self.count_wait(robot, ahead, late, end)
        robot.delay_is_known(Delay(self, ahead, since, since + late))

    def _drive_on(self, robot: Body, target: float, now: float) -> bool:
        """Let a moving robot drive on to `target` without a stop, unless it would come too close to a slower one.

        A robot that still accelerates does not drive on, because the time for that is spent at its present target. Its
        drive has an event at the previous target, and again at the new one.
        """
        until = robot.until + (target - robot.target) / robot.pace
        if robot.until < now or (
            self.rules.mixed
            and (
                self.free_at(robot, robot.ahead, robot.target, target, now) > until + EPS
                or not robot.commit_length_under_way(target - robot.target)
            )
        ):
            return False
        since = robot.until
        robot.drive_on(target, until)
        if robot.look_ahead is not None:
            robot.look_ahead.expect()
        if self.rules.log.everything:
            self.rules.log.drive(robot, since)
        return True

    def free_at(self, robot: Body, ahead: Body | None, start: float, target: float, since: float) -> float:
        """Return when a robot may be at `target`: D behind the one ahead all the way, on the lane or just off its end.

        The delay beyond its own earliest arrival counts as waiting. Both drive at a steady pace, so it is enough that
        it keeps D at its target and where the one ahead sets off, if that is after `since`, the earliest departure of
        the robot from `start`. One that keeps its braking distance B is D + B behind, at most B before its target, and
        from where it has reached its pace.
        """
        pace, braking = robot.pace, robot.braking
        free = self._clear_at(ahead, target, pace) + braking / pace
        if braking and target - start > (run_up := robot.run_up) + braking:
            clear = self._clear_at(ahead, start + run_up + braking, pace)
            free = max(free, clear + (target - start - run_up) / pace)
        begin, stood = (self.out_since, self.stop_line) if ahead is None else (ahead.since, ahead.pos)
        if begin > since - braking / pace:
            free = max(free, begin + max(target + braking - (stood - self.headway), 0.0) / pace)
        return free

    def _clear_at(self, ahead: Body | None, place: float, pace: float) -> float:
        """Return when the robot ahead, or the last that left, is D beyond a position, at `pace` or faster."""
        if ahead is not None:
            return ahead.passes(place + self.headway)
        beyond = place - (self.length - self.headway)
        return self.out_at + beyond / (pace if beyond > 0 else self.out_pace)

    def count_wait(self, robot: Body, other: Body | None, duration: float, end: float) -> None:
        """Count a collision: an episode of waiting behind `other` on this lane that ends at `end`.

        The episode is one however often the robot would stop and start in small steps meanwhile; counting every stop, S
        would grow without limit as the steps shrink.
        """
        self.waits += 1
        self.blocked += duration
        robot.waited += duration
        robot.rear_ends += 1
        if self.rules.log.everything:
            self.rules.log.collision(end, robot, other, None, self.edge, duration)

    def cut_delay(self, robot: Body, delay: Delay, now: float) -> None:
        """Cut a delay that was counted and is not over when the run ends: its remainder does not count."""
        left = robot.delay_after(now)
        begun = delay.begin < now - EPS
        robot.cut_wait_behind(left, begun=begun)
        self.blocked -= left
        if not begun:
            self.waits -= 1
        elif self.rules.log.everything:
            self.rules.log.collision(now, robot, delay.other, None, self.edge, now - delay.begin)


class RestrictedLane(Lane):
    """A lane with `closures`, speed limits at times, or both. Its permanent limit is `usual`.

    A robot keeps on the lane the pace that holds at the instant at which it enters.
    """

    __slots__ = ("closures", "slow", "usual")

    closures: Sequence[Closure]
    slow: Sequence[Slowness]

    def __init__(self, *args: Any, closures: Sequence[Closure], slow: Sequence[Slowness], **of_lane: Any) -> None:
        super().__init__(*args, **of_lane)
        self.closures = closures
        self.slow = (*slow, Slowness(self.usual)) if slow else ()

    @property
    def limit(self) -> float:
        """The speed limit of the lane now."""
        return self.limit_at(self.rules.env._now)

    @limit.setter
    def limit(self, limit: float) -> None:
        self.usual = limit

    def limit_at(self, time: float) -> float:
        """Return the speed limit at a time."""
        return min((slowness.limit(time) for slowness in self.slow), default=self.usual)

    def _late(self, robot: Body, ahead: Body | None, target: float, clear: float) -> float:
        """Return how much later a robot enters, at the pace that holds at that instant.

        If the start is postponed beyond a change of the limit, it may enter at that change, at another pace.
        """
        in_ring = robot.train_pace < math.inf
        late = super()._late(robot, ahead, target, clear)
        if in_ring or not self.slow:
            return late
        planned, entry = robot.limit, clear
        while (change := min(slowness.hours.changes(entry) for slowness in self.slow)) <= clear + late:
            entry = change
            robot.take_pace_of(self, entry)
            late = max(self.free_at(robot, ahead, 0.0, target, clear) - (clear + target / robot.pace), entry - clear)
        if robot.limit != planned:
            robot.start_at_pace(target)
        return late

    def shut_by(self, robot: Body) -> Closure | None:
        """Return the closure that keeps a robot out now. A robot already on a lane of the closure is not kept out."""
        now: float = self.rules.env._now
        for closure in self.closures:
            if closure.opens_for(robot, now) > now and not self._is_reached_within(closure, robot.lane):
                return closure
        return None

    def _is_reached_within(self, closure: Closure, lane: Lane | None) -> bool:
        """Whether a robot from another lane arrives without leaving the closure, possibly over a short lane."""
        if lane is None or closure not in lane.closures:
            return False
        return lane.end is self.start or any(out.end is self.start and closure in out.closures for out in lane.end.outs)

    def has_room(self, robot: Body) -> bool:
        """Whether the lane is open to a robot, which can come to a stand D beyond its start."""
        return not (self.closures and self.shut_by(robot)) and super().has_room(robot)
