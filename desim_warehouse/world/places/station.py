"""One station beside a node: its slots and servers, the work done there, and how a robot is served.

Robots take their turn in the order of arrival, and keep their server until they have handled all that they came for.
In a closed station a robot waits in the state `closed`, whether it is its turn or not. In an open one it is `queueing`
for a server or, with one, for room in the buffer.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from simpy import Resource

from desim_warehouse.world.places.hours import change, open_time

if TYPE_CHECKING:
    from collections.abc import Generator

    from simpy import Environment
    from simpy.events import Event
    from simpy.resources.resource import Request

    from desim_warehouse.values.calendars import Hours
    from desim_warehouse.world.places.stops import Stop
    from desim_warehouse.world.places.workplace import Workplace

    Steps = Generator[Event, object, None]


class Station:
    """An unloading station: `places` slots for robots inside or on the way, `servers` of them are served at a time.

    Outside its `hours` nothing begins there (None: it is always open). What has begun is finished, or `pauses`. `work`
    is done on what is put down there, if anything is. Where no slot is free its node is among those that are `full`.
    `busy`: the time that its servers have been in use, all together, by robots that began something else since.
    """

    def __init__(
        self,
        env: Environment,
        node: str,
        places: int,
        servers: int,
        full: set[str],
        *,
        hours: Hours | None,
        pauses: bool,
        work: Workplace | None,
    ) -> None:
        self.node = node
        self.places = places
        self.taken = 0
        self.busy = 0.0
        self.inside: set[int] = set()
        self.servers = Resource(env, servers)
        self.full = full
        self.hours = hours
        self.pauses = pauses
        self.work = work

    @property
    def free(self) -> int:
        """Slots that no robot is in or on its way to."""
        return self.places - self.taken

    def take(self) -> None:
        """A slot is reserved."""
        self.taken += 1
        if self.free <= 0:
            self.full.add(self.node)

    def give_up(self) -> None:
        """A slot is free again."""
        self.taken -= 1
        if self.free > 0:
            self.full.discard(self.node)

    def dock(self, robot: int) -> None:
        """A robot that has a slot reserved comes in."""
        self.inside.add(robot)

    def leave(self, robot: int, *, keep: bool = False) -> None:
        """A robot is out again, and its slot is free unless it is to `keep` it, as it comes back."""
        self.inside.remove(robot)
        if not keep:
            self.give_up()


class Served(Protocol):
    """A robot as stations know it."""

    def enter(self, state: str) -> None:
        """Begin something else."""


class Service:
    """One robot's visit to a server of a station: for each load `begin`, `take` the time of handling and `end`.

    After the last load the robot is to `leave` the server. `queued`: whether none was free when it came.
    """

    def __init__(self, env: Environment, robot: Served, station: Station) -> None:
        self.env = env
        self.robot = robot
        self.station = station
        self.turn = station.servers.request()
        self.queued = not self.turn.triggered
        self.place: Request | None = None

    def begin(self, stop: Stop) -> Steps:
        """Wait for everything that the handling of a load needs."""
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

    def end(self, stop: Stop) -> None:
        """A load that was put down is worked on."""
        work = self.station.work
        if work is not None and stop.act == "unload":
            work.put(stop.task, self.place)

    def leave(self) -> None:
        """The server is free for the next."""
        self.station.servers.release(self.turn)
