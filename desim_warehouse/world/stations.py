"""Stations beside nodes, where load units are handed over: which one a task goes to, and whether there is room.

A slot is reserved before a robot sets out for the good, so a full station holds work back at the source, in a bay,
and never in a lane. Rejected: reserving on arrival (queues in lanes), driving in circles until a slot is free.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from simpy import Resource

if TYPE_CHECKING:
    from simpy import Environment

    from desim_warehouse.layout import Layout
    from desim_warehouse.layout.travel import FreeTravel
    from desim_warehouse.model.schema import Tasks
    from desim_warehouse.policies import RobotView, Task
    from desim_warehouse.streams import Streams


class Servers(Resource):
    """The servers of a station, a SimPy resource: a robot requests one when it is inside."""


class Station:
    """An unloading station: `places` slots for robots inside or on the way, `servers` of them are served at a time."""

    def __init__(self, env: Environment, node: str, places: int, servers: int) -> None:
        self.node = node
        self.places = places
        self.taken = 0
        self.inside: set[int] = set()
        self.servers = Servers(env, servers)

    @property
    def free(self) -> int:
        """Slots that nobody is in or on the way to."""
        return self.places - self.taken

    def dock(self, robot: int) -> None:
        """A robot that has a slot reserved comes in."""
        self.inside.add(robot)

    def leave(self, robot: int) -> None:
        """A robot is out again, and its slot free."""
        self.inside.remove(robot)
        self.taken -= 1


class Stations:
    """All of them, and where the tasks in hand go; a node without a station in the list is a place in the lane."""

    def __init__(self, env: Environment, tasks: Tasks, layout: Layout, travel: FreeTravel, streams: Streams) -> None:
        self.nodes = tasks.unload_at
        self.choice = tasks.station_choice
        self.by_node = {node: Station(env, node, item.places, item.servers) for node, item in layout.stations.items()}
        self._travel = travel
        self._streams = streams
        self._drawn: dict[int, str] = {}
        self._of_task: dict[int, str] = {}
        self._bound: Counter[str] = Counter()

    # Which one

    def choose(self, robot: RobotView, task: Task) -> str:
        """Where a robot would unload a task, by tasks.station_choice; stations that are full are passed over.

        Ties go to the nearer one, then to the one named first. `random` draws once for each task, whoever gets it.
        A task with a destination of several nodes goes to the nearest of them where `each` says nothing of it.
        """
        nodes, choice, stations = task.to or self.nodes, self.choice, self.by_node
        if choice == "each" and not task.to:
            return nodes[robot.number % len(nodes)]
        if choice == "random":
            return self._draw(task)
        open_ones = [node for node in nodes if node not in stations or stations[node].free > 0] or nodes
        if len(open_ones) == 1:
            return open_ones[0]
        ways, good = self._travel.ways, task.edge[1]
        if choice == "least-loaded":
            least = min(self._bound[node] for node in open_ones)
            open_ones = [node for node in open_ones if self._bound[node] == least]
        return min(open_ones, key=lambda node: ways.time(good, node))

    def _draw(self, task: Task) -> str:
        node = self._drawn.get(task.number)
        if node is None:
            nodes = task.to or self.nodes
            drawn = int(self._streams.stream("station", task.number).integers(len(nodes)))
            node = self._drawn[task.number] = nodes[drawn]
        return node

    def at_pick(self, task: Task) -> Station | None:
        """The station in which a task is loaded; None: it is picked from storage, or standing on a node."""
        return self.by_node.get(task.edge[0]) if task.good < 0 else None

    def at_drop(self, task: Task, node: str) -> Station | None:
        """The station beside `node` in which a task is unloaded; None: it is unloaded in the lane."""
        return self.by_node.get(node) if task.drop is None else None

    def has_room(self, robot: RobotView, task: Task, node: str) -> bool:
        """Whether a robot may set out for a task to `node`; one that stands in a station leaves its slot first."""
        station = self.at_drop(task, node)
        if station is not None and station.free <= 0 and robot.number not in station.inside:
            return False
        station = self.at_pick(task)
        return station is None or station.free > 0 or robot.number in station.inside

    # Tasks in hand

    def reserve(self, task: Task, node: str) -> Station | None:
        """Reserve a slot for a task that a robot has just been given; None: it is unloaded in the lane.

        From the start, not on arrival: a full station holds work back in the bays, never in a lane.
        """
        self._of_task[task.number] = node
        self._bound[node] += 1
        station = self.at_drop(task, node)
        if station is not None:
            station.taken += 1
        return station

    def reserve_pick(self, task: Task, docked: Station | None) -> Station | None:
        """Reserve a slot where a task is loaded; None: it is loaded in the lane, or where its robot is `docked`."""
        station = self.at_pick(task)
        if station is None or station is docked:
            return None
        station.taken += 1
        return station

    def of(self, task: Task) -> str:
        """The node where a task in hand is unloaded."""
        return self._of_task[task.number]

    def release(self, task: Task, *slots: Station | None) -> None:
        """A task is no longer in hand; `slots` were reserved for it and are not needed any more."""
        self._bound[self._of_task.pop(task.number)] -= 1
        for slot in slots:
            if slot is not None:
                slot.taken -= 1

    def forget(self, task: Task) -> None:
        """A task is done: its draw is not needed again."""
        self._drawn.pop(task.number, None)
