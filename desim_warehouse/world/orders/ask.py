"""The charging, parking and allocation policies: what they are shown, and their answers checked."""

from __future__ import annotations

import traceback
from typing import TYPE_CHECKING, Any, TypeVar

from desim_warehouse.errors import PASSED_ON, PolicyError, WarehouseError, shown
from desim_warehouse.model.stations import flow_times, own_times
from desim_warehouse.policies import BayView, Handling, Levels, Situation
from desim_warehouse.values.distributions import mean_of
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from numpy.random import Generator
    from simpy import Environment

    from desim_warehouse.layout import Layout
    from desim_warehouse.layout.travel import FreeTravel
    from desim_warehouse.model import Model
    from desim_warehouse.policies import RobotView, Task
    from desim_warehouse.values.streams import Streams
    from desim_warehouse.world.orders.routes import Routes
    from desim_warehouse.world.places.bays import Bay
    from desim_warehouse.world.robots.reach import Reach

Answer = TypeVar("Answer")


def asked(kind: str, policy: object, now: float, ask: Callable[[], Answer]) -> Answer:
    """The answer of a policy. What it raises becomes a PolicyError that says where."""
    try:
        return ask()
    except (WarehouseError, *PASSED_ON):
        raise
    except BaseException as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        raise PolicyError(
            f"policies.{kind} ({type(policy).__name__}) at time {now:g}: raised {shown(error)} "
            f"in {last.filename}, line {last.lineno}"
        ) from error


class ChargingLevels:
    """Asks the charging policy for the battery levels that hold for a robot, only once if they are the same for all."""

    def __init__(self, env: Environment, policy: Any) -> None:
        self.env = env
        self.policy = policy
        self._fixed: Levels | None = None

    def of(self, view: Callable[[], RobotView]) -> Levels:
        """Those of a robot, which is looked at only if they depend on what it does."""
        return self._fixed or self(view())

    def __call__(self, robot: RobotView) -> Levels:
        """The levels, checked."""
        if self._fixed is not None:
            return self._fixed
        policy = self.policy
        levels: object = asked("charging", policy, self.env.now, lambda: policy.levels(robot))
        fault = levels.fault() if isinstance(levels, Levels) else f"{shown(levels)} are no Levels"
        if fault is None and isinstance(levels, Levels):
            self._fixed = levels if getattr(policy, "fixed", False) else None
            return levels
        raise PolicyError(
            f"policies.charging ({type(policy).__name__}) at time {self.env.now:g}, robot {robot.number}: {fault}"
        )


class BayChoice:
    """Where a robot goes that leaves its work: to a charger if its battery wants one, else by the parking policy."""

    def __init__(self, env: Environment, policy: Any, travel: FreeTravel, reach: Reach) -> None:
        self.env = env
        self.policy = policy
        self.travel = travel
        self.reach = reach

    def choose(self, robot: RobotView, bays: Sequence[Bay], *, must_charge: bool) -> Bay:
        """One of the `bays` in which it may reserve a slot. With `must_charge` it charges at any level."""
        if self.reach.batteries:
            levels = self.reach.levels(robot)
            if must_charge or robot.energy <= self.reach.retreats_at(robot, levels) + EPS * robot.capacity:
                chargers = [bay for bay in bays if bay.chargers is not None]
                if chargers:
                    return self._charger(robot, levels.charger, chargers)
                if self.reach.chargers:
                    return self._near_chargers(robot, bays)
        return self.parking(robot, bays)

    def parking(self, robot: RobotView, bays: Sequence[Bay]) -> Bay:
        """One of `bays` by the parking policy."""
        policy, now = self.policy, self.env.now
        views = [_view(bay) for bay in bays]
        node = asked("parking", policy, now, lambda: policy.choose(robot, views, self.travel))
        for bay in bays:
            if bay.node == node:
                return bay
        raise PolicyError(
            f"policies.parking ({type(policy).__name__}) at time {now:g}: "
            f"{shown(node)} is no bay with a free slot for robot {robot.number}"
        )

    def _near_chargers(self, robot: RobotView, bays: Sequence[Bay]) -> Bay:
        """All chargers are taken: wait where they are near."""
        ways = self.travel.ways
        return min(bays, key=lambda bay: ways.time(robot.node, bay.node) + self.reach.out_of(bay.node, robot))

    def _charger(self, robot: RobotView, choice: str, bays: Sequence[Bay]) -> Bay:
        """The charger of its home, the nearest one, or that with the fewest robots for each of its chargers."""
        if choice == "own":
            for bay in bays:
                if bay.node == robot.home:
                    return bay

        def rank(bay: Bay) -> tuple[float, float]:
            time = self.travel.ways.time(robot.node, bay.node)
            assert bay.chargers is not None
            return (bay.taken / bay.chargers.capacity if choice == "least-loaded" else 0.0), time

        return min(bays, key=rank)


def _view(bay: Bay) -> BayView:
    return BayView(bay.node, bay.free, 0 if bay.chargers is None else int(bay.chargers.capacity), bay.taken)


def handling_of(model: Model, layout: Layout) -> Handling:
    """The handling times of a model as policies and estimates use them: the mean of times that vary."""
    tasks, cost = model.tasks, model.cost
    flows = {name: flow_times(tasks, flow) for name, flow in tasks.flows.items()}
    visits = {name: mean_of(flow.stop_time) for name, flow in tasks.flows.items() if flow.stop_time != 0}
    return Handling(
        tasks.mean_load,
        tasks.mean_unload,
        tasks.clear_time,
        cost.distance,
        cost.time,
        cost.collisions,
        flows,
        visits,
        own_times(model, layout),
    )


class Situations:
    """Builds what the allocation policy decides on."""

    def __init__(
        self,
        env: Environment,
        layout: Layout,
        travel: FreeTravel,
        *,
        routes: Routes,
        reach: Reach,
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
        """The situation at present, with the `free` robots by number and the whole `fleet`."""
        reach, routes = self.reach, self.routes
        return Situation(
            time=self.env.now,
            robots=free,
            tasks=self._tasks(free),
            travel=self.travel,
            station=reach.stations.choose,
            feasible=reach.feasible,
            allowed=reach.allowed,
            fleet=fleet,
            waits=lambda: routes.waits,
            collisions=lambda: routes.collisions,
            random=lambda: self._random("allocation"),
            handling=self.handling,
            length=self._length,
            tour_time=reach.tour_time,
        )

    def _tasks(self, free: Sequence[RobotView]) -> Collection[Task]:
        """The open tasks, without those that are held back as a station is closed."""
        tasks = self.open_tasks.values()
        return self.reach.openings.for_somebody(free, tasks) if self.reach.stations.close else tasks

    def _random(self, kind: str) -> Generator:
        """A policy's own stream."""
        if kind not in self._generators:
            self._generators[kind] = self.streams.stream(kind)
        return self._generators[kind]
