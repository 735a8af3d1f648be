"""The World: everything of one run, put together from a model and a seed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import simpy
from simpy.events import URGENT, Timeout

from desim_warehouse import layout as floor
from desim_warehouse.errors import LayoutError, StallError
from desim_warehouse.layout import checks
from desim_warehouse.layout.travel import travel_on
from desim_warehouse.log import Log
from desim_warehouse.policies import create
from desim_warehouse.world.bays import Bay, Parking, Station
from desim_warehouse.world.decisions import Decisions
from desim_warehouse.world.demand import Demand
from desim_warehouse.world.dispatch import Dispatcher
from desim_warehouse.world.robot import Robot
from desim_warehouse.world.shown import Shown
from desim_warehouse.world.streams import Streams
from desim_warehouse.world.traffic import Traffic

if TYPE_CHECKING:
    from desim_warehouse.model import Model
    from desim_warehouse.world.powered import Powered


class World:
    """One run: `World(model, seed).run()`, then look at `log`, `robots` and `traffic`.

    With `ask` the run stops at every allocation decision: `begin()`, then `go_on()` until it returns False, and
    `dispatcher.decide(pairs)` in between.
    """

    def __init__(self, model: Model, seed: int = 0, *, ask: bool = False) -> None:
        self.model = model
        self.streams = Streams(seed)
        self.env = simpy.Environment()
        self.layout = floor.build(model.layout)
        self.log = Log(model.log)
        self.finished = simpy.Event(self.env)
        self.out = 0
        self._before: list[dict[int, dict[str, Any]]] | None = None
        fleet = model.fleet
        use = checks.Use(fleet.contact, fleet.size, fleet.start, model.tasks.unload_at)
        if problems := checks.faults(self.layout, use):
            raise LayoutError(problems)
        kinds = set(fleet.robots())
        self.traffic = Traffic(
            self.env,
            self.layout,
            self.log,
            contact=fleet.contact,
            theta=math.radians(model.traffic.collision_angle),
            node_time=model.traffic.node_time,
            mixed=len(kinds) > 1 or any(math.isfinite(speed) for *_, speed in self.layout.graph.edges(data="speed")),
            rotate=model.traffic.gridlock == "rotate",
        )
        self.decisions = Decisions(self)
        self.travel = travel_on(
            self.layout,
            max(robot.speed for robot in kinds),
            model.traffic.node_time,
            self.decisions.cost,
            (*self.layout.bays, *self.layout.stations, *model.tasks.unload_at),
        )
        self.stations = {
            node: Station(self.env, node, item.places, item.servers) for node, item in self.layout.stations.items()
        }
        self.robots = self._fleet()
        self.demand = Demand(self)
        self.scarce = self.parking.scarce(len(self.robots))
        self.shown = Shown(self)
        policy = model.policies.allocation
        self.dispatcher = Dispatcher(self, None if ask else create("allocation", policy.name, policy.params))

    def _fleet(self) -> list[Robot]:
        """Bays with their places, and in them the robots, dealt out over the start nodes in turn."""
        fleet = self.model.fleet
        start = fleet.start or tuple(self.layout.bays)
        homes = [start[number % len(start)] for number in range(fleet.size)]
        bays = []
        for node, item in self.layout.bays.items():
            places = homes.count(node) if item.places is None else item.places
            chargers = places if item.chargers is None else item.chargers
            bays.append(Bay(self.env, node, places, chargers))
        self.parking = Parking(bays)
        robots = []
        for number, (shape, home) in enumerate(zip(fleet.robots(), homes, strict=True)):
            robot = Robot(self, number, home, shape.speed)
            self.parking.settle(robot, self.parking.bays[home])
            robots.append(robot)
        return robots

    # The run

    def run(self) -> World:
        """Simulate until all goods are delivered and all robots back in a bay, or for the length of the run."""
        self.begin()
        self.go_on()
        return self

    def begin(self) -> None:
        """Set everything going at time 0."""
        env, length = self.env, self.model.run.length
        self.demand.start()
        for robot in self.robots:
            env.process(robot.life())
        if self.model.run.warm_up:
            Timeout(env, self.model.run.warm_up).callbacks.append(lambda _: self._count_from_here())
        if self.demand.total is None:
            assert length is not None
            self.over = simpy.Event(env)
            self.over._ok, self.over._value = True, None
            env.schedule(self.over, URGENT, length)
        else:
            self.over = self.finished if length is None else self.finished | Timeout(env, length)

    def go_on(self) -> bool:
        """Simulate up to the next decision that is asked for (True), or to the end (False)."""
        env = self.env
        try:
            env.run(until=self.over)
        except RuntimeError as error:
            if env.peek() == math.inf:
                raise StallError(self._stalled()) from error
            raise
        if self.dispatcher.waiting:
            return True
        self.close()
        return False

    def close(self) -> None:
        """Bring all tallies up to the present, less what was counted before the warm-up ended."""
        log, now = self.log, self.env.now
        self.traffic.end_waits(self.robots)
        for robot in self.robots:
            robot.enter(robot.state)
        before = self._before or [{} for _ in range(3)]
        log.robots, log.edges, log.nodes = (
            [_less(row, earlier.get(i)) for i, row in enumerate(rows)]
            for rows, earlier in zip(self._tallies(), before, strict=True)
        )
        log.close(now)

    def _count_from_here(self) -> None:
        for robot in self.robots:
            robot.enter(robot.state)
        self.log.begin = self.env.now
        self._before = [dict(enumerate(rows)) for rows in self._tallies()]

    def _tallies(self) -> tuple[list[dict[str, Any]], list[dict[str, Any]], list[dict[str, Any]]]:
        now = self.env.now
        edges = [
            {"edge": ">".join(edge), "passages": lane.passages, "waits": lane.waits, "blocked": lane.blocked}
            for edge, lane in self.traffic.lanes.items()
        ]
        nodes = [
            {
                "node": "+".join(node.nodes),
                "passages": node.passages,
                "waits": node.waits,
                "blocked": node.blocked,
            }
            for node in dict.fromkeys(self.traffic.nodes.values())
        ]
        return [robot.tally(now) for robot in self.robots], edges, nodes

    def came_home(self) -> None:
        """A robot is back in a bay; the last one to be so, with all goods delivered, ends the run."""
        self.out -= 1
        if not self.out and self.dispatcher.done == self.demand.total:
            self.finished.succeed()

    def _stalled(self) -> str:
        blocked = "; ".join(
            f"robot {robot.number} {robot.place(self.env.now)}" for robot in self.robots if robot.lane is not None
        )
        return (
            f"stalled at time {self.env.now:g}: {self.dispatcher.done} of {self.demand.total} tasks are done and "
            f"nothing is scheduled; on the lanes: {blocked or 'nobody'}; "
            f"open tasks: {list(self.dispatcher.open)[:10]}{self._unable()}"
        )

    def _unable(self) -> str:
        """Why nobody takes the first open task, if it is for the battery."""
        task = next(iter(self.dispatcher.open.values()), None)
        if task is None or any(self.shown.lasts(robot.view(), task) for robot in self.robots):
            return ""
        charging = self.model.policies.charging.name
        return f"; no robot's battery lasts for task {task.number}, by policies.charging ({charging})"

    # What robots ask

    def record(self, kind: str, robot: Powered) -> None:
        """A row of the log: what a robot does, with its energy."""
        energy = None if robot.battery.spec is None else robot.battery.level(self.env.now)
        self.log.event(self.env.now, kind, robot.number, robot.task, robot.node, energy)


def _less(row: dict[str, Any], earlier: dict[str, Any] | None) -> dict[str, Any]:
    """A row of tallies, less what it was earlier."""
    if earlier is None:
        return row
    return {key: value if isinstance(value, str) else value - earlier[key] for key, value in row.items()}
