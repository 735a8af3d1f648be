"""A trip: a robot on its way over lanes, and the one event that stands for its progress."""

from __future__ import annotations

from heapq import heappush
from typing import TYPE_CHECKING, Any

from simpy.events import NORMAL, Event

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from simpy import Environment

    from desim_warehouse.world.body import Body
    from desim_warehouse.world.lanes import Lane


class Trip(Event):
    """A robot's drive along `route` to `stop` on the last lane (None: to its end); `index` lanes are entered.

    As an event it is due when the robot is where it was sure to get to, and it is put on SimPy's queue again for
    every edge: so a drive takes one event object, and the robot's process sleeps until it is `held_up`: it is there,
    or has to decide or to wait for something at an intersection.
    """

    __slots__ = ("_ok", "_value", "callbacks", "env", "held_up", "index", "robot", "rolls", "route", "stop")

    def __init__(
        self,
        env: Environment,
        robot: Body,
        route: Sequence[Lane],
        stop: float | None,
        rolls: list[Callable[[Any], None]],
    ) -> None:
        self.env = env
        self._ok = True
        self._value = None
        self.robot = robot
        self.route = route
        self.stop = stop
        self.rolls = rolls
        self.index = 0
        self.held_up: Event

    @property
    def onward(self) -> Lane | None:
        """The lane to enter next; None: the robot is on the last."""
        return self.route[self.index] if self.index < len(self.route) else None

    def due(self, time: float) -> None:
        """Have it come up at a time."""
        env = self.env
        self.callbacks = self.rolls
        heappush(env._queue, (time, NORMAL, next(env._eid), self))

    def wake(self) -> None:
        """Let the robot's process go on, at once."""
        event = self.held_up
        callbacks, event.callbacks = event.callbacks, None  # type: ignore[assignment]  # as SimPy does
        for callback in callbacks:
            callback(event)
