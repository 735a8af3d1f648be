"""All stations: the choice of the station for a task, and the reservation of its slots.

A slot is reserved before a robot sets out for the good, so a full station holds work back at the source, in a bay, and
never in a lane. Rejected: reserving on arrival (queues in lanes), driving in circles until a slot is free.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import partial

from desim_warehouse.layout import Layout
from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.model import Model
from desim_warehouse.model.schema import Tasks
from desim_warehouse.outcome.log import Log
from desim_warehouse.policies import RobotView, StopPlace, Task
from desim_warehouse.policies.situation import Act
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.places.handling import HandlingTimes
from desim_warehouse.world.places.station import Station, Workplace
from desim_warehouse.world.places.stops import Stop, stops_of_tour
from desim_warehouse.world.traffic.events import Clock


class Stations:
    """All stations, and the destinations of the tasks in hand.

    A node without a station in the list is in the lane.

    `full` are the nodes of those without a free slot: usually none, and then no further check is needed.
    """

    def __init__(
        self,
        env: Clock,
        tasks: Tasks,
        by_node: dict[str, Station],
        full: set[str],
        travel: FreeTravel,
        streams: Streams,
    ) -> None:
        self.env = env
        self.nodes = tasks.unload_at
        self.choice = tasks.station_choice
        self._until_worked = tasks.done_when == "worked"
        self.full = full
        self.by_node = by_node
        self.calendars = [station.hours for station in by_node.values() if station.hours is not None]
        self.close = bool(self.calendars)
        self._at_work = frozenset(node for node, station in by_node.items() if station.work is not None)
        self._whole = frozenset(name for name, flow in tasks.flows.items() if flow.unload_per == "order")
        self._ends_all = not tasks.flows and all(node in by_node for node in self.nodes)
        self._travel = travel
        self._streams = streams
        self._drawn: dict[int, str] = {}
        self._tours: dict[int, list[Stop]] = {}
        self._bound: Counter[str] = Counter()
        self._closed: dict[str, float] = {}
        self._closed_until = -math.inf

    @property
    def unfinished(self) -> list[str]:
        """The nodes of stations with load units not yet worked on, where tasks are done only after that."""
        if not self._until_worked:
            return []
        return [node for node, station in self.by_node.items() if station.work is not None and station.work.left]

    # Choice

    def choose(self, robot: RobotView, task: Task, comes_from: str | None = None) -> str:
        """Return where a robot would unload a task, by tasks.station_choice. Full stations are passed over.

        So are closed ones, in favour of stations that open first. Ties go to the nearer one, then to the one named
        first. `random` draws once for each task, whichever robot gets it. A task with a destination of several nodes
        goes to the nearest of them unless `each` assigns one. `comes_from` is the node before the stop on a tour; by
        default the stop is the last of the tour.
        """
        if comes_from is None and task.is_tour:
            return self.stops(robot, task)[-1].node
        nodes, choice = task.to or self.nodes, self.choice
        if choice == "each" and not task.to:
            return nodes[robot.number % len(nodes)]
        if len(nodes) == 1:
            return nodes[0]
        if choice == "random":
            return self._draw(task)
        nodes = self._travel.by_time(comes_from or task.edge[1], nodes)
        if self.full or self.close:
            nodes = self._best(nodes)
        return min(nodes, key=self._bound.__getitem__) if choice == "least-loaded" else nodes[0]

    def _best(self, nodes: tuple[str, ...]) -> tuple[str, ...]:
        """Return the nodes with room among some and, of these, the ones that open first; all if none has room."""
        if self.full:
            nodes = tuple(node for node in nodes if node not in self.full) or nodes
        if not self.close or len(nodes) == 1:
            return nodes
        closed = self.closed()
        if not closed:
            return nodes
        first = min(closed.get(node, -math.inf) for node in nodes)
        return tuple(node for node in nodes if closed.get(node, -math.inf) == first)

    def closed(self) -> dict[str, float]:
        """Return when each closed station opens next, by node; computed again only at an opening or closing."""
        now = self.env.now
        if now >= self._closed_until:
            calendars = {node: station.hours for node, station in self.by_node.items() if station.hours is not None}
            opening = {node: hours.following(now)[0] for node, hours in calendars.items()}
            self._closed = {node: time for node, time in opening.items() if time > now}
            self._closed_until = min((hours.changes(now) for hours in calendars.values()), default=math.inf)
        return self._closed

    def _draw(self, task: Task) -> str:
        node = self._drawn.get(task.number)
        if node is None:
            nodes = task.to or self.nodes
            drawn = int(self._streams.stream("station", task.number).integers(len(nodes)))
            node = self._drawn[task.number] = nodes[drawn]
        return node

    def at_pick(self, task: Task) -> Station | None:
        """Return the station in which a task is loaded, or None if it is picked from storage or on a node."""
        return self.by_node.get(task.edge[0]) if task.good < 0 else None

    def at_drop(self, task: Task, node: str) -> Station | None:
        """Return the station beside `node` in which a task is unloaded, or None in the lane."""
        return self.by_node.get(node) if task.drop is None else None

    def are_for_workers(self, task: Task) -> bool:
        """Whether a task's load unit is sure to be worked on: all its possible destinations have workers."""
        return bool(self._at_work) and task.drop is None and self._at_work.issuperset(task.to or self.nodes)

    def holding(self, robot: int) -> str:
        """Return the node of the station that a robot is in; empty if it is in none."""
        return next((node for node, station in self.by_node.items() if robot in station.inside), "")

    def has_room(self, robot: RobotView, task: Task, node: str) -> bool:
        """Whether a robot may set out for a task to `node`. A robot in a station leaves its slot first.

        For a tour each of its stations must have a free slot.
        """
        if not self.full:
            return True
        if task.is_tour:
            stations = {stop.station for stop in self.stops(robot, task)} - {None}
            return all(place is None or place.free > 0 or robot.number in place.inside for place in stations)
        station = self.at_drop(task, node)
        if station is not None and station.free <= 0 and robot.number not in station.inside:
            return False
        station = self.at_pick(task)
        return station is None or station.free > 0 or robot.number in station.inside

    def out_of_room(self, robots: Iterable[int]) -> bool:
        """Whether none of some robots has room for any task, because every station where tasks end is full."""
        if len(self.full) < len(self.nodes) or not (self._ends_all and self.full.issuperset(self.nodes)):
            return False
        return not any(robot in self.by_node[node].inside for robot in robots for node in self.nodes)

    # Stops

    def stops(self, robot: RobotView, task: Task, node: str = "") -> list[Stop]:
        """Return the stops that a robot makes for a task or tour, in order. A task by itself is unloaded at `node`."""
        if task.is_tour:
            return self._stops_of_tour(robot, task)
        drop, source = task.drop, task.edge
        edge, offset = ((node, node), 0.0) if drop is None else drop
        return [
            Stop(task, "load", source[1], source, task.offset, self.at_pick(task)),
            Stop(task, "unload", node, edge, offset, self.at_drop(task, node)),
        ]

    def _stops_of_tour(self, robot: RobotView, tour: Task) -> list[Stop]:
        """Return the stops of a tour, kept where its nodes leave no choice: they are then alike for every robot."""
        if tour.number in self._tours:
            return [*self._tours[tour.number]]
        stops = stops_of_tour(tour, self._travel, partial(self._stop, robot), self._whole)
        if self.is_settled(tour):
            self._tours[tour.number] = [*stops]
        return stops

    def is_settled(self, tour: Task) -> bool:
        """Whether the stops of a tour leave no choice."""
        return all(
            (task.drop is not None or len(task.to or self.nodes) == 1)
            and all(place.storage is not None or len(place.nodes) == 1 for place in task.via)
            for task in tour.tasks
        )

    def _stop(self, robot: RobotView, task: Task, act: Act, place: StopPlace, comes_from: str) -> Stop:
        """Make a stop of a tour: for a stop on the way, at the nearest of several nodes that has room."""
        if place.storage is not None:
            edge, offset = place.storage
            return Stop(task, act, edge[1], edge, offset, None)
        if act == "unload":
            node = self.choose(robot, task, comes_from)
        else:
            node = self._best(self._travel.by_time(comes_from, place.nodes))[0]
        stored = act == "load" and task.good >= 0
        return Stop(task, act, node, (node, node), 0.0, None if stored else self.by_node.get(node))

    # Tasks in hand

    def reserve(self, stops: Sequence[Stop], docked: Station | None) -> list[Station]:
        """Reserve a slot in every station of a task or tour that a robot has just been given.

        They are reserved at the start and all at once, not on arrival. So a full station holds work back in the bays,
        never in a lane, and no robot with one slot waits for another. A robot that is `docked` where it begins has its
        slot there.
        """
        slots: list[Station] = []
        first = docked is not None
        for stop in stops:
            if stop.act != "load":
                self._bound[stop.node] += 1
            first = first and stop.station is docked
            if stop.station is not None and not first and stop.station not in slots:
                stop.station.take()
                slots.append(stop.station)
        return slots

    def release(self, stops: Sequence[Stop], slots: Sequence[Station]) -> None:
        """Free the `slots` of a task that is no longer in hand, or of a completed stop."""
        for stop in stops:
            if stop.act != "load":
                self._bound[stop.node] -= 1
        for slot in slots:
            slot.give_up()

    def redirect(self, stop: Stop, edge: tuple[str, str], offset: float) -> None:
        """Move a stop of a tour in hand to another storage place."""
        self._bound[stop.node] -= 1
        stop.node, stop.edge, stop.offset = edge[1], edge, offset
        self._bound[stop.node] += 1

    def forget(self, task: Task) -> None:
        """Forget the draw and stops of a task that is done."""
        self._drawn.pop(task.number, None)
        self._tours.pop(task.number, None)


def stations_of(
    env: Clock,
    model: Model,
    layout: Layout,
    travel: FreeTravel,
    handling: HandlingTimes,
    log: Log,
    streams: Streams,
    worked: Callable[[], None],
) -> Stations:
    """Make the stations of a model, with their hours and work; `worked` is called for each finished load unit."""
    stations: dict[str, Station] = {}
    full: set[str] = set()
    for node, item in layout.stations.items():
        spec = model.layout.stations[item.zone]
        hours = None if spec.hours is None else model.hours(spec.hours)
        pauses, work = spec.at_close == "pause", None
        if spec.work_time is not None:
            work = Workplace(
                env,
                node,
                log,
                places=spec.buffer,
                workers=spec.workers,
                hours=hours,
                pauses=pauses,
                time=partial(handling.work, node),
                worked=worked,
            )
        stations[node] = Station(env, node, item.places, item.servers, full, hours=hours, pauses=pauses, work=work)
    return Stations(env, model.tasks, stations, full, travel, streams)
