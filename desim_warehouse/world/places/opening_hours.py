"""Processes that wait for opening hours: until a station opens, or for time in which it is open."""

from __future__ import annotations

import math
from collections.abc import Callable

from simpy.events import Event, Timeout

from desim_warehouse.values.calendars import Hours
from desim_warehouse.world.traffic.events import Arrival, Clock, Steps


def at(env: Clock, time: float) -> Event:
    """Return an event at a time. An event at infinity keeps no run going."""
    return Arrival(env, time) if math.isfinite(time) else Event(env)


def change(env: Clock, hours: Hours) -> Event:
    """Return an event at the next opening or closing of a station."""
    return at(env, hours.changes(env.now))


def until_open(env: Clock, hours: Hours) -> Steps:
    """Wait until a station is open."""
    while not hours.is_open(env.now):
        yield change(env, hours)


def open_time(
    env: Clock,
    time: float,
    hours: Hours | None,
    pause: Callable[[], None] | None = None,
    go_on: Callable[[], None] | None = None,
) -> Steps:
    """Wait, from now on, for a given time during which a station is open (None: always).

    `pause` is called when it closes in between, `go_on` when it opens again.
    """
    while hours is not None and env.now + time > (closes := hours.changes(env.now)):
        time -= closes - env.now
        yield at(env, closes)
        if pause is not None:
            pause()
        yield from until_open(env, hours)
        if go_on is not None:
            go_on()
    yield Timeout(env, time)
