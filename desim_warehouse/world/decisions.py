"""The policies of a run, asked and their answers checked: the way, the battery levels, the bay."""

from __future__ import annotations

import itertools
import traceback
from typing import TYPE_CHECKING, TypeVar

from desim_warehouse.errors import PolicyError, WarehouseError
from desim_warehouse.policies import BayView, Levels, Roads, create
from desim_warehouse.world.lanes import EPS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from desim_warehouse.layout.travel import Cost
    from desim_warehouse.policies import RobotView
    from desim_warehouse.world.bays import Bay
    from desim_warehouse.world.lanes import Lane
    from desim_warehouse.world.powered import Powered
    from desim_warehouse.world.world import World

Answer = TypeVar("Answer")


def asked(kind: str, policy: object, now: float, ask: Callable[[], Answer]) -> Answer:
    """The answer of a policy; what it raises becomes a PolicyError that says where."""
    try:
        return ask()
    except WarehouseError:
        raise
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        raise PolicyError(
            f"policies.{kind} ({type(policy).__name__}) at time {now:g}: raised {error!r} "
            f"in {last.filename}, line {last.lineno}"
        ) from error


class Decisions:
    """Asks the routing, charging and parking policies of a model."""

    def __init__(self, world: World) -> None:
        self.world = world
        policies = world.model.policies
        self.routing = create("routing", policies.routing.name, policies.routing.params)
        self.charging = create("charging", policies.charging.name, policies.charging.params)
        self.parking = create("parking", policies.parking.name, policies.parking.params)
        self.cost: Cost = getattr(self.routing, "cost", "time")
        self.detours = int(getattr(self.routing, "detours", 0))
        self._fixed = type(self.routing).__module__.startswith("desim_warehouse.") and not self.detours
        self._ways: dict[tuple[str, str], list[Lane]] = {}
        self._levels: dict[tuple[float, float], Levels] = {}
        self._roads: Roads | None = None

    # The way

    def roads(self) -> Roads:
        """The Highways as they are now."""
        if self._roads is None:
            world = self.world
            travel = world.travel
            self._roads = Roads(
                graph=world.layout.graph,
                oracle=travel.oracle,
                waits=world.shown.lasting_waits,
                queued=world.shown.queued,
                speed=travel.speed,
                node_time=travel.node_time,
                contact=world.traffic.contact,
            )
        return self._roads

    def way(self, origin: str, goal: str) -> list[Lane]:
        """The lanes from one node to another, as the routing policy chooses them."""
        way = self._ways.get((origin, goal)) if self._fixed else None
        if way is None:
            world, policy = self.world, self.routing
            roads = self.roads()
            names = list(asked("routing", policy, world.env.now, lambda: policy.route(origin, goal, roads)))
            lanes = world.traffic.lanes
            way = [lanes[step] for step in itertools.pairwise(names) if step in lanes]
            if not names or names[0] != origin or names[-1] != goal or len(way) != len(names) - 1:
                raise PolicyError(
                    f"policies.routing ({type(policy).__name__}) at time {world.env.now:g}: "
                    f"{' > '.join(map(str, names)) or 'nothing'} is no way from {origin} to {goal}"
                )
            if self._fixed:
                self._ways[origin, goal] = way
        return way

    def detour(self, robot: Powered, route: Sequence[Lane], index: int, stop: float | None) -> list[Lane] | None:
        """Another way for a robot held up before `route[index]`; None: it waits."""
        last = route[-1]
        goal = last.edge[1] if stop is None else last.edge[0]
        if robot.node == goal:
            return None
        way = self.way(robot.node, goal)
        if stop is not None:
            way = [*way, last]
        return None if way[0] is route[index] else way

    # Battery levels

    def levels(self, view: RobotView) -> Levels:
        """The levels that hold for a robot, by the charging policy."""
        policy = self.charging
        levels: object = asked("charging", policy, self.world.env.now, lambda: policy.levels(view))
        fault = levels.fault() if isinstance(levels, Levels) else f"{levels!r} are no Levels"
        if fault is None and isinstance(levels, Levels):
            return levels
        raise PolicyError(
            f"policies.charging ({type(policy).__name__}) at time {self.world.env.now:g}, robot {view.number}: {fault}"
        )

    # Bays

    def choose_bay(self, robot: Powered, *, away: bool = False) -> Bay:
        """A place for a robot that leaves its work: at a charger if its battery wants one, else for parking.

        `away`: for a robot that makes room at a charger, a place without one.
        """
        parking, view = self.world.parking, robot.view()
        ways = self.world.travel.ways
        bays = [bay for bay in parking.bays.values() if parking.may_take(robot, bay)]
        if away:
            bays = [bay for bay in bays if bay.chargers is None]
        elif self.world.model.battery is not None:
            levels = self.levels(view)
            chargers = [bay for bay in bays if bay.chargers is not None]
            energy = self.world.shown.energy
            if robot.short or view.energy <= energy.retreats_at(view, levels) + EPS * view.capacity:
                if chargers:
                    return self._charger(view, levels.charger, chargers)
                if energy.chargers:  # all taken: wait where they are near
                    return min(bays, key=lambda bay: ways.time(view.node, bay.node) + energy.out_of(bay.node, view))
        views = [_shown(bay) for bay in bays]
        policy = self.parking
        node = asked("parking", policy, self.world.env.now, lambda: policy.choose(view, views, self.world.travel))
        if node not in {item.node for item in views}:
            raise PolicyError(
                f"policies.parking ({type(policy).__name__}) at time {self.world.env.now:g}: "
                f"{node!r} is no bay with a free place for robot {robot.number}"
            )
        return parking.bays[node]

    def _charger(self, view: RobotView, choice: str, bays: list[Bay]) -> Bay:
        """The charger of its home, the nearest one, or that with the fewest robots for each of its chargers."""
        if choice == "own":
            for bay in bays:
                if bay.node == view.home:
                    return bay

        def rank(bay: Bay) -> tuple[float, float]:
            time = self.world.travel.ways.time(view.node, bay.node)
            assert bay.chargers is not None
            return (bay.taken / bay.chargers.capacity if choice == "least-loaded" else 0.0), time

        return min(bays, key=rank)


def _shown(bay: Bay) -> BayView:
    return BayView(bay.node, bay.free, 0 if bay.chargers is None else int(bay.chargers.capacity), bay.taken)
