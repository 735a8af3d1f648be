"""Pickers: the assignment of pickers, who walk, to robots that wait at storage places.

Robots that call and pickers who become free at one instant are matched together, at its end. Robots that stand and wait
come first. A picker always completes a walk. A picker who was sent ahead, and arrives before the robot, may be sent to
a robot that waits elsewhere: so neither the robots behind that one nor the picker's own robot wait for ever.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from simpy.events import Event

from desim_warehouse.errors import ModelError
from desim_warehouse.layout import Layout
from desim_warehouse.layout.walking import Spot, at_start, walking_on, zones_of
from desim_warehouse.model.sections.pickers import PickersSpec
from desim_warehouse.outcome.log import Log
from desim_warehouse.values.calendars import Hours
from desim_warehouse.world.places.stops import Stop
from desim_warehouse.world.traffic.events import DECISIONS, Arrival, Clock, Steps, end_of_instant


class _Body(Protocol):
    @property
    def is_on_lanes(self) -> bool: ...


class Caller(Protocol):
    """A robot as pickers see it."""

    number: int

    @property
    def body(self) -> _Body:
        """The body of the robot, with its position."""

    @property
    def node(self) -> str:
        """The node that the robot is at, or comes to next."""

    def enter(self, state: str) -> None:
        """Change the robot's state."""


@dataclass(slots=True, eq=False)
class Picker:
    """A person at a `spot`, or on the way there until `there_at`, for a `robot` (-1: none).

    `stop` is that of the robot. `bound`: the robot has come, or takes the picker along, who else may be sent elsewhere.
    """

    number: int
    zone: int
    spot: Spot
    there_at: float = 0.0
    robot: int = -1
    stop: Stop | None = None
    bound: bool = False


@dataclass(slots=True, eq=False)
class Call:
    """A robot's call for a picker at a stop, and the event that is due when one is there; None: it is on its way."""

    robot: int
    stop: Stop
    met: Event | None

    @property
    def spot(self) -> Spot:
        """The place where the robot stops."""
        return self.stop.edge, self.stop.offset


