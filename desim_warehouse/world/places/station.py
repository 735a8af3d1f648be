"""One station beside a node: its slots and servers, the work done there, and how a robot is served.

Robots take their turn in the order of arrival, and keep their server until they have handled all that they came for.
In a closed station a robot waits in the state `closed`, whether it is its turn or not. In an open one it is `queueing`
for a server or, with one, for room in the buffer.

Work in a station on the load units that robots put down there, such as packing, and the buffer where they wait.

A load unit takes up room in the buffer from the time at which a robot begins to put it down until it has been worked
on. With no room left the next robot keeps its server and waits. So a full buffer holds up the station, as blocking
after service does in a line of machines.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import TYPE_CHECKING, Protocol

from simpy import Resource

from desim_warehouse.outcome.log import NONE, Log
from desim_warehouse.policies import Task
from desim_warehouse.values.calendars import Hours
from desim_warehouse.world.places.openings import change, open_time, until_open
from desim_warehouse.world.places.stops import Stop

if TYPE_CHECKING:
    from simpy import Environment
    from simpy.events import Event
    from simpy.resources.resource import Request

    Steps = Generator[Event, object, None]


class Workplace:
    """The workers of a station, and its buffer for `places` load units (None: unlimited).

    They keep the station's `hours` (None: always at work); what they have begun when these are over is finished, or
    `pauses`. `time` says how long the work on a task's load unit takes. `left`: load units put down and not worked on;
    `worked` is told of each that is.
    """

    def __init__(
        self,
        env: Environment,
        node: str,
        log: Log,
        *,
        places: int | None,
        workers: int,
        hours: Hours | None,
        pauses: bool,
        time: Callable[[Task], float],
        worked: Callable[[], None],
    ) -> None:
        self.env = env
        self.node = node
        self.log = log
        self.places = None if places is None else Resource(env, places)
        self.workers = Resource(env, workers)
        self.hours = hours
        self.pauses = pauses
        self.time = time
        self.worked = worked
        self.left = 0

    def put(self, task: Task, place: Request | None) -> None:
        """A load unit has been put down, in room of the buffer that was reserved for it."""
        self.left += 1
        self.log.is_for_workers(task.number)
        self.env.process(self._work(task, place))

    def _work(self, task: Task, place: Request | None) -> Generator[Event, object, None]:
        env, hours, put = self.env, self.hours, self.env.now
        with self.workers.request() as worker:
            yield worker
            if hours is not None:
                yield from until_open(env, hours)
            self.log.event(env.now, "working", NONE, task.number, self.node, env.now - put)
            yield from open_time(env, self.time(task), hours if self.pauses else None)
        self.log.event(env.now, "worked", NONE, task.number, self.node, env.now - put)
        if self.places is not None and place is not None:
            self.places.release(place)
        self.left -= 1
        self.worked()


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
