"""How a robot in a station is served: when it is its turn, the station is open, and there is room for its load.

It takes its turn in the order of arrival. In a closed station it waits in the state `closed`, whether it is its turn or
not. In an open one it is `queueing` for a server or, with one, for room in the buffer.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from desim_warehouse.world.places.hours import change, open_time

if TYPE_CHECKING:
    from collections.abc import Generator

    from simpy import Environment
    from simpy.events import Event
    from simpy.resources.resource import Request

    from desim_warehouse.world.places.station import Station
    from desim_warehouse.world.places.stops import Stop

    Steps = Generator[Event, object, None]


class Served(Protocol):
    """A robot as stations know it."""

    def enter(self, state: str) -> None:
        """Begin something else."""


class Service:
    """One robot's visit to a server of a station: `begin`, then `take` the time of handling, then `end`."""

    def __init__(self, env: Environment, robot: Served, station: Station, stop: Stop) -> None:
        self.env = env
        self.robot = robot
        self.station = station
        self.stop = stop
        self.turn: Request
        self.place: Request | None = None

    def begin(self) -> Steps:
        """Wait for everything that the handling needs."""
        robot, station = self.robot, self.station
        self.turn = station.servers.request()
        if station.hours is None:
            if not self.turn.triggered:
                robot.enter("queueing")
            yield self.turn
        else:
            yield from self._wait(self.turn)
        work = station.work
        if work is None or work.places is None or self.stop.act != "unload":
            return
        self.place = work.places.request()
        yield from self._wait(self.place)

    def _wait(self, event: Event) -> Steps:
        """Until it has what it waits for, and the station is open."""
        hours = self.station.hours
        while True:
            closed = hours is not None and not hours.is_open(self.env.now)
            if event.triggered and not closed:
                return
            self.robot.enter("closed" if closed else "queueing")
            if hours is None:
                yield event
            else:
                yield change(self.env, hours) if closed else event | change(self.env, hours)

    def take(self, state: str, time: float) -> Steps:
        """Loading or unloading. Where the station pauses it goes on when it opens again."""
        robot, hours = self.robot, self.station.hours if self.station.pauses else None
        robot.enter(state)
        yield from open_time(self.env, time, hours, lambda: robot.enter("closed"), lambda: robot.enter(state))

    def end(self) -> None:
        """The server is free for the next, and a load that was put down is worked on."""
        work = self.station.work
        if work is not None and self.stop.act == "unload":
            work.put(self.stop.task, self.place)
        self.station.servers.release(self.turn)
