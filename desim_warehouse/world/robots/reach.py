"""Look-ahead for batteries (reach): the tasks that a robot may take, when it gives one back, when it must charge.

All decisions on energy are made here. They look ahead by free driving on the routes of the routing policy. Waiting is
not foreseen, and random handling times count with their mean. Energies are in the model's unit, consumption by state as
in the model's battery section.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from typing import Any

from desim_warehouse.feasibility.batteries import cause, too_small
from desim_warehouse.findings import amount
from desim_warehouse.layout import Layout
from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.model import Model
from desim_warehouse.model.facts.charging import LEAST_CHARGE, consumption
from desim_warehouse.policies import Handling, Levels, RobotView, Task
from desim_warehouse.world.places.bays import Bays
from desim_warehouse.world.places.cut_off import CutOff
from desim_warehouse.world.places.openings import Openings
from desim_warehouse.world.places.stations import Stations
from desim_warehouse.world.places.stops import Stop, driven, handled
from desim_warehouse.world.robots.levels import ChargingLevels
from desim_warehouse.world.traffic.events import Clock
from desim_warehouse.world.traffic.rules import EPS

MORE = 0.05
"""Extra energy, as a share of capacity, that a task requires for each further time that it was given back.

A look-ahead policy foresees free driving, but no repairs and jams. Where these use up its reserve, a robot would charge
just enough, set out and give the task back for ever, as in a random model with breakdowns that did not end.
"""

URGENT, AHEAD = 0.75, 0.5
"""Shares of the energy that a resting robot has beyond the way to a charger when it begins to seek one: the rest at
which its need is urgent, and the lead at which a robot being charged makes room for it.
"""


def suits(task: Task, kind: str, carries: Collection[str]) -> bool:
    """Whether a task, or each task of a tour, suits robots that carry some types of load (none: all types)."""
    if task.kinds and kind not in task.kinds:
        return False
    return not task.load_type or not carries or task.load_type in carries


def may_do(robot: RobotView, task: Task) -> bool:
    """Whether a robot is of a kind that does a task and carries its load, or all loads of a tour."""
    return suits(task, robot.kind, robot.carries) and (not task.members or len(task.members) <= robot.loads)


def loaded_time(travel: FreeTravel, task: Task, station: str) -> float:
    """Return the free driving time from the end of the edge of a task's good to where the robot is free again."""
    if task.drop is None:
        return travel.from_edge(task.edge, station)
    edge, offset = task.drop
    return travel.from_edge(task.edge, edge[0]) + travel.half_turn + math.fsum(travel.along(edge, offset))


