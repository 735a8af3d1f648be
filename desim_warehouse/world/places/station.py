"""One station beside a node: its slots and servers, and the work on load units that robots put down there.

A load unit takes up room in the buffer from the time at which a robot begins to put it down until it has been worked
on. With no room left the next robot keeps its server and waits. So a full buffer blocks the station, as blocking after
service does in a production line.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from simpy import Resource

from desim_warehouse.outcome.log import NONE, Log
from desim_warehouse.policies import Task
from desim_warehouse.values.calendars import Hours
from desim_warehouse.world.places.opening_hours import open_time, until_open
from desim_warehouse.world.traffic.events import Clock, Steps

if TYPE_CHECKING:
    from simpy.resources.resource import Request


class Workplace:
    """The workers of a station, and its buffer for `places` load units (None: unlimited).

    They keep the station's `hours` (None: always at work); work begun before the end of hours is finished, or `pauses`.
    `time` gives the working time of a task's load unit. `left`: load units put down and not worked on; `worked` is
    called for each finished one.
    """

    def __init__(
        self,
        env: Clock,
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
        """Start work on a load unit that was put down in the buffer, where its room was reserved."""
        self.left += 1
        self.log.is_for_workers(task.number)
        self.env.process(self._work(task, place))

    def _work(self, task: Task, place: Request | None) -> Steps:
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
    """An unloading station with `places` slots for robots inside or on the way, and `servers` that serve them.

    Outside its `hours` no service begins (None: it is always open); one that has begun is finished, or `pauses`. `work`
    is the work on load units put down there, if any. If no slot is free, its node is among those that are `full`.
    `busy`: total time in use of its servers, by robots that have changed state since.
    """

    def __init__(
        self,
        env: Clock,
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
        """Reserve a slot for a robot."""
        self.taken += 1
        if self.free <= 0:
            self.full.add(self.node)

    def give_up(self) -> None:
        """Free a slot that was reserved."""
        self.taken -= 1
        if self.free > 0:
            self.full.discard(self.node)

    def dock(self, robot: int) -> None:
        """Admit a robot that has a slot reserved."""
        self.inside.add(robot)

    def leave(self, robot: int, *, keep: bool = False) -> None:
        """Let a robot out. Its slot becomes free unless the robot is to `keep` it for a later return."""
        self.inside.remove(robot)
        if not keep:
            self.give_up()
