"""The clock of a run, and events that SimPy does not offer: due at an exact instant, or after all others of one.

Together with `drive.py`, the only file where SimPy's private names are used: `env._queue`, `env._eid`, `event._ok`.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from heapq import heappop, heappush
from math import inf
from typing import TypeAlias

from simpy import Environment
from simpy.events import NORMAL, Event, EventPriority

Steps: TypeAlias = Generator[Event, object, None]
"""The steps of a process, or of a part of one: the events that it waits for, one after the other."""
BATCHES = EventPriority(NORMAL + 1)
"""Priority of putting tasks together among the events of one instant: after all that happens at that time."""
DECISIONS = EventPriority(NORMAL + 2)
"""Priority of decisions: after that."""
AFTER_DECISIONS = EventPriority(NORMAL + 3)
"""Priority of what waits for the decisions of its instant."""


class Clock(Environment):
    """SimPy's environment with a lean loop for the one use that a run makes of it: on, until an event has come up.

    SimPy's own loop calls a method for each event and reads the time from a property, which was 7 % of a run.
    """

    now: float = 0.0  # a property in SimPy
    ticks: int = 0
    """How many scheduled events belong to clocks that go on whatever happens (`tick`)."""

    def step(self) -> None:
        """Run the next event, in SimPy's own loop (`run`): its private time alone would leave `now` behind."""
        if self._queue:
            self.now = self._queue[0][0]
        super().step()

    def run_to(self, over: Event) -> bool:
        """Let everything happen up to `over` and with it (True), or until nothing is scheduled any more (False)."""
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
        """Raise an error before the next event; from any thread, as pushing to a heap of plain tuples is one step.

        An exception raised from outside between any two instructions, as time-outs do it, could leave tables half made
        that runs of a model share.
        """

        def end(_: Event) -> None:
            raise error

        event = happened(self)
        event.callbacks.append(end)
        heappush(self._queue, (-inf, NORMAL, next(self._eid), event))

    def tick(self, time: float, callback: Callable[[], object]) -> None:
        """Call back at a time, as an endless clock does: by itself it keeps no run going."""

        def due(_: Event) -> None:
            self.ticks -= 1
            callback()

        self.ticks += 1
        Arrival(self, time).callbacks.append(due)

    @property
    def only_ticks(self) -> bool:
        """Whether nothing is scheduled but clocks."""
        return len(self._queue) <= self.ticks


def happened(env: Environment) -> Event:
    """Make an event that has succeeded but is not scheduled: its holder says when its callbacks are called."""
    event = Event(env)
    event._ok, event._value = True, None
    return event


def end_of_instant(env: Environment, priority: EventPriority, delay: float = 0.0) -> Event:
    """Make an event that is due `delay` from now, by its priority among the events of that instant."""
    event = happened(env)
    env.schedule(event, priority=priority, delay=delay)
    return event


class Arrival(Event):
    """An event due at a given time, not at a delay from now: without the rounding of `now + delay`."""

    def __init__(self, env: Environment, time: float) -> None:
        self.env = env
        self.callbacks = []
        self._value = None
        self._ok = True
        heappush(env._queue, (time, NORMAL, next(env._eid), self))
