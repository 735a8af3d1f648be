"""Service of a robot at a station: in its turn, and for all its loads.

Robots are served in order of arrival, and keep their server until they have handled all their loads. In a closed
station a robot waits in the state `closed`, whether it is its turn or not. In an open one it is `queueing` for a server
or, with one, for room in the buffer.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from desim_warehouse.world.places.opening_hours import change, open_time
from desim_warehouse.world.places.station import Station
from desim_warehouse.world.places.stops import Stop
from desim_warehouse.world.traffic.events import Clock, Steps

if TYPE_CHECKING:
    from simpy.events import Event
    from simpy.resources.resource import Request


class Served(Protocol):
    """A robot as stations see it."""

    def enter(self, state: str) -> None:
        """Change the robot's state."""


class Service:
    """One robot's visit to a server of a station: for each load `begin`, `take` the time of handling and `end`.

    After the last load the robot must `leave` the server. `queued`: whether all servers were busy on arrival.
    """

    def __init__(self, env: Clock, robot: Served, station: Station) -> None:
        self.env = env
        self.robot = robot
        self.station = station
        self.turn = station.servers.request()
        self.queued = not self.turn.triggered
        self.place: Request | None = None

    def begin(self, stop: Stop) -> Steps:
        """Wait for all resources that the handling of a load needs."""
        if self.station.hours is None:
            if not self.turn.triggered:
                self.robot.enter("queueing")
            yield self.turn
        else:
            yield from self._wait(self.turn)
        work = self.station.work
        if work is None or work.places is None or stop.act != "unload":
            return
        self.place = work.places.request()
        yield from self._wait(self.place)

    def _wait(self, event: Event) -> Steps:
        """Wait until an event occurs and the station is open."""
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
        """Load or unload for a time. Where the station pauses, handling goes on when it opens again."""
        robot, hours = self.robot, self.station.hours if self.station.pauses else None
        robot.enter(state)
        yield from open_time(self.env, time, hours, lambda: robot.enter("closed"), lambda: robot.enter(state))

    def end(self, stop: Stop) -> None:
        """Start the work of people on a load that was put down."""
        work = self.station.work
        if work is not None and stop.act == "unload":
            work.put(stop.task, self.place)

    def leave(self) -> None:
        """Free the server for the next robot."""
        self.station.servers.release(self.turn)
