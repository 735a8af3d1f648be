"""The drive of a robot over lanes and intersections, made by `Traffic.drive`: a process with one event of progress.

A robot commits to a target on its lane, D behind the target of the robot ahead, drives there in one timeout and decides
again. At the stop line, D before an intersection, it claims the intersection and room to stand beyond it in one step.
It holds both until it is through, so the same timeout takes it over the intersection and on to its next target. An edge
thus costs one event where the way is free, and the robot's process sleeps meanwhile. (Two events an edge, to the stop
line and over the node, were measured to cost more: docs/why.md.)
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from enum import Enum
from heapq import heappush
from typing import TYPE_CHECKING, Any

from simpy.events import NORMAL, Event

from desim_warehouse.world.traffic.events import Arrival, Steps, happened
from desim_warehouse.world.traffic.intersection import Intersection
from desim_warehouse.world.traffic.rulebook import Rules
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from desim_warehouse.world.traffic.body import Body
    from desim_warehouse.world.traffic.lane import Lane
    from desim_warehouse.world.traffic.motion import Stretch


class Departure(Enum):
    """The way in which a robot leaves the intersection that it stood on."""

    UNDER_WAY = "it is on a lane now"
    THERE = "the route ends here"
    RECALLED = "it is wanted elsewhere, and stays on the node"


class Drive:
    """A robot's drive along `route` to `stop` on the last lane (None: to its end), with `index` lanes entered.

    The drive itself is on SimPy's queue, as an event that has succeeded (SimPy's loop reads only `callbacks` and
    `_ok`). It is queued again for every edge, so a whole drive takes one object. The robot's process sleeps until the
    drive is `held_up`: it has arrived, or has to decide or to wait for something at an intersection.
    """

    __slots__ = (
        "_ok",
        "callbacks",
        "cleared_before_stop",
        "crossing",
        "env",
        "held_up",
        "index",
        "node_time_over",
        "robot",
        "route",
        "rules",
        "slow",
        "stop",
        "turn_time",
    )

    crossing: tuple[float, float, float, Stretch]
    """The latest answer of `_crossing`: when the robot would leave the node."""
    node_time_over: float
    """When the robot has spent its time at the node that it was let onto early."""

    def __init__(self, rules: Rules, robot: Body, route: Sequence[Lane], stop: float | None) -> None:
        self._ok = True
        self.callbacks: Any = None
        self.rules = rules
        self.env: Any = rules.env
        self.turn_time = rules.turn_time
        self.robot = robot
        self.route = route
        self.stop = stop
        self.index = 0
        self.cleared_before_stop = False
        self.node_time_over = -math.inf
        # Whether crossing takes more than a drive and node time
        self.slow = rules.turn_time > 0 or robot.stretch is not None or robot.delays is not None
        self.held_up: Event | None = None

    @property
    def onward(self) -> Lane | None:
        """The lane to enter next; None on the last lane."""
        return self.route[self.index] if self.index < len(self.route) else None

    # The process

    @property
    def rest(self) -> Sequence[Lane]:
        """The lanes that the robot has yet to enter."""
        return self.route[self.index :]

    def __iter__(self) -> Generator[Event, object, bool]:
        """Drive (`yield from` it). Returns False if recalled, with the robot on the next node of its route."""
        return self._drive_and_brake() if self.slow else self._drive()

    def _drive_and_brake(self) -> Generator[Event, object, bool]:
        if self.robot.look_ahead is not None:
            self.robot.look_ahead.drive = self
        has_arrived = yield from self._drive()
        if has_arrived:
            braked = self.robot.brake_to_stand(self.env._now)
            if braked > self.env._now:
                yield Arrival(self.env, braked)
        return has_arrived

    def _drive(self) -> Generator[Event, object, bool]:
        robot = self.robot
        if robot.lane is not None:
            robot.head_for(robot.lane.stop_line)
            if self.stop is not None and not self.route:
                robot.head_for(max(self.stop, robot.pos))
                if robot.held is not None:
                    yield from self._along_short(robot.goal)
                    return True
        while True:
            if robot.lane is None or robot.held is not None:
                outcome = yield from self._from_node()
                if outcome is not Departure.UNDER_WAY:
                    return outcome is Departure.THERE
            yield self._under_way()
            if robot.halts_at <= self.env._now:
                yield from self._halt()
                continue
            onward = self.onward
            if onward is None and self.stop is not None:
                return True
            # A recall takes effect at the next node, never between nodes.
            if onward is None or onward.short or math.inf > robot.recall_at <= self._clear_of_node(onward):
                yield from self._to_node()
            elif not robot.detours or not self._take_detour():
                yield from self._pass_when_free(onward)

    def _halt(self) -> Steps:
        """Stand until a breakdown is repaired, and stay there meanwhile even if other robots make way.

        A robot that is cleared off the lanes meanwhile is then beside a node, as in a bay.
        """
        robot = self.robot
        goal = robot.goal
        robot.head_for(robot.pos)
        yield from robot.driver.halt(self)
        if not robot.cleared:
            robot.head_for(goal)

    @property
    def may_be_cleared(self) -> bool:
        """Whether a broken robot may be cleared off its lane: only once per drive where it must drive the lane again.

        Otherwise a robot that breaks down before each arrival would never arrive. A robot in the cabin of a lift, which
        may be between floors, is repaired there.
        """
        held = self.robot.held
        return not (self.cleared_before_stop and self._drives_its_lane_again) and (held is None or not held.is_lift)

    @property
    def _drives_its_lane_again(self) -> bool:
        """Whether a cleared robot must drive its lane again after its repair: to a stop, or a lift at its end."""
        lane = self.robot.lane
        return lane is not None and ((self.stop is not None and self.onward is None) or lane.end.is_lift)

    def clear(self) -> Lane | None:
        """Clear a broken robot off its lane, and return the lane if the robot has to drive it again."""
        if not self._drives_its_lane_again:
            return None
        lane: Lane = self.robot.lane
        self.route, self.index, self.cleared_before_stop = [lane, *self.rest], 0, True
        return lane

    def _under_way(self) -> Event:
        """Return an event that is due when the robot arrives or is held up at an intersection."""
        event = self.held_up = happened(self.env)
        if self.robot.until > self.env._now:
            self.due(self.robot.until)
        else:
            self.roll()
        return event

    @property
    def _process_sleeps(self) -> bool:
        """Whether the robot's process waits for the event of its progress and for no other."""
        return self.held_up is not None and self.held_up.callbacks is not None

    def _wake(self) -> None:
        """Resume the robot's process at once, without a turn of SimPy's queue."""
        event: Any = self.held_up
        callbacks, event.callbacks = event.callbacks, None  # as SimPy does
        for callback in callbacks:
            callback(event)

    def _clear_of_node(self, onward: Lane) -> float:
        """Return when a robot that sets out from the stop line now leaves the node."""
        robot = self.robot
        if robot.stretch is not None:
            stop = self.stop if self.index + 1 == len(self.route) else None
            now = self.env._now
            crossing = self.crossing = self._crossing(onward, stop, now, now)
            return crossing[2]
        lane = robot.lane
        clear = float(self.env._now + (lane.length - robot.pos) / robot.pace + lane.node_time)
        return clear + self._more_time(lane, onward)

    def _more_time(self, lane: Lane, onward: Lane) -> float:
        """Return the time at the end of a lane beyond its `node_time`: for the turn to the next and for delays."""
        robot = self.robot
        time = lane.turn_to(onward) if self.turn_time else 0.0
        return time if robot.delays is None else time + robot.delays.at(robot.moves)

    def _crossing(
        self, onward: Lane, stop: float | None, now: float, entry: float
    ) -> tuple[float, float, float, Stretch]:
        """Return when a robot that accelerates sets out, is at its lane's end and leaves the node, and its stretch.

        Its pace beyond the node is fixed when it leaves the node, not before `entry`. Unless it stops on the node, it
        spends all time lost where it stands now and then drives at a steady pace, which its followers can plan by.
        """
        robot, lane = self.robot, self.robot.lane
        begin, stretch = robot.going_on(now)
        # In a rotation the room may not exist yet but will: the robot loses only the time to drive clear of the node.
        ahead = onward.first_target(stop), robot.pace_on(onward, entry), onward.headway
        if lane is None or robot.target >= lane.length:
            more, stretch = stretch.further(*ahead)
            clear = begin + more
            begin = out = now
        else:
            rest = lane.length - robot.target
            more, stretch = stretch.further(rest, robot.pace)
            begin += more
            spent = lane.node_time + self._more_time(lane, onward)
            if spent:
                out = begin + rest / robot.pace
                braking, stretch = stretch.stopped
                more, stretch = stretch.further(*ahead)
                clear = out + braking + spent + more
            else:
                more, stretch = stretch.further(*ahead)
                begin += more
                out = clear = begin + rest / robot.pace
        if not onward.slow:
            return begin, out, clear, stretch
        if clear > entry:
            return self._crossing(onward, stop, now, clear)
        late = entry - clear
        return begin + late, out + late, clear + late, stretch

    def _take_detour(self) -> bool:
        """Take another route, if any, from the intersection at which the robot is held up."""
        other = self.robot.driver.take_detour(self.route, self.index, self.stop)
        if other is None:
            return False
        self.route, self.index = other, 0
        return True

    @property
    def may_go_round(self) -> bool:
        """Whether the robot may take another way from the node that it comes to next or stands on."""
        robot = self.robot
        if not self.rest or robot.granted is not None or robot.recall_at <= self.env._now or robot.is_at_lift:
            return False
        claim = robot.claim
        return claim is None or robot.held is None or claim.node is robot.held

    def go_round(self, other: Sequence[Lane]) -> None:
        """Take another way from the next node. A claim that waits at that node is changed accordingly."""
        self.route, self.index = other, 0
        claim = self.robot.claim
        if claim is None:
            return
        if self.robot.held is None:
            claim.go_for(self._rests_beyond(), self._closes_beyond())
        else:
            claim.go_for(None if other[0].short else other[0], None)
            if other[0].short:  # it stands on the node already, and claims only that now
                claim.node.award(claim, None)
                return
        claim.node.freed(self.env._now)

    def _pass_when_free(self, onward: Lane) -> Steps:
        """Wait at the stop line for the intersection and room beyond it, then set out unless the robot is recalled."""
        robot = self.robot
        yield from robot.lane.end.claim(robot, onward, robot.lane)
        onward = self.route[self.index]  # its way may have changed
        if onward.short:
            yield from self._to_node()
            return
        clear = self._clear_of_node(onward)
        if robot.recall_at > clear and robot.granted is onward:
            self.index += 1
            self._cross(onward, clear, None if self.onward else self.stop, self.env._now)
        else:
            yield from self._to_node()

    def goes_on_early(self, now: float) -> bool:
        """Go on, if the way is free, before the robot must brake for the stop line; returns whether it does."""
        robot, lane, onward = self.robot, self.robot.lane, self.onward
        node: Intersection = lane.end
        if robot.halts_at <= robot.until or (onward is None and self.stop is not None):
            return False
        if robot.held is not None:
            return self._goes_on_from_node(onward, now)
        if not self._process_sleeps:
            return False
        if onward is None or onward.short or robot.recall_at <= (clear := self._clear_of_node(onward)):
            beyond = self._rests_beyond() if robot.recall_at > now else None
            return node.take(robot, beyond, lane, self._closes_beyond())
        if not node.take(robot, onward, lane):
            return False
        self.index += 1
        self._cross(onward, clear, None if self.onward else self.stop, now)
        return True

    def _goes_on_from_node(self, onward: Lane | None, now: float) -> bool:
        """Whether the robot may continue from a node at the end of its lane that it already holds."""
        robot, lane = self.robot, self.robot.lane
        if onward is None or lane.node_time or self._more_time(lane, onward):
            return False  # it stops there
        if onward.inside or robot.granted is onward:
            return True
        return self._process_sleeps and self._cross_next_short(now, early=True)

    # The event. This is the hot path of every run, counted in bytecodes (`benchmarks.bytecodes`): attributes are read
    # once, and SimPy's queue is used directly, as its methods and properties would be a third of a free crossing.

    def due(self, time: float) -> None:
        """Schedule the drive as an event at a time."""
        env = self.env
        self.callbacks = ROLL
        heappush(env._queue, (time, NORMAL, next(env._eid), self))

    # In one piece for speed: each part moved to a call of its own costs about 1 % of a run.
    def roll(self) -> None:
        """Drive on if possible, now that the robot has reached its target.

        It drives along its lane as far as the robot ahead allows, up to its own stop or the stop line, and from there
        over the intersection if both the node and its stand beyond are free.
        """
        robot, env = self.robot, self.env
        lane, now = robot.lane, env._now
        if robot.until > now:  # the robot ahead has made way meanwhile, so the target is not reached yet
            self.due(max(robot.until, self.node_time_over))
            return
        pos = robot.pos = robot.target  # as `arrive` does: a call for each event of a drive costs 1 %
        if robot.halts_at <= now or robot.held is not None:
            if robot.halts_at <= now or not self._cross_next_short(now):
                self._wake()
            return
        if robot.goal - pos > EPS:
            ahead = robot.ahead
            # Behind the target of the robot ahead, not its position: it is sure to get there, so one timeout is enough.
            limit = robot.goal if ahead is None else min(robot.goal, ahead.target - lane.headway)
            if limit - pos <= EPS:
                robot.wait_behind(self, now)
                self.rules.gridlock.check(robot)
                return
            lane.commit(robot, limit, now)
        else:
            index, count = self.index, len(self.route)
            if index == count:
                self._wake()
                return
            onward, node, guard = self.route[index], lane.end, self.rules.guard
            if (
                onward.short
                or node.claims  # earlier claims are served first
                or not node.is_open(robot, lane, now)
                or not onward.has_room(robot)  # node and room in one step: no robot waits on a node for room
                # Known before the robot sets out, as node and room are its own already: others can plan by it.
                or robot.recall_at
                <= (
                    clear := self._clear_of_node(onward)
                    if self.slow
                    else now + (lane.length - pos) / robot.pace + lane.node_time
                )
                or not (guard is None or guard.admit(robot, node, onward))
            ):
                self._wake()
                return
            self.index = index = index + 1
            self._cross(onward, clear, self.stop if index == count else None, now)
        self.callbacks = ROLL  # as `due` does
        heappush(env._queue, (robot.until, NORMAL, next(env._eid), self))

    def _cross(self, onward: Lane, clear: float, stop: float | None, now: float) -> None:
        """Set out over an intersection that the robot holds, onto the lane beyond, and leave the node at `clear`.

        The order matters. First the robot leaves its lane, which closes the gap in its queue and records when and how
        fast the lane's end is passed. `enter` may postpone the start (behind a slower robot), so the node is passed at
        `robot.since`. Robots behind move up only once this one is on its new lane. The claims at the node come last,
        because serving them looks for rings, which must be seen in their final state.
        """
        robot, node, log = self.robot, onward.start, self.rules.log
        lane, behind = robot.lane, robot.behind
        begin = now
        if not self.slow:
            if lane is not None:
                robot.off_lane(clear - lane.node_time)
        elif robot.stretch is not None:
            if lane is None or robot.target >= lane.length:
                out, (_, _, clear, stretch) = now, self._crossing(onward, stop, clear, clear)
            else:
                begin, out, clear, stretch = self.crossing  # of this instant: nothing crosses at an unknown time
                lane.out_since = begin
            robot.commit_stretch(stretch)
            if lane is not None:
                robot.off_lane(out)
        elif lane is not None:
            robot.off_lane(clear - lane.node_time - self._more_time(lane, onward))
        onward.enter(robot, clear, stop, now)
        node.passed(robot, onward, robot.since)
        if log.moves:
            log.cross(begin, robot, lane, robot.since)
        if lane is not None and (behind is not None or lane.wanted):
            lane.made_room(behind, now)
        if node.claims:
            node.freed(now)

    # Standing on an intersection: out of bays, at stations in the lane, on short lanes, after a recall

    def _rests_beyond(self) -> Lane | None:
        """Return the first lane on which a robot can stand clear of the intersection before it, if any."""
        route = self.route
        for index in range(self.index, len(route)):
            lane = route[index]
            if not lane.inside:
                return None if lane.short else lane  # below 2 D it stands on the node at the lane's end instead
        return None

    def _closes_beyond(self) -> Lane | None:
        """Return a lane that closes at times, beyond the intersection ahead, and is too short to stand on.

        The robot waits for its opening where it is, rather than on the node.
        """
        lane = next((lane for lane in self.route[self.index :] if not lane.inside), None)
        return lane if lane is not None and lane.short and lane.closures else None

    def _to_node(self) -> Steps:
        """Drive from the stop line to stand on the intersection."""
        robot = self.robot
        if robot.held is None:
            if robot.recall_at > self.env._now or robot.lane.end.is_lift:  # out of a cabin it goes on to the next node
                yield from robot.lane.end.claim(robot, self._rests_beyond(), robot.lane, self._closes_beyond())
            else:
                yield from robot.lane.end.claim(robot, None, robot.lane)
        yield from self._to_end()

    def _to_end(self) -> Steps:
        """Drive to the end of a lane that is granted as a whole, and spend the time at the node."""
        robot, lane = self.robot, self.robot.lane
        lane.commit(robot, lane.length, self.env._now)
        yield Arrival(self.env, self._spend_node_time(lane))
        robot.arrive_on_node()

    def _spend_node_time(self, lane: Lane) -> float:
        """Stop at the lane's end for the time at the node; returns when it has passed."""
        robot = self.robot
        spent = lane.node_time if robot.delays is None else lane.node_time + robot.delays.at(robot.moves)
        if robot.stretch is not None and spent:
            return robot.brake_to_stand(robot.until) + spent
        return robot.until + spent

    def _along_short(self, stop: float) -> Steps:
        """Drive farther along a lane too short to stand clear of its nodes, holding its end."""
        robot = self.robot
        robot.lane.commit(robot, stop, self.env._now)
        yield Arrival(self.env, robot.until)
        robot.arrive()

    def _from_node(self) -> Generator[Event, object, Departure]:
        """Drive from a bay or an intersection onto the next lane where the robot can stand."""
        robot = self.robot
        if robot.held is None:
            yield from self._out_of_bay()
        elif robot.lane is not None and robot.pos < robot.lane.length:
            yield from self._to_end()
        while True:
            if robot.halts_at <= self.env._now:
                yield from self._halt()
                if robot.cleared:
                    yield from self._out_of_bay()
            if robot.recall_at <= self.env._now and self._may_stay:
                self._give_up_room()
                return Departure.RECALLED
            onward = self.onward
            if onward is None:
                return Departure.THERE
            self._turn(onward)
            if not onward.short:
                if robot.granted is not onward:
                    yield from robot.held.claim(robot, onward, robot.lane)
                    if self.onward is not onward:  # its way has changed
                        continue
                self.index += 1
                halt = None if self.onward else self.stop
                self._cross(onward, max(robot.ready_at, self.env._now), halt, self.env._now)
                return Departure.UNDER_WAY
            self.index += 1
            halt = None if self.onward else self.stop
            yield from self._over_short(onward, halt)
            if halt is not None:
                return Departure.THERE

    def _give_up_room(self) -> None:
        """Give back the room granted beyond the node; robots wait for a two-way lane at its other end, too."""
        granted = self.robot.granted
        self.robot.give_up_room()
        if granted is not None and granted.end.claims:
            granted.end.freed(self.env._now)

    def _out_of_bay(self) -> Steps:
        """Drive out of a bay or station onto the node beside it, or back from where the robot was cleared to."""
        robot = self.robot
        if robot.halts_at <= self.env._now:
            yield from self._halt()
        if robot.is_turned_off:  # cleared off the lanes meanwhile, it takes another way from the node
            yield from robot.at.claim(robot, None, None)
        else:
            yield from robot.at.claim(robot, self._rests_beyond(), None, self._closes_beyond())
        robot.driver.left_bay()

    def _turn(self, onward: Lane) -> None:
        """Turn on a node to the next lane, also while waiting to enter. Out of a bay the robot faces it already."""
        robot = self.robot
        if self.turn_time and robot.lane is not None:
            robot.turn_on_node(robot.lane.turn_to(onward), self.env._now)

    def _over_short(self, onward: Lane, halt: float | None) -> Steps:
        """Drive over a lane too short to stand on, holding its end from before the start, and during a halt.

        The robot continues over further short lanes as long as they are free, so a grid of cells costs one event a
        cell.
        """
        robot = self.robot
        if not onward.inside:
            yield from onward.end.claim(robot, self._rests_beyond(), onward, onward if onward.closures else None)
        event = self.held_up = happened(self.env)
        self._set_out_over_short(onward, onward.length if halt is None else halt, self.env._now)
        yield event

    def _set_out_over_short(self, onward: Lane, target: float, now: float, *, early: bool = False) -> None:
        """Set out from the held node over a short lane whose end is granted, and schedule the drive.

        `early`: a robot that looks ahead is let in before it is at the node, when its drive is already scheduled there.
        """
        robot, node, log, env = self.robot, onward.start, self.rules.log, self.env
        turning = max(robot.ready_at - now, 0.0) if self.turn_time else 0.0
        out = robot.until if early else now
        if robot.lane is not None:
            robot.off_lane(out)
        onward.enter_standing(robot, out + turning)
        if log.moves:
            log.enter(out + turning, robot)
        onward.set_off(robot, target, out + turning)
        if not onward.inside:
            node.passed(robot, onward, robot.since)
            if node.claims:
                node.freed(now)
        # The time at the node is spent on arrival there: the robot may stop short of it.
        arrival = self._spend_node_time(onward) if target == onward.length else robot.until
        if early:
            self.node_time_over = arrival
            return
        self.callbacks = ROLL  # as `due` does
        heappush(env._queue, (arrival, NORMAL, next(env._eid), self))

    def _cross_next_short(self, now: float, *, early: bool = False) -> bool:
        """Set out from the end of a short lane over the next, if that is short too and free."""
        robot, index = self.robot, self.index
        if robot.recall_at <= now or index >= len(self.route) - (self.stop is not None) or not robot.lane.short:
            return False
        onward = self.route[index]
        node = onward.end
        if not onward.short or onward.inside or node.claims or not node.is_open(robot, onward, now):
            return False
        if onward.closures and onward.shut_by(robot) is not None:
            return False
        self.index = index + 1
        beyond = self._rests_beyond()
        guard = self.rules.guard
        if (beyond is not None and not beyond.has_room(robot)) or not (
            guard is None or guard.admit(robot, node, beyond)
        ):
            self.index = index
            return False
        node.grant(robot, beyond)
        if self.turn_time:
            self._turn(onward)
        self._set_out_over_short(onward, onward.length, now, early=early)
        return True

    @property
    def _may_stay(self) -> bool:
        """Whether a recalled robot may stay on the intersection and give up the room granted beyond it.

        Where steps are guarded it counts as standing beyond already, so it goes on and is recalled at the next node.
        That costs energy, never liveness: its declared route ends in its own slot. So does a robot in a lift.
        """
        robot = self.robot
        return not robot.held.is_lift and (robot.granted is None or self.rules.guard is None)


ROLL = [Drive.roll]
"""The callbacks of a drive on SimPy's queue: one list for all drives, as SimPy only reads it."""
