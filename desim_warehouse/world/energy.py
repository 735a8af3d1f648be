"""How much energy and time a robot's work will take, by free driving along the ways of the routing policy."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from desim_warehouse.layout.travel import Travel
from desim_warehouse.world.lanes import EPS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.policies import Levels, RobotView, Task
    from desim_warehouse.world.powered import Powered
    from desim_warehouse.world.world import World


class Energy:
    """Looks ahead; consumption by state as in the battery section of the model. Waiting is not foreseen."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.chargers = [bay.node for bay in world.parking.bays.values() if bay.chargers is not None]
        self.parking = [bay.node for bay in world.parking.bays.values() if bay.chargers is None]
        self.rates = world.robots[0].battery.rates
        self._travel = {world.travel.speed: world.travel}
        self._to_charger: dict[tuple[str, str, float], float] = {}

    def travel(self, speed: float) -> Travel:
        """Driving times of a robot with a speed."""
        if speed not in self._travel:
            known = self.world.travel
            self._travel[speed] = Travel(known.highways, speed, known.node_time, known.cost)
        return self._travel[speed]

    def to_charger(self, node: str, robot: RobotView, choice: str) -> float:
        """Driving time to the charger that a robot would go to; inf where there is none.

        `own`: its home's; `least-loaded`: the farthest one, as it may be any. Where places at chargers are scarce the
        way leads over the parking place from which all are reached soonest, as it may have to wait there first.
        """
        target = robot.home if choice == "own" and robot.home in self.chargers else choice
        key = node, target, robot.speed
        if key not in self._to_charger:
            ways = self.travel(robot.speed).ways
            if target == robot.home:
                time = ways.time(node, target)
            else:
                pick = max if choice == "least-loaded" else min
                time = pick((ways.time(node, charger) for charger in self.chargers), default=math.inf)
            if self.world.scarce and self.chargers:
                time = max(
                    time, min((ways.time(node, bay) + self.out_of(bay, robot) for bay in self.parking), default=0)
                )
            self._to_charger[key] = time
        return self._to_charger[key]

    def out_of(self, bay: str, robot: RobotView) -> float:
        """Time from resting in a parking place to the charger that is farthest from it."""
        ways = self.travel(robot.speed).ways
        return self.world.model.fleet.exit_time + max(ways.time(bay, charger) for charger in self.chargers)

    def rests_until(self, robot: RobotView, levels: Levels) -> float:
        """Battery level at which a robot that rests without a charger must set out for one."""
        if levels.margin is None or not self.chargers:
            return levels.critical
        return max(levels.critical, self.rates["empty"] * self.out_of(robot.node, robot) + levels.margin)

    def retreats_at(self, robot: RobotView, levels: Levels) -> float:
        """Battery level at which a robot that leaves its work goes to a charger."""
        if levels.margin is None:
            return levels.good
        way = self.to_charger(robot.node, robot, levels.charger)
        return max(levels.good, self.rates["empty"] * way + levels.margin)

    def need(self, robot: RobotView, task: Task, station: str, choice: str) -> float:
        """Energy that a task and the way to a charger after it draw from where and when the robot is free."""
        driven = self.travel(robot.speed).ways.time(robot.node, task.edge[0])
        return self.rates["empty"] * (
            robot.free_in + driven + self.to_charger(station, robot, choice)
        ) + self._from_edge(robot.speed, task, station)

    def enough(self, robot: RobotView, task: Task, station: str, levels: Levels) -> float:
        """Energy with which a robot, driving freely, does not have to give the task back on the way."""
        driven = robot.free_in + self.travel(robot.speed).ways.time(robot.node, task.edge[0])
        least = levels.critical + self.rates["empty"] * driven + EPS * robot.capacity
        if levels.margin is not None:
            least = max(least, self.need(robot, task, station, levels.charger) + levels.margin)
        return least

    def least(
        self,
        robots: Sequence[RobotView],
        tasks: Sequence[Task],
        stations: Sequence[Sequence[str]],
        levels: Sequence[Levels],
    ) -> Any:
        """`enough` for all pairs: an array with a row for each robot; `stations` those of each robot's tasks."""
        import numpy as np

        empty, starts = self.rates["empty"], [task.edge[0] for task in tasks]
        driven = np.empty((len(robots), len(tasks)))
        for speed in dict.fromkeys(robot.speed for robot in robots):
            these = [i for i, robot in enumerate(robots) if robot.speed == speed]
            driven[these] = self.travel(speed).times([robots[i].node for i in these], starts)
        driven += np.array([robot.free_in for robot in robots])[:, None]
        low = np.array([level.critical + EPS * robot.capacity for robot, level in zip(robots, levels, strict=True)])
        table = empty * driven + low[:, None]
        rest: dict[tuple[Any, ...], Any] = {}
        for i, (robot, nodes, level) in enumerate(zip(robots, stations, levels, strict=True)):
            if level.margin is None:
                continue
            key = robot.speed, id(nodes), level.charger, robot.home if level.charger == "own" else ""
            if key not in rest:
                rest[key] = np.array(
                    [
                        self._from_edge(robot.speed, task, node) + empty * self.to_charger(node, robot, level.charger)
                        for task, node in zip(tasks, nodes, strict=True)
                    ]
                )
            table[i] = np.maximum(table[i], empty * driven[i] + rest[key] + level.margin)
        return table

    def _from_edge(self, speed: float, task: Task, station: str) -> float:
        """Energy from the start of the good's edge to being clear of the station."""
        tasks, rates = self.world.model.tasks, self.rates
        edge, travel = self.world.layout.graph.edges[task.edge], self.travel(speed)
        pace = min(speed, edge["speed"])
        loaded = (edge["length"] - task.offset) / pace + travel.node_time + travel.ways.time(task.edge[1], station)
        return float(
            rates["empty"] * (task.offset / pace + tasks.clear_time)
            + rates["loading"] * (tasks.load_time + tasks.unload_time)
            + rates["loaded"] * loaded
        )

    def need_now(self, robot: Powered, choice: str) -> float:
        """Energy that a robot on the way to its good still needs for the task and the way to a charger after it."""
        assert robot.job is not None
        station = self.world.dispatcher.unload_at[robot.job.number]
        return self.need(robot.view(free_in=self.on_lane(robot)), robot.job, station, choice)

    def enough_for_first(self, robot: Powered, levels: Levels) -> float:
        """Battery level at which a robot in a bay may take the first open task; 0 where there is none."""
        task = next(iter(self.world.dispatcher.open.values()), None)
        if task is None:
            return 0.0
        view = robot.view()
        return self.enough(view, task, self.world.shown.station(view, task), levels)

    def on_lane(self, robot: Powered) -> float:
        """Free driving time to the node it comes to next, its node time included."""
        if robot.lane is None or robot.held is not None:
            return 0.0
        here = robot.position(self.world.env.now)
        return float((robot.lane.length - here) / robot.pace + self.world.travel.node_time)

    def free_at(self, robot: Powered) -> tuple[str, float]:
        """The node where a robot at work will be free, and the time until then, waiting not included."""
        world, ways = self.world, self.travel(robot.speed).ways
        tasks, now = world.model.tasks, world.env.now
        job, time = robot.job, self.on_lane(robot)
        if job is None:
            bay = robot.bay.node if robot.bay is not None else robot.home
            return bay, time + ways.time(robot.node, bay)
        station = world.dispatcher.unload_at[job.number]
        since = now - robot.since_state
        if robot.state in ("queueing", "unloading"):
            return station, max(tasks.unload_time - (since if robot.state == "unloading" else 0.0), 0.0)
        if robot.state == "loaded":
            return station, time + ways.time(robot.node, station) + tasks.unload_time
        edge = world.layout.graph.edges[job.edge]
        beyond = (edge["length"] - job.offset) / robot.speed + ways.time(job.edge[1], station) + tasks.unload_time
        if robot.state == "loading":
            return station, max(tasks.load_time - since, 0.0) + beyond
        on_edge = robot.lane is not None and robot.lane.edge == job.edge
        to_good = (
            max(time - (edge["length"] - job.offset) / robot.speed, 0.0)
            if on_edge
            else (time + ways.time(robot.node, job.edge[0]) + job.offset / robot.speed)
        )
        return station, to_good + tasks.load_time + beyond