class Pickers:
    """All pickers, and the calls without an assigned picker, in the order in which they were made."""

    def __init__(self, env: Clock, spec: PickersSpec, hours: Hours, layout: Layout, log: Log) -> None:
        self.env = env
        self.spec = spec
        self.hours = hours
        self.log = log
        self.walking = walking_on(layout)
        zones = zones_of(layout, spec.zones)
        self.zone_of = {spot: number for number, spots in enumerate(zones) for spot in spots}
        self.pickers = [Picker(number, zone, spot) for number, (zone, spot) in enumerate(at_start(spec.count, zones))]
        self.calls: list[Call] = []
        self._with: dict[int, Picker] = {}
        self._coming: dict[int, Event] = {}
        self._meets = False
        self._opens_at = math.inf

    # Calls and visits of robots

    def serve_at(self, stop: Stop) -> bool:
        """Whether a picker handles the load of a robot at a stop: at a storage place, for flows that need a picker."""
        task = stop.task
        if stop.act == "load":
            stored = task.good >= 0
        elif stop.act == "unload":
            stored = task.drop is not None
        else:
            stored = task.via[stop.rank].storage is not None
        return stored and stop.station is None and self.spec.serves(task.flow)

    def set_out(self, robot: Caller, stops: Sequence[Stop]) -> Steps:
        """Let a robot set out on a tour: with `stay: order` when it has a picker, who goes with it.

        Raises:
            ModelError: where it stands in the lane then, and would block others.
        """
        stop = next((stop for stop in stops if self.serve_at(stop)), None)
        if stop is None:
            return
        if self.spec.stay == "pick":
            self.expect(robot, stops[0])
            return
        if robot.body.is_on_lanes:
            where = f"robot {robot.number} begins its next tour in the lane, at {robot.node}"
            raise ModelError([f"pickers.stay: {where}, where it must not wait for a picker; expected pick"])
        yield from self._wait_for_one(robot, stop)

    def expect(self, robot: Caller, stop: Stop) -> None:
        """Note that a robot sets out for a stop: its picker walks there, too, or one may be sent ahead."""
        if not self.serve_at(stop):
            return
        picker = self._with.get(robot.number)
        if picker is not None:
            if picker.there_at <= self.env.now and picker.spot != (stop.edge, stop.offset):
                self._send(picker, robot.number, stop)
        elif self.spec.call == "ahead":
            self._call(Call(robot.number, stop, None))

    def come(self, robot: Caller, stop: Stop) -> Steps:
        """Wait at a storage place until a picker is there."""
        picker = self._with.get(robot.number)
        if picker is None:
            self.calls = [call for call in self.calls if call.robot != robot.number]
            yield from self._wait_for_one(robot, stop)
            picker = self._with[robot.number]
        picker.bound = True
        if picker.there_at > self.env.now:
            robot.enter("awaiting_picker")
            self._coming[robot.number] = arrival = Event(self.env)
            yield arrival

    def begin(self, robot: Caller, stop: Stop, time: float) -> None:
        """Note that a picker begins to handle a robot's load, which takes some time."""
        self._record("picking", self._with[robot.number], robot.number, stop, self.env.now + time)

    def end(self, robot: Caller, rest: Iterable[Stop]) -> None:
        """Note that handling is over: the picker is free, unless they stay for some of the stops to come."""
        if self.spec.stay == "pick" or not any(self.serve_at(stop) for stop in rest):
            self.forget(robot.number)

    def forget(self, robot: int) -> None:
        """Forget a robot that no longer needs a picker, perhaps as its task was taken back; its picker is free."""
        self.calls = [call for call in self.calls if call.robot != robot or call.met is not None]
        picker = self._with.pop(robot, None)
        if picker is not None:
            picker.robot, picker.stop, picker.bound = -1, None, False
            self._meet_soon()

    def left_alone(self) -> list[int]:
        """Return the robots that wait for a picker, if pickers never come to work again."""
        gone = math.isinf(self.hours.following(self.env.now)[0])
        return [call.robot for call in self.calls if call.met is not None] if gone else []

    def _wait_for_one(self, robot: Caller, stop: Stop) -> Steps:
        robot.enter("awaiting_picker")
        met = Event(self.env)
        self._call(Call(robot.number, stop, met))
        yield met

    def _call(self, call: Call) -> None:
        self.calls.append(call)
        self._meet_soon()

    # Assignment

    def _meet_soon(self) -> None:
        if not self._meets:
            self._meets = True
            end_of_instant(self.env, DECISIONS).callbacks.append(self._meet)

    def _meet(self, _: Event) -> None:
        """Send pickers to robots in each zone as long as both are available."""
        self._meets = False
        if not self.calls:
            return
        if not self.hours.is_open(self.env.now):
            self._meet_when_open()
            return
        while (pair := self._next_pair()) is not None:
            call, picker = pair
            self.calls.remove(call)
            if picker.stop is not None:
                self._call_again(picker.robot, picker.stop)
            self._send(picker, call.robot, call.stop)
            if call.met is not None:
                picker.bound = True
                call.met.succeed()

    def _meet_when_open(self) -> None:
        """Schedule the next assignment for the start of the pickers' hours, if robots wait then."""
        opens = self.hours.changes(self.env.now)
        if opens < self._opens_at and any(call.met is not None for call in self.calls):
            self._opens_at = opens
            Arrival(self.env, opens).callbacks.append(self._open)

    def _open(self, _: Event) -> None:
        self._opens_at = math.inf
        self._meet_soon()

    def _next_pair(self) -> tuple[Call, Picker] | None:
        """Choose the next picker and robot: standing robots first, and pickers sent ahead only if none is free."""
        now = self.env.now
        free = [picker for picker in self.pickers if picker.there_at <= now and not picker.bound]
        idle = [picker for picker in free if picker.robot < 0]
        standing = [call for call in self.calls if call.met is not None]
        ahead = [call for call in self.calls if call.met is None]
        for calls, pickers in ((standing, idle), (standing, free), (ahead, idle)):
            pair = self._closest(calls, pickers)
            if pair is not None:
                return pair
        return None

    def _closest(self, calls: Sequence[Call], pickers: Sequence[Picker]) -> tuple[Call, Picker] | None:
        """Return the next call in a zone with an available picker, and the closest picker to it."""
        in_zone: defaultdict[int, list[Picker]] = defaultdict(list)
        for picker in pickers:
            in_zone[picker.zone].append(picker)
        served = [(call, near) for call in calls if (near := in_zone[self.zone_of[call.spot]])]
        if self.spec.choose == "longest-waiting":
            served = served[:1]
        pairs = ((call, picker) for call, near in served for picker in near)
        return min(pairs, key=lambda pair: self.walking.distance(pair[1].spot, pair[0].spot), default=None)

    def _call_again(self, robot: int, stop: Stop) -> None:
        """Renew the call of a robot on its way, as the picker who waits for it is sent elsewhere."""
        del self._with[robot]
        self.calls.append(Call(robot, stop, None))

    def _send(self, picker: Picker, robot: int, stop: Stop) -> None:
        """Send a picker to the place where a robot stands or will stop."""
        spot = stop.edge, stop.offset
        time = self.walking.distance(picker.spot, spot) / self.spec.speed
        picker.spot, picker.robot, picker.stop, picker.there_at = spot, robot, stop, self.env.now + time
        self._with[robot] = picker
        self._record("walking", picker, robot, stop, picker.there_at)
        Arrival(self.env, picker.there_at).callbacks.append(lambda _: self._arrive(picker))

    def _arrive(self, picker: Picker) -> None:
        if picker.there_at > self.env.now:  # the picker set out again at this very instant
            return
        arrival = self._coming.pop(picker.robot, None)
        if arrival is not None:
            arrival.succeed()
        elif not picker.bound:
            self._meet_soon()

    def _record(self, kind: str, picker: Picker, robot: int, stop: Stop, until: float) -> None:
        task, edge, offset = stop.task.number, stop.edge, stop.offset
        self.log.picker(self.env.now, kind, picker.number, robot, task, stop.node, edge, offset, until)
