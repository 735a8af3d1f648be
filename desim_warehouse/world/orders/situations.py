"""Situations: the state shown to the allocation policy for a decision."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from desim_warehouse.layout import Layout
from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.policies import OpenTasks, RobotView, Situation, Task
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.traffic.events import Clock

if TYPE_CHECKING:
    from numpy.random import Generator

    from desim_warehouse.world.robots.mixed_reach import MixedReach
    from desim_warehouse.world.robots.reach import Reach
    from desim_warehouse.world.traffic.routes import Routes


class Situations:
    """Make the situations that the allocation policy decides on."""

    def __init__(
        self,
        env: Clock,
        layout: Layout,
        travel: FreeTravel,
        *,
        routes: Routes,
        reach: Reach | MixedReach,
        open_tasks: Mapping[int, Task],
        streams: Streams,
    ) -> None:
        self.env = env
        self.travel = travel
        self.routes = routes
        self.reach = reach
        self.open_tasks = open_tasks
        self.streams = streams
        self._length = layout.length
        self._generators: dict[str, Generator] = {}
        self.handling = reach.handling

    def now(self, free: Sequence[RobotView], fleet: Callable[[], Sequence[RobotView]]) -> Situation:
        """Return the present situation, with the `free` robots by number and the whole `fleet`."""
        reach, routes = self.reach, self.routes
        return Situation(
            time=self.env.now,
            robots=free,
            tasks=self._tasks(free),
            travel=self.travel,
            station=reach.stations.choose,
            feasible=reach.feasible,
            may=reach.may,
            allowed=reach.allowed,
            fleet=fleet,
            waits=lambda: routes.waits,
            collisions=lambda: routes.collisions,
            random=lambda: self._random("allocation"),
            handling=self.handling,
            length=self._length,
            tour_time=reach.tour_time,
        )

    def _tasks(self, free: Sequence[RobotView]) -> Sequence[Task]:
        """Return the open tasks, except those held back because a station or the way is closed."""
        tasks, openings = self.open_tasks.values(), self.reach.openings
        return openings.admit_tasks(free, tasks) if openings.holds else OpenTasks(tasks)

    def _random(self, kind: str) -> Generator:
        """Return a policy's own stream."""
        if kind not in self._generators:
            self._generators[kind] = self.streams.stream(kind)
        return self._generators[kind]
