"""What policies are shown of a run: the situation, stations, energies, and what traffic was like so far."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from desim_warehouse.policies import Handling, RobotView, Situation
from desim_warehouse.world.energy import Energy
from desim_warehouse.world.lanes import EPS

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.random import Generator

    from desim_warehouse.policies import Task
    from desim_warehouse.world.lanes import Lane
    from desim_warehouse.world.powered import Powered
    from desim_warehouse.world.world import World

Edge = tuple[str, str]


class Means(Mapping[Edge, float]):
    """A mean per passage of every edge so far, always up to date."""

    def __init__(self, lanes: Mapping[Edge, Lane], mean: Callable[[Lane], float]) -> None:
        self._lanes = lanes
        self._mean = mean

    def __getitem__(self, edge: Edge) -> float:
        return self._mean(self._lanes[edge])

    def __iter__(self) -> Iterator[Edge]:
        return iter(self._lanes)

    def __len__(self) -> int:
        return len(self._lanes)


class Shown:
    """Looks at a world for the policies; changes nothing."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.energy = Energy(world)
        lanes = world.traffic.lanes
        self.lasting_waits = Means(
            lanes, lambda lane: lane.blocked / (lane.passages + 1) + lane.end.blocked / (lane.end.passages + 1)
        )
        self.lasting_collisions = Means(
            lanes, lambda lane: lane.waits / (lane.passages + 1) + lane.end.waits / (lane.end.passages + 1)
        )
        self._streams: dict[str, Generator] = {}
        model = world.model
        self.handling = Handling(
            model.tasks.load_time,
            model.tasks.unload_time,
            model.tasks.clear_time,
            model.cost.distance,
            model.cost.time,
            model.cost.collisions,
        )

    def situation(self) -> Situation:
        """What the allocation policy decides on."""
        world, dispatcher = self.world, self.world.dispatcher
        graph = world.layout.graph
        return Situation(
            time=world.env.now,
            robots=[dispatcher.free[number][0].view() for number in sorted(dispatcher.free)],
            tasks=dispatcher.open.values(),
            travel=world.travel,
            station=self.station,
            feasible=self.feasible,
            allowed=self.allowed,
            fleet=self.fleet,
            waits=lambda: self.lasting_waits,
            collisions=lambda: self.lasting_collisions,
            random=lambda: self.random("allocation"),
            handling=self.handling,
            length=lambda edge: float(graph.edges[edge]["length"]),
        )

    def random(self, kind: str) -> Generator:
        """A policy's own stream."""
        if kind not in self._streams:
            self._streams[kind] = self.world.streams.stream(kind)
        return self._streams[kind]

    # Stations

    def station(self, robot: RobotView, task: Task) -> str:
        """Where a robot would unload a task, by tasks.station_choice; stations that are full are passed over.

        Ties go to the nearer one, then to the one named first. `random` draws once for each task, whoever gets it.
        """
        tasks, world = self.world.model.tasks, self.world
        nodes, choice = tasks.unload_at, tasks.station_choice
        if choice == "each":
            return nodes[robot.number % len(nodes)]
        if choice == "random":
            return nodes[int(world.streams.stream("station", task.number).integers(len(nodes)))]
        stations = world.stations
        open_ones = [node for node in nodes if node not in stations or stations[node].free > 0] or nodes
        if len(open_ones) == 1:
            return open_ones[0]
        ways, good = world.travel.ways, task.edge[1]
        if choice == "least-loaded":
            heading = world.dispatcher.heading
            least = min(heading[node] for node in open_ones)
            open_ones = [node for node in open_ones if heading[node] == least]
        return min(open_ones, key=lambda node: ways.time(good, node))

    def room(self, robot: RobotView, node: str) -> bool:
        """Whether a robot may set out for a station; one that stands in it leaves its place first."""
        station = self.world.stations.get(node)
        return station is None or station.free > 0 or self.world.robots[robot.number].docked is station

    # What a robot may take

    def feasible(self, robot: RobotView, task: Task) -> bool:
        """Whether there is room at the station and the charging policy lets the robot take the task."""
        return self.room(robot, self.station(robot, task)) and self.may_work(robot, task)

    def may_work(self, robot: RobotView, task: Task) -> bool:
        """Whether the robot's energy is above the critical level and, if looked ahead, lasts with the margin."""
        if self.world.model.battery is None:
            return True
        levels = self.world.decisions.levels(robot)
        if robot.energy <= levels.critical:
            return False
        if levels.margin is None:
            return True
        need = self.energy.need(robot, task, self.station(robot, task), levels.charger)
        return robot.energy - need >= levels.margin - EPS

    def lasts(self, robot: RobotView, task: Task) -> bool:
        """Whether the robot may take the task and, driving freely, will not have to give it back on the way."""
        if self.world.model.battery is None:
            return True
        levels = self.world.decisions.levels(robot)
        return robot.energy >= self.energy.enough(robot, task, self.station(robot, task), levels)

    def allowed(self, robots: Sequence[RobotView], tasks: Sequence[Task]) -> Any:
        """For all pairs, whether there is room at the station and the energy lasts: a row for each robot."""
        import numpy as np

        world, entries = self.world, self.world.model.tasks.unload_at
        table = np.ones((len(robots), len(tasks)), dtype=bool)
        each = world.model.tasks.station_choice == "each"
        keys = [robot.number % len(entries) if each else 0 for robot in robots]
        asking = dict(zip(keys, robots, strict=True))
        chosen = {key: [self.station(robot, task) for task in tasks] for key, robot in asking.items()}
        stations = [chosen[key] for key in keys]
        for i, robot in enumerate(robots if world.stations else ()):
            room = {node: self.room(robot, node) for node in dict.fromkeys(stations[i])}
            table[i] = [room[node] for node in stations[i]]
        if world.model.battery is None:
            return table
        levels = [world.decisions.levels(robot) for robot in robots]
        above = [i for i, level in enumerate(levels) if robots[i].energy > level.critical]
        if len(above) < len(robots):
            table[[i for i in range(len(robots)) if robots[i].energy <= levels[i].critical]] = False
        if above:
            some = [robots[i] for i in above]
            least = self.energy.least(some, tasks, [stations[i] for i in above], [levels[i] for i in above])
            table[above] &= np.array([robot.energy for robot in some])[:, None] >= least
        return table

    # The fleet

    def fleet(self) -> list[RobotView]:
        """All robots; those at work where, and about when, they will be free."""
        return [
            robot.view() if robot.number in self.world.dispatcher.free else self._busy(robot)
            for robot in self.world.robots
        ]

    def _busy(self, robot: Powered) -> RobotView:
        node, time = self.energy.free_at(robot)
        return robot.view(node=node, free=False, free_in=time)

    # Traffic

    def queued(self, edge: Edge) -> int:
        """Robots that wait on an edge now."""
        count, robot = 0, self.world.traffic.lanes[edge].last
        while robot is not None:
            count += robot.is_waiting
            robot = robot.ahead
        return count
