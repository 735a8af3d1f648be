"""Events that SimPy does not offer: due at an exact instant, or after all others of the instant.

Together with `drive.py`, the place where SimPy's private names are used: `env._queue`, `env._eid`, `event._ok`.
"""

from __future__ import annotations

from heapq import heappush
from typing import TYPE_CHECKING

from simpy.events import NORMAL, Event, EventPriority

if TYPE_CHECKING:
    from simpy import Environment

DECISIONS = EventPriority(NORMAL + 1)
"""Priority of decisions among the events of one instant: after all that happens at that time."""
AFTER_DECISIONS = EventPriority(NORMAL + 2)
"""Priority of what waits for the decisions of its instant."""


def happened(env: Environment) -> Event:
    """An event that has succeeded already but is not scheduled: whoever holds it says when its callbacks are called."""
    event = Event(env)
    event._ok, event._value = True, None
    return event


def end_of_instant(env: Environment, priority: EventPriority, delay: float = 0.0) -> Event:
    """Due `delay` from now, by its priority among the events of that instant."""
    event = happened(env)
    env.schedule(event, priority=priority, delay=delay)
    return event


class Arrival(Event):
    """Due at a time that is given, not at a delay from now: without the rounding of `now + delay`."""

    def __init__(self, env: Environment, time: float) -> None:
        self.env = env
        self.callbacks = []
        self._value = None
        self._ok = True
        heappush(env._queue, (time, NORMAL, next(env._eid), self))