class Reach:
    """The energy and time that work of robots of a `kind` will take, and the decisions that follow from it.

    `model` is taken as if all robots had this kind's battery. `levels` asks its charging policy. `open_tasks` is the
    list of open tasks, in order. If robots charge alike one object serves all kinds.
    """

    def __init__(
        self,
        env: Clock,
        model: Model,
        layout: Layout,
        travel: FreeTravel,
        levels: ChargingLevels,
        kind: str = "",
        *,
        stations: Stations,
        bays: Bays,
        open_tasks: Collection[Task],
        handling: Handling[float],
        cut_off: CutOff,
    ) -> None:
        self.battery = model.battery
        self.batteries = model.battery is not None
        self._model, self._layout, self._kind = model, layout, kind
        self.tasks = model.tasks
        self.tours = model.pods is not None or model.tasks.has_via or model.policies.batching.name != "single"
        self.kinds = self.tours or any(flow.kinds or flow.load_type for flow in model.tasks.flows.values())
        self.flows = bool(model.tasks.flows)
        self.handling = handling
        self.exit_time = model.fleet.exit_time
        self.length = layout.length
        self.levels = levels
        self.consumption = consumption(model.battery)
        self.stations = stations
        self.open_tasks = open_tasks
        self.chargers = [bay.node for bay in bays.by_node.values() if kind in bay.charges]
        self.parking = [bay.node for bay in bays.by_node.values() if kind not in bay.charges]
        self.scarce = bays.chargers_are_scarce(kind, Counter(model.fleet.kinds_of_robots()))
        self._loaded_speeds = [robot.loaded_speed for robot in model.fleet.robots()]
        self.openings = Openings(env, stations, cut_off, handling, self.travel, self.loaded_speed)
        self._known = travel
        self._travel = {travel.speed: travel}
        self._given_back: Counter[int] = Counter()
        self._to_charger: dict[tuple[str, str, float], float] = {}
        self._out_of: dict[tuple[str, float], float] = {}
        self._rests_elsewhere: dict[tuple[str, Levels], float] = {}
        self._onward: dict[int, dict[tuple[str, float, float, str, str], tuple[float, float]]] = {}

    def share(self, other: Reach) -> None:
        """Share with another kind the tasks given back, and those that wait for places to open."""
        self._given_back, self.openings = other._given_back, other.openings

    def why_flat(self, started: float | None, drew: float, robot: RobotView, *, resting: bool) -> str:
        """Return why a robot's battery ran flat in this model, and a remedy (for the arguments see `cause`)."""
        text = cause(self._model, self._layout, started, kind=self._kind, drew=drew, resting=resting)
        if resting and self.chargers:
            way, level = (
                self.consumption.empty * self.out_of(robot.node, robot),
                self.rests_until(robot, self.levels(robot)),
            )
            if level < way:
                text += f"; it seeks a charger at {amount(level)}, and the farthest is {amount(way)} away"
        return text

    def why_none_lasts(self, robots: Iterable[RobotView], task: Task) -> str:
        """Return in words the energy that robots have and need for a task that exceeds all batteries, and a remedy."""
        able = [robot for robot in robots if may_do(robot, task)]
        best = min(able, key=lambda robot: self.missing(robot, task))
        levels = self.levels(best)
        kept = f", with {amount(levels.margin)} kept back" if levels.margin else ""
        has = f"robot {best.number} has {amount(best.energy)}, and needs {amount(self._enough_now(best, task))} for it"
        if not self.chargers:
            return f"{has}{kept}; {cause(self._model, self._layout, kind=self._kind)}"
        if small := too_small(self._model, self._model.floor):
            return f"{small}; {has}{kept}"
        return (
            f"{has}{kept}; charging ends at {amount(levels.full)} (policies.charging); a larger battery, or levels and "
            "a margin that let it take the task"
        )

    def missing(self, robot: RobotView, task: Task) -> float:
        """Return the energy that a robot lacks for a task; if negative, its spare energy."""
        return self._enough_now(robot, task) - robot.energy

    def _enough_now(self, robot: RobotView, task: Task) -> float:
        return self.enough(robot, task, self.stations.choose(robot, task), self.levels(robot))

    # What a robot may take

    def feasible(self, robot: RobotView, task: Task) -> bool:
        """Whether the station has room and is open in time, and the charging policy lets the robot take the task."""
        station = self._station_for(robot, task)
        return station is not None and self.may_take(robot, task, station)

    def may(self, robot: RobotView, task: Task) -> bool:
        """Whether a robot may take a task, by the rule of `allowed` for a single pair."""
        station = self._station_for(robot, task)
        if station is None or not self.batteries:
            return station is not None
        return robot.energy >= self.enough(robot, task, station, self.levels(robot))

    def _station_for(self, robot: RobotView, task: Task) -> str | None:
        """Return where a robot would unload a task; None if there is no room, or the station opens too late."""
        if not may_do(robot, task):
            return None
        station = self.stations.choose(robot, task)
        room = self.stations.has_room(robot, task, station) and self.openings.admit(robot, task, station)
        return station if room else None

    def may_take(self, robot: RobotView, task: Task, station: str) -> bool:
        """Whether the charging policy lets the robot take the task and bring it to a station.

        With foresight (`Levels.margin`), by the rule that lets the robot keep it on the way. Without a margin, as in
        the paper, a robot above the critical level takes any task.
        """
        if not self.batteries:
            return True
        levels = self.levels(robot)
        if levels.margin is None:
            return robot.energy > levels.critical
        return robot.energy >= self.enough(robot, task, station, levels) - EPS

    def lasts(self, robot: RobotView, task: Task) -> bool:
        """Whether the robot may take the task and, driving freely, will not have to give it back on the way."""
        if not self.batteries:
            return True
        return robot.energy >= self._enough_now(robot, task)

    def allowed(self, robots: Sequence[RobotView], tasks: Sequence[Task]) -> Any:
        """Return, for all pairs, whether the station has room and the energy suffices: a row for each robot."""
        import numpy as np

        table = np.ones((len(robots), len(tasks)), dtype=bool)
        if not table.size:
            return table
        if self.kinds:
            shapes = [(robot.kind, robot.carries, robot.loads) for robot in robots]
            alike = dict(zip(shapes, robots, strict=True))
            fit = {shape: [may_do(robot, task) for task in tasks] for shape, robot in alike.items()}
            table &= np.array([fit[shape] for shape in shapes])
        levels = [self.levels(robot) for robot in robots] if self.batteries else []
        stations = self.stations
        if stations.full or self.openings.holds or any(level.margin is not None for level in levels):
            chosen = self._stations_of(robots, tasks)
        else:
            chosen = [[]] * len(robots)  # not read then
        rooms: dict[tuple[int, str], list[bool]] = {}
        for i, robot in enumerate(robots if stations.full else ()):
            key = id(chosen[i]), stations.holding(robot.number)
            if key not in rooms:
                rooms[key] = self._have_room(robot, tasks, chosen[i])
            table[i] &= rooms[key]
        for i, robot in enumerate(robots if self.openings.holds else ()):
            table[i] &= [self.openings.admit(robot, *pair) for pair in zip(tasks, chosen[i], strict=True)]
        if not (self.batteries and table.any()):
            return table
        above = [i for i, level in enumerate(levels) if robots[i].energy > level.critical]
        if len(above) < len(robots):
            table[[i for i in range(len(robots)) if robots[i].energy <= levels[i].critical]] = False
        if above:
            some = [robots[i] for i in above]
            least = self._enough_for_all(some, tasks, [chosen[i] for i in above], [levels[i] for i in above])
            table[above] &= np.array([robot.energy for robot in some])[:, None] >= least
        return table

    def _have_room(self, robot: RobotView, tasks: Sequence[Task], nodes: Sequence[str]) -> list[bool]:
        """Return for each task whether there is room where it is loaded and unloaded."""
        full, has_room = self.stations.full, self.stations.has_room
        return [
            (node not in full and task.edge[0] not in full and not task.is_tour) or has_room(robot, task, node)
            for task, node in zip(tasks, nodes, strict=True)
        ]

    def _first(self, robot: RobotView) -> Task | None:
        """Return the first open task that a robot of this kind may do."""
        if not self.kinds:
            return next(iter(self.open_tasks), None)
        return next((task for task in self.open_tasks if may_do(robot, task)), None)

    def _stations_of(self, robots: Sequence[RobotView], tasks: Sequence[Task]) -> list[list[str]]:
        """Return the station of every pair. Robots whose tasks go to the same stations share one list."""
        each = self.stations.choice == "each" and len(self.stations.nodes) > 1
        keys = [robot.number % len(self.stations.nodes) if each else 0 for robot in robots]
        asking = dict(zip(keys, robots, strict=True))
        chosen = {key: [self.stations.choose(robot, task) for task in tasks] for key, robot in asking.items()}
        return [chosen[key] for key in keys]

    # When it must charge

    def must_charge(self, robot: RobotView) -> bool:
        """Whether a robot's energy, below full, is too low for the first open task."""
        task = self._first(robot)
        if task is None or robot.energy >= self.levels(robot).full - EPS * robot.capacity:
            return False
        return not self.lasts(robot, task)

    def enough_for_first(self, robot: RobotView, levels: Levels) -> float:
        """Return the level at which a robot in a bay may take the first open task; 0 if there is none."""
        task = self._first(robot)
        return 0.0 if task is None else self.enough(robot, task, self.stations.choose(robot, task), levels)

    def enough_after_parking(self, robot: RobotView, levels: Levels) -> float:
        """Return the level at which a robot at a charger may take the first open task even from any bay without one.

        With less it would drive there, be too low for the task, and return.
        """
        task = self._first(robot)
        if task is None:
            return 0.0
        station = self.stations.choose(robot, task)
        return max(
            self.consumption.empty * self.out_to(robot, bay)
            + self.enough(robot._replace(node=bay), task, station, levels)
            for bay in (robot.node, *self.parking)
        )

    def rests_until(self, robot: RobotView, levels: Levels) -> float:
        """Return the level at which a robot that rests without a charger must leave for one."""
        if levels.margin is None or not self.chargers:
            return levels.critical
        return max(levels.critical, self.consumption.empty * self.out_of(robot.node, robot) + levels.margin)

    def rests_elsewhere_from(self, robot: RobotView, levels: Levels) -> float:
        """Return the level at which a robot can leave its charger for any bay without one, and rest there."""
        key = robot.node, levels
        if key not in self._rests_elsewhere:
            needed = (
                self.consumption.empty * self.out_to(robot, bay) + self.rests_until(robot._replace(node=bay), levels)
                for bay in self.parking
            )
            self._rests_elsewhere[key] = min(levels.full, max(needed, default=0.0))
        return self._rests_elsewhere[key]

    def in_need(self, robot: RobotView, levels: Levels) -> tuple[float, float]:
        """Return the level below which a resting robot needs a charger more than one that is being charged.

        Return also by how much the other's level must exceed its own, so that a fleet that runs low all at once can
        take turns before any robot is too low to reach a charger.
        """
        capacity = robot.capacity
        way = self.consumption.empty * self.out_of(robot.node, robot)
        spare = max(self.rests_until(robot, levels) - way, 0.0)
        return way + URGENT * spare, max(AHEAD * spare, LEAST_CHARGE * capacity)

    def retreats_at(self, robot: RobotView, levels: Levels) -> float:
        """Return the level at which a robot that leaves its work goes to a charger."""
        if levels.margin is None:
            return levels.good
        way = self.to_charger(robot.node, robot, levels.charger) + self.travel(robot.speed).stop_time
        return max(levels.good, self.consumption.empty * way + levels.margin)

    # Energies of a task

    def need(
        self, robot: RobotView, task: Task, station: str, choice: str, stops: Sequence[Stop] | None = None
    ) -> float:
        """Return the energy for a task, and for the way to a charger after it, from where and when the robot is free.

        `stops` are those of a tour in hand; by default, those that the robot would choose now.
        """
        travel = self.travel(robot.speed)
        driven = travel.half_turn + travel.to_edge(robot.node, task.edge)
        if task.is_tour:
            way, drawn = self.to_charger(station, robot, choice), self._from_edge(robot, task, station, stops)
        else:
            way, drawn = self._from_edge_on(robot, task, station, choice)
        return self.consumption.empty * (robot.free_in + driven + way) + drawn

    def enough(self, robot: RobotView, task: Task, station: str, levels: Levels) -> float:
        """Return the energy with which a robot, driving freely, does not have to give the task back on the way."""
        travel = self.travel(robot.speed)
        driven = robot.free_in + (travel.half_turn + travel.to_edge(robot.node, task.edge))
        empty = self.consumption.empty
        least = levels.critical + empty * driven + EPS * robot.capacity
        if levels.margin is not None:
            way, drawn = self._from_edge_on(robot, task, station, levels.charger)
            least = max(least, empty * (driven + way) + drawn + levels.margin)
        return self._with_more(least, robot, task, levels)

    def _with_more(self, least: float, robot: RobotView, task: Task, levels: Levels) -> float:
        """Return a task's energy need by experience: more if it was given back before, up to a full battery."""
        again = self._given_back[task.number] - 1
        return least if again <= 0 else max(least, min(least + again * MORE * robot.capacity, levels.full))

    def give_back(self, task: Task) -> int:
        """Note that a robot gives back a task that looked possible, and return the number of times so far.

        Waits or repairs that upset the plan do so again, so from the second time on more energy is required.
        """
        self._given_back[task.number] += 1
        return self._given_back[task.number]

    def _enough_for_all(
        self,
        robots: Sequence[RobotView],
        tasks: Sequence[Task],
        stations: Sequence[Sequence[str]],
        levels: Sequence[Levels],
    ) -> Any:
        """Compute `enough` for all pairs: an array with a row for each robot; `stations`: of each robot's tasks."""
        import numpy as np

        empty, edges = self.consumption.empty, [task.edge for task in tasks]
        driven = np.empty((len(robots), len(tasks)))
        for speed in dict.fromkeys(robot.speed for robot in robots):
            these = [i for i, robot in enumerate(robots) if robot.speed == speed]
            travel = self.travel(speed)
            driven[these] = travel.half_turn + travel.to_edges([robots[i].node for i in these], edges)
        driven += np.array([robot.free_in for robot in robots])[:, None]
        low, least = np.array(
            [(level.critical, EPS * view.capacity) for view, level in zip(robots, levels, strict=True)]
        ).T
        table = low[:, None] + empty * driven + least[:, None]
        rest: dict[tuple[Any, ...], Any] = {}
        for i, (robot, nodes, level) in enumerate(zip(robots, stations, levels, strict=True)):
            if level.margin is None:
                continue
            speeds = robot.speed, self.loaded_speed(robot)
            key = speeds, id(nodes), level.charger, robot.home if level.charger == "own" else ""
            if key not in rest:
                rest[key] = np.array(
                    [
                        self._from_edge_on(robot, task, node, level.charger)
                        for task, node in zip(tasks, nodes, strict=True)
                    ]
                ).T
            way, drawn = rest[key]
            table[i] = np.maximum(table[i], empty * (driven[i] + way) + drawn + level.margin)
        for j, task in enumerate(tasks if self._given_back else ()):
            if self._given_back[task.number] > 1:
                column = zip(table[:, j], robots, levels, strict=True)
                table[:, j] = [self._with_more(least, robot, task, level) for least, robot, level in column]
        return table

    def _from_edge_on(self, robot: RobotView, task: Task, station: str, choice: str) -> tuple[float, float]:
        """Return the driving time to a charger after a task, and the energy from its good's edge until then.

        The result is kept until the task is done, except for a tour with a choice of stops, which may differ next time.
        """
        kept = self._onward.setdefault(task.number, {})
        key = station, robot.speed, self.loaded_speed(robot), choice, robot.home if choice == "own" else ""
        if key not in kept:
            way = self.to_charger(station, robot, choice)
            drawn = self._from_edge(robot, task, station)
            if task.is_tour and not self.stations.is_settled(task):
                return way, drawn
            kept[key] = way, drawn
        return kept[key]

    def forget(self, task: Task) -> None:
        """Forget a task that is done or given back."""
        self._onward.pop(task.number, None)

    def _from_edge(self, robot: RobotView, task: Task, station: str, stops: Sequence[Stop] | None = None) -> float:
        """Return the energy from the start of the good's edge until the robot is clear of the station.

        Where its heading is unknown, before it sets out from a stand in the lane or a good at a node, a half turn is
        counted.
        """
        clear, drawn = self.handling.clear_time, self.consumption
        travel, with_load = self.travel(robot.speed), self.travel(self.loaded_speed(robot))
        before, after = travel.along(task.edge, task.offset)[0], with_load.along(task.edge, task.offset)[1]
        unknown = with_load.half_turn if task.edge[0] == task.edge[1] else with_load.stop_time
        if task.is_tour:
            stops = self.stations.stops(robot, task) if stops is None else stops
            return float(
                drawn.empty * (before + (clear + travel.half_turn))
                + drawn.handling * handled(self.handling, stops)
                + drawn.loaded * (driven(with_load, stops) + unknown)
            )
        return float(
            drawn.empty * (before + (clear + travel.half_turn))
            + drawn.handling * math.fsum(self.handling.times(task, station))
            + drawn.loaded * (after + (loaded_time(with_load, task, station) + unknown))
        )

    def tour_time(self, robot: RobotView, task: Task) -> float:
        """Return the time of a tour from standing at its first good to where it ends, driving freely."""
        stops = self.stations.stops(robot, task)
        return float(driven(self.travel(self.loaded_speed(robot)), stops) + handled(self.handling, stops))

    # Driving times

    def travel(self, speed: float) -> FreeTravel:
        """Return the driving times of a robot with a speed."""
        if speed not in self._travel:
            self._travel[speed] = self._known.at(speed)
        return self._travel[speed]

    def loaded_speed(self, robot: RobotView) -> float:
        """Return a robot's speed with a load."""
        return self._loaded_speeds[robot.number]

    def to_charger(self, node: str, robot: RobotView, choice: str) -> float:
        """Return the driving time to the charger that a robot would go to, inf where there is none.

        With `own` that is its home's charger, with `least-loaded` the farthest, as it may be any. Where slots at
        chargers are scarce the way leads over the parking slot from which all are reached soonest, as the robot may
        have to wait there first.
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
            if self.scarce and self.chargers:
                time = max(
                    time, min((ways.time(node, bay) + self.out_of(bay, robot) for bay in self.parking), default=0)
                )
            self._to_charger[key] = time
        return self._to_charger[key]

    def out_of(self, bay: str, robot: RobotView) -> float:
        """Return the time from resting in a parking slot to the charger that is farthest from it."""
        key = bay, robot.speed
        if key not in self._out_of:
            self._out_of[key] = max(self.out_to(robot, charger, bay) for charger in self.chargers)
        return self._out_of[key]

    def out_to(self, robot: RobotView, node: str, bay: str | None = None) -> float:
        """Return the time from resting in a bay (its own or `bay`) to a node."""
        travel = self.travel(robot.speed)
        return self.exit_time + travel.ways.time(robot.node if bay is None else bay, node) + travel.stop_time
