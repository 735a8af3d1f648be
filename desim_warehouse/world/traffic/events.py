"""The clock of a run, and events that SimPy lacks: due at an exact time, or after all others of an instant.

Together with `drive.py`, the only file that uses SimPy's private names: `env._queue`, `env._eid`, `event._ok`.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from heapq import heappop, heappush
from math import inf
from typing import TypeAlias

from simpy import Environment
from simpy.events import NORMAL, Event, EventPriority

Steps: TypeAlias = Generator[Event, object, None]
"""The steps of a process or of a part of one: the events that it waits for, in order."""
BATCHES = EventPriority(NORMAL + 1)
"""Priority of batching tasks among the events of one instant: after everything else that happens then."""
DECISIONS = EventPriority(NORMAL + 2)
"""Priority of decisions: after batching."""
AFTER_DECISIONS = EventPriority(NORMAL + 3)
"""Priority of events that follow the decisions of their instant."""


class Clock(Environment):
    """SimPy's environment with a faster loop for the one use that a run makes of it: to run until an event occurs.

    SimPy's own loop calls a method for each event and reads the time from a property, which took 7 % of a run.
    """

    now: float = 0.0  # a property in SimPy
    ticks: int = 0
    """The number of scheduled events of endless clocks (`tick`)."""

    def step(self) -> None:
        """Process the next event in SimPy's own loop (`run`): setting its private time would leave `now` behind."""
        if self._queue:
            self.now = self._queue[0][0]
        super().step()

    def run_to(self, over: Event) -> bool:
        """Process all events up to and including `over` (returns True), or until none is scheduled (False)."""
        queue = self._queue
        while queue:
            time, _, _, event = heappop(queue)
            self._now = self.now = time
            callbacks = event.callbacks
            event.callbacks = None  # type: ignore[assignment]  # as SimPy does
            for callback in callbacks:
                callback(event)
            if not event._ok and not event.defused:
                raise event._value
            if event is over:
                return True
        return False

    def stop(self, error: BaseException) -> None:
        """Raise an error before the next event; safe from any thread, as pushing plain tuples to a heap is one step.

        An exception raised from outside between any two instructions, as time-outs do, could leave half-made tables
        that runs of a model share.
        """

        def end(_: Event) -> None:
            raise error

        event = happened(self)
        event.callbacks.append(end)
        heappush(self._queue, (-inf, NORMAL, next(self._eid), event))

    def tick(self, time: float, callback: Callable[[], object]) -> None:
        """Call back at a time, as an endless clock does: alone, it keeps no run going."""

        def due(_: Event) -> None:
            self.ticks -= 1
            callback()

        self.ticks += 1
        Arrival(self, time).callbacks.append(due)

    @property
    def only_ticks(self) -> bool:
        """Whether only endless clocks are scheduled."""
        return len(self._queue) <= self.ticks


def happened(env: Environment) -> Event:
    """Make an event that has succeeded but is not scheduled: its holder decides when its callbacks are called."""
    event = Event(env)
    event._ok, event._value = True, None
    return event


def end_of_instant(env: Environment, priority: EventPriority, delay: float = 0.0) -> Event:
    """Make an event due `delay` from now, with a priority among the events of that instant."""
    event = happened(env)
    env.schedule(event, priority=priority, delay=delay)
    return event


class Arrival(Event):
    """An event due at an absolute time rather than after a delay, free of the rounding of `now + delay`."""

    def __init__(self, env: Environment, time: float) -> None:
        self.env = env
        self.callbacks = []
        self._value = None
        self._ok = True
        heappush(env._queue, (time, NORMAL, next(env._eid), self))
