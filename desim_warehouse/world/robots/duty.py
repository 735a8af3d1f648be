"""Duty: which robots may take up work, by shifts and breaks, and by a cap on the number under way.

Outside its hours a robot takes up no work. It finishes the task or tour in hand, goes to a bay and rests there in the
state `on_break`, where it is also charged. When its hours end, the tasks of its queue return to the list. When they
begin, it is given work at once.

A floor with too many robots has a lower throughput than one with fewer (`traffic.most_out`). A robot is under way from
being given a task in its bay, or leaving it for another reason, until it is parked again. While the cap is reached,
robots in bays are given no task. Robots under way go from task to task without permission. Robots that leave for the
sake of a battery, to a charger or from one, count but do not wait, so none runs flat because of the cap. The cap could
stop work for ever only if no robot came home, but always one comes home or works on (docs/why.md, "Never stalled").
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from desim_warehouse.model import Model
from desim_warehouse.values.calendars import Hours
from desim_warehouse.world.traffic.events import Clock


def duty_of(clock: Clock, model: Model) -> Duty:
    """Make the hours of the robots of a model."""
    names = model.fleet.hours_of_robots()
    hours = {name: model.hours(name) for name in dict.fromkeys(names) if name is not None}
    return Duty(clock, [None if name is None else hours[name] for name in names])


class Duty:
    """The hours of every robot, by number, or None if it is always on duty; `calendars` has each calendar once."""

    def __init__(self, clock: Clock, hours: Sequence[Hours | None]) -> None:
        self.clock = clock
        self.hours = hours
        self.calendars = list({id(calendar): calendar for calendar in hours if calendar is not None}.values())

    def has(self, number: int) -> bool:
        """Whether a robot is on duty now."""
        hours = self.hours[number]
        return hours is None or hours.is_open(self.clock.now)

    def among(self, robots: list[int]) -> list[int]:
        """Return the robots among some that are on duty now."""
        return [number for number in robots if self.has(number)] if self.calendars else robots

    def gone(self) -> list[int]:
        """Return the robots whose hours have ended for good."""
        now = self.clock.now
        return [
            n
            for n, calendar in enumerate(self.hours)
            if calendar is not None and math.isinf(calendar.following(now)[0])
        ]

    def watch(self, changed: Callable[[Sequence[int]], bool]) -> None:
        """Call `changed` with the robots whose hours begin or end, each time, as long as it returns that this matters.

        Shifts go on for ever, but a run that is otherwise at its end, or stalled, must end.
        """
        if not self.calendars:
            return
        now = self.clock.now
        time = min(calendar.changes(now) for calendar in self.calendars)
        if math.isfinite(time):
            concerned = [
                n for n, calendar in enumerate(self.hours) if calendar is not None and calendar.changes(now) == time
            ]
            self.clock.tick(time, lambda: self._change(concerned, changed))

    def _change(self, concerned: Sequence[int], changed: Callable[[Sequence[int]], bool]) -> None:
        if changed(concerned):
            self.watch(changed)


class Departures:
    """The robots under way, by number, and the most that may be under way to take up work (None: no cap).

    The robots `resting` among them have nothing to do, and rest where they have unloaded. The robots in `changing_bay`
    have nothing to do, either: they left a bay to charge in another, or to make room.
    """

    def __init__(self, most: int | None, duty: Duty) -> None:
        self.most = most
        self.duty = duty
        self.under_way: set[int] = set()
        self.resting: set[int] = set()
        self.changing_bay: set[int] = set()

    @property
    def have_work(self) -> bool:
        """Whether any robot under way works, or comes home from work."""
        return not self.under_way <= self.resting | self.changing_bay

    @property
    def is_full(self) -> bool:
        """Whether the cap keeps robots from leaving their bays for a task now."""
        return self.most is not None and len(self.under_way) >= self.most

    def may_work(self, number: int) -> bool:
        """Whether a robot may be given a task: it is on duty, and it is under way or may set out."""
        return (number in self.under_way or not self.is_full) and self.duty.has(number)
