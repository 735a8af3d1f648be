"""Goods to person: robots bring pods to stations, where lines of orders are picked from them, and store them again.

A line is a task. A robot does visits of pods: tours from a storage place over a station to a storage place. Orders wait
until a station has room; then their lines are open there. When a robot is free, a pod is called for open lines, by the
policy `pod`. Until the pod is done in the station, lines that become open there join it if it has their item, so the
lines of a visit are known only when it is over. Its storage place is then chosen by the policy `storage`.

The module also keeps the pods themselves: where each stands, its stock and promised units, and free storage places.
"""

from __future__ import annotations

import math
from collections import Counter, OrderedDict, deque
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, NamedTuple, Protocol, TypeVar

from simpy.events import Timeout

from desim_warehouse.layout.layout import StoragePlace
from desim_warehouse.layout.travel import FreeTravel
from desim_warehouse.model.sections.pods import PodsSpec
from desim_warehouse.outcome.log import Log
from desim_warehouse.policies.asked import asked, fault, short
from desim_warehouse.policies.pods import (
    OrderAssignment,
    OrderCall,
    PlaceView,
    PodCall,
    PodChoice,
    PodStorage,
    PodView,
    PutCall,
    PutChoice,
    StationView,
    StorageCall,
)
from desim_warehouse.policies.protocols import RobotView, StopPlace, Task
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.places.handling import HandlingTimes
from desim_warehouse.world.places.opening_hours import at
from desim_warehouse.world.places.service import Service
from desim_warehouse.world.places.stations import Stations
from desim_warehouse.world.places.stops import Stop
from desim_warehouse.world.robots.robot import Robot
from desim_warehouse.world.traffic.events import Clock, Steps

Choice = TypeVar("Choice")


class Pod:
    """A pod on a storage `place`, or last there, with `stock` units of each of its items; it `stands` or is carried.

    `bound`: the station that it was called to, until it is done there (then None, while it is still under way).
    `lines`: the lines of its visit, and `promised` the units of each item that they take. `robot` brings it. `coming`:
    units that are to be put onto it.
    """

    def __init__(self, number: int, place: int, stock: dict[int, float]) -> None:
        self.number = number
        self.home = self.place = place
        self.stock = stock
        self.promised: Counter[int] = Counter()
        self.stands = True
        self.bound: str | None = None
        self.robot: Robot | None = None
        self.lines: deque[Task] = deque()
        self.coming = 0
        self.rank = 0.0

    def left(self, item: int) -> float:
        """Return the units of an item on the pod that are not promised to any line yet."""
        return self.stock.get(item, 0) - self.promised.get(item, 0)


class Shelves:
    """All pods, by number and by item, and the places where no pod stands or is bound to.

    If pods `keep` their places these are never free.
    """

    def __init__(self, spec: PodsSpec, storage: Sequence[StoragePlace], streams: Streams, *, keep: bool) -> None:
        self.storage = storage
        self.keep = keep
        draws = streams.stream("pods")
        holds, units = spec.holds, math.inf if spec.stock is None else spec.stock
        stands = draws.permutation(len(storage))[: spec.count].tolist()
        if holds is not None and holds.places:
            stands = list(holds.places)
        self.endless = spec.units is None
        self.pods = [Pod(number, place, {}) for number, place in enumerate(stands)]
        if holds is None:
            # Items are dealt out in rounds: the numbers of pods with each differ by at most one.
            rounds = -(-spec.count * spec.per_pod // spec.items)
            dealt = [item for _ in range(rounds) for item in draws.permutation(spec.items).tolist()]
            for pod in self.pods:
                pod.stock = dict.fromkeys(dealt[pod.number * spec.per_pod : (pod.number + 1) * spec.per_pod], units)
        else:
            for row, (number, item) in enumerate(zip(holds.pod, holds.item, strict=True)):
                stock = self.pods[number].stock
                stock[item] = stock.get(item, 0) + (holds.units[row] if holds.units else units)
        self._holding: dict[int, list[Pod]] = {}
        for pod in self.pods:
            for item in pod.stock:
                self._holding.setdefault(item, []).append(pod)
        self._rank(spec.item_shares)
        self.free = dict.fromkeys(sorted(set(range(len(storage))) - set(stands)))

    def _rank(self, popularity: Any) -> None:
        weights = [math.fsum(float(popularity[item]) for item in pod.stock) for pod in self.pods]
        for rank, number in enumerate(sorted(range(len(weights)), key=lambda number: (-weights[number], number))):
            self.pods[number].rank = rank / len(weights)

    def holding(self, item: int) -> Sequence[Pod]:
        """Return the pods that have, or had, an item."""
        return self._holding.get(item, ())

    def put(self, pod: Pod, item: int, units: int) -> None:
        """Put some units of an item onto a pod."""
        if item not in pod.stock:
            self._holding.setdefault(item, []).append(pod)
        pod.stock[item] = pod.stock.get(item, 0) + units
        pod.coming -= units

    def lift(self, pod: Pod) -> None:
        """Take a pod away from its place, which is free unless it is kept."""
        pod.stands = False
        if not self.keep:
            self.free[pod.place] = None

    def reserve(self, pod: Pod, place: int) -> None:
        """Reserve a place for a pod."""
        self.free.pop(place, None)
        pod.place = place

    def places_for(self, pod: Pod) -> list[PlaceView]:
        """Return the places where a pod may be put down: its own if places are kept, otherwise the free ones."""
        numbers = [pod.home] if self.keep else self.free
        return [PlaceView(number, self.storage[number].edge, self.storage[number].offset) for number in numbers]

    def view(self, pod: Pod, lines: Sequence[Task] = ()) -> PodView:
        """Return a pod as policies see it."""
        place = self.storage[pod.place]
        units = math.inf if self.endless else sum(pod.stock.values()) + pod.coming
        return PodView(pod.number, pod.home, place.edge, place.offset, units, pod.rank, lines)


class VisitGiver(Protocol):
    """The dispatcher as pods see it: visits are `open`, by number, until robots are given them."""

    open: OrderedDict[int, Task]

    def announce(self, task: Task) -> None:
        """Record a line that has become known."""

    def call(self) -> None:
        """Schedule the assignment of visits for the end of this instant."""

    def line_done(self, line: Task) -> None:
        """Count a line that was picked from a pod, or put onto one."""


class PodPolicies(NamedTuple):
    """The policies of the four decisions of goods to person."""

    pod: PodChoice
    storage: PodStorage
    order_station: OrderAssignment
    put: PutChoice


class Pods:
    """The orders that wait for a station, the lines that are open at each, and the visits of pods.

    `puts`: the flows whose lines are put onto pods; lines of other flows are picked from them.
    """

    def __init__(
        self,
        env: Clock,
        spec: PodsSpec,
        shelves: Shelves,
        policies: PodPolicies,
        *,
        puts: Collection[str],
        travel: FreeTravel,
        stations: Stations,
        handling: HandlingTimes,
        streams: Streams,
        dispatcher: VisitGiver,
        log: Log,
    ) -> None:
        self.env, self.spec, self.shelves, self.policies, self.puts = env, spec, shelves, policies, puts
        self.travel, self.stations, self.handling = travel, stations, handling
        self.dispatcher, self.log = dispatcher, log
        self._draws = {
            kind: streams.stream(f"policy:{kind}").random
            for kind, policy in policies._asdict().items()
            if getattr(policy, "random", False)
        }
        self.backlog: dict[tuple[str, ...], deque[list[Task]]] = {}
        self.open_at: dict[tuple[str, str], tuple[str, int]] = {}  # for each order in hand, its station, and lines left
        self.orders: Counter[str] = Counter()
        self.items: dict[str, Counter[int]] = {node: Counter() for node in stations.by_node}
        self.waiting: dict[str, dict[int, dict[int, Task]]] = {node: {} for node in stations.by_node}
        self.to_put: dict[str, dict[int, tuple[Task, Pod]]] = {node: {} for node in stations.by_node}
        self.called: Counter[str] = Counter()
        self._wakes_at = 0.0

    def _ask(self, kind: str, call: Any, choices: Mapping[Any, Choice]) -> Choice:
        """Return what the policy of a decision chooses, by its number or node."""
        policy, now = getattr(self.policies, kind), self.env.now

        def chosen(answer: object) -> Choice:
            try:
                return choices[answer]
            except (KeyError, TypeError):  # some views cannot be looked up
                raise fault(kind, policy, now, f"{short(answer)} is none of those given") from None

        return asked(kind, policy, now, lambda: policy.choose(call), chosen)

    def _draw(self, kind: str) -> float:
        draw: Callable[[], float] | None = self._draws.get(kind)
        return 0.0 if draw is None else draw()

    # Orders and lines

    def release(self, line: Task) -> None:
        """Add a line that has become known. Lines of an order that become known one after the other form one order."""
        self.dispatcher.announce(line)
        waiting = self.backlog.setdefault(line.to, deque())
        if line.order and waiting and _order(waiting[-1][0]) == _order(line):
            waiting[-1].append(line)
        else:
            waiting.append([line])
        self.dispatcher.call()

    def _open_orders(self) -> None:
        """Send orders that wait to stations with room, the oldest first."""
        most = self.spec.orders
        for nodes, waiting in self.backlog.items():
            while waiting:
                lines = waiting[0]
                order = _order(lines[0])
                node, left = self.open_at.get(order, ("", 0))
                if not left:
                    some = [node for node in nodes if not most or self.orders[node] < most]
                    if not some:
                        break
                    node = some[0] if len(some) == 1 else self._station_for(lines, some)
                    self.orders[node] += 1
                waiting.popleft()
                self.open_at[order] = node, left + len(lines)
                for line in lines:
                    self._open(line._replace(to=(node,)), node)

    def _station_for(self, lines: Sequence[Task], nodes: Sequence[str]) -> str:
        views = [StationView(node, self.orders[node], self.items[node]) for node in nodes]
        call = OrderCall(self.env.now, lines, views, self._draw("order_station"))
        return self._ask("order_station", call, {node: node for node in nodes})

    def _open(self, line: Task, node: str) -> None:
        """Add a line to the first pod bound for its station that has its item, or let it wait for a call."""
        if line.flow in self.puts:
            self._open_put(line, node)
            return
        self.items[node][line.item] += 1
        for pod in self.shelves.holding(line.item):
            if pod.bound == node and pod.left(line.item) > 0:
                self._promise(pod, line)
                return
        self.waiting[node].setdefault(line.item, {})[line.number] = line

    def _open_put(self, line: Task, node: str) -> None:
        """Give a bundle to the pod chosen by the policy `put`, at once or when the pod stands again."""
        pods = [pod for pod in self.shelves.pods if pod.bound == node or (pod.stands and pod.bound is None)]
        pods = pods or self.shelves.pods
        call = PutCall(self.env.now, node, line.item, [self.shelves.view(pod) for pod in pods], self._draw("put"))
        pod = self._ask("put", call, {pod.number: pod for pod in pods})
        pod.coming += self.spec.bundle
        if pod.bound == node:
            self._promise(pod, line)
        else:
            self.to_put[node][line.number] = line, pod

    def _promise(self, pod: Pod, line: Task) -> None:
        pod.lines.append(line)
        if line.flow not in self.puts:
            pod.promised[line.item] += 1
        if pod.robot is not None:
            self._record("assigned", pod.robot, line)

    # Visits

    @property
    def wait(self) -> bool:
        """Whether lines wait for a pod, or orders for a station."""
        return any(self.waiting.values()) or any(self.to_put.values()) or any(self.backlog.values())

    def out_of_stock(self) -> list[int]:
        """Return the items that lines wait for and no pod has."""
        asked = {item for lines in self.waiting.values() for item in lines}
        return sorted(item for item in asked if all(pod.left(item) <= 0 for pod in self.shelves.holding(item)))

    def call(self, robots: Sequence[RobotView]) -> None:
        """Call a pod for each free robot without a visit, as long as stations have lines and room."""
        self._open_orders()
        nodes = [robot.node for robot in robots]
        closed = self._closed()
        open_visits = sum(visit.via[0].nodes[0] not in closed for visit in self.dispatcher.open.values())
        while open_visits < len(nodes) and self._call(nodes, closed):
            open_visits += 1

    def _closed(self) -> Mapping[str, float]:
        """Return the closed stations. If lines wait at one, a pod is called as soon as it opens."""
        if not self.stations.close:
            return {}
        closed, now = self.stations.closed(), self.env.now
        opens = [time for node, time in closed.items() if self.waiting[node] or self.to_put[node]]
        first = min(opens, default=now)
        if now < first and self._wakes_at != first:
            self._wakes_at = first
            at(self.env, first).callbacks.append(lambda _: self.dispatcher.call())
        return closed

    def _call(self, nodes: Sequence[str], closed: Collection[str]) -> bool:
        """Call a pod to the station with the fewest robots that has lines and room; returns False if none can be."""
        by_node, called = self.stations.by_node, self.called
        ready = [
            node
            for node, station in by_node.items()
            if (self.waiting[node] or self.to_put[node]) and station.free > called[node] and node not in closed
        ]
        for node in sorted(ready, key=lambda node: by_node[node].taken + called[node]):
            candidates = self._candidates(node)
            if candidates:
                views = [self.shelves.view(pod, lines) for pod, lines in candidates.items()]
                call = PodCall(self.env.now, node, views, nodes, self.travel, self._draw("pod"))
                pod = self._ask("pod", call, {pod.number: pod for pod in candidates})
                self._give_out(pod, node, candidates[pod])
                return True
        return False

    def _candidates(self, node: str) -> dict[Pod, list[Task]]:
        """Return the pods on their places with lines open at a station, and these lines; by number."""
        candidates: dict[Pod, list[Task]] = {}
        for item, lines in self.waiting[node].items():
            some = list(lines.values())
            for pod in self.shelves.holding(item):
                if pod.stands and pod.bound is None and (left := pod.left(item)) > 0:
                    candidates.setdefault(pod, []).extend(some if left >= len(some) else some[: int(left)])
        for line, pod in self.to_put[node].values():
            if pod.stands and pod.bound is None:
                candidates.setdefault(pod, []).append(line)
        return dict(sorted(candidates.items(), key=lambda entry: entry[0].number))

    def _give_out(self, pod: Pod, node: str, lines: Sequence[Task]) -> None:
        lines = sorted(lines, key=lambda line: line.number)
        pod.bound = node
        self.called[node] += 1
        for line in lines:
            if line.flow in self.puts:
                del self.to_put[node][line.number]
            else:
                alike = self.waiting[node][line.item]
                del alike[line.number]
                if not alike:
                    del self.waiting[node][line.item]
            self._promise(pod, line)
        place, dues = self.shelves.storage[pod.place], [line.due for line in lines if line.due is not None]
        visit = lines[0]._replace(
            good=place.number,
            edge=place.edge,
            offset=place.offset,
            due=min(dues, default=None),
            priority=max(line.priority for line in lines),
            to=(place.edge[1],),
            drop=(place.edge, place.offset),
            via=(StopPlace((node,)),),
            pod=pod.number,
            lines=len(lines),
        )
        self.dispatcher.open[visit.number] = visit

    # A visit in hand

    def assigned(self, robot: Robot, visit: Task) -> None:
        """Note that a robot takes a visit: its first line is in the log already."""
        pod = self.shelves.pods[visit.pod]
        self.called[str(pod.bound)] -= 1
        pod.robot = robot
        self._record_others("assigned", robot, pod, visit)

    def returned(self, robot: Robot, visit: Task) -> None:
        """Note that a robot gives its visit back before it has the pod, which stays called."""
        pod = self.shelves.pods[visit.pod]
        self.called[str(pod.bound)] += 1
        pod.robot = None
        self._record_others("returned", robot, pod, visit)

    def _record_others(self, kind: str, robot: Robot, pod: Pod, visit: Task) -> None:
        for line in pod.lines:
            if line.number != visit.number:
                self._record(kind, robot, line)

    def _record(self, kind: str, robot: Robot, line: Task, pod: int = -1) -> None:
        self.log.event(self.env.now, kind, robot.number, line.number, robot.node, robot.energy, other=pod)

    def lifted(self, robot: Robot, stop: Stop) -> None:
        """Note that a robot has taken the pod from its place."""
        self._moved("lifted", robot, stop)
        self.shelves.lift(self.shelves.pods[stop.task.pod])

    def stored(self, robot: Robot, stop: Stop) -> None:
        """Note that a robot has put the pod down."""
        self._moved("stored", robot, stop)
        pod = self.shelves.pods[stop.task.pod]
        pod.stands, pod.robot = True, None

    def _moved(self, kind: str, robot: Robot, stop: Stop) -> None:
        number, now = stop.task.pod, self.env.now
        place = self.shelves.pods[number].place
        self.log.event(now, kind, robot.number, stop.task.number, robot.node, float(number), other=place)

    def serve(self, robot: Robot, stop: Stop, service: Service, state: str) -> Steps:
        """Serve a robot in its station with a server: pick line after line until none is left, then choose a place."""
        pod, node = self.shelves.pods[stop.task.pod], stop.node
        if self.spec.change_time and service.queued:
            yield Timeout(self.env, self.spec.change_time)
            yield from service.begin(stop)  # it may have closed meanwhile
        while pod.lines:
            line = pod.lines[0]
            robot.body.work_on(line.number)
            yield from service.take(state, self.handling.pick(line))
            pod.lines.popleft()
            self._picked(robot, pod, line, node)
        pod.bound = None
        robot.body.work_on(stop.task.number)
        self._choose_place(pod, node, robot.tour.stops[-1])
        self.dispatcher.call()

    def _picked(self, robot: Robot, pod: Pod, line: Task, node: str) -> None:
        if line.flow in self.puts:
            self.shelves.put(pod, line.item, self.spec.bundle)
        else:
            pod.stock[line.item] -= 1
            pod.promised[line.item] -= 1
            self.items[node][line.item] -= 1
            if not self.items[node][line.item]:
                del self.items[node][line.item]
        self._record("delivered", robot, line, pod.number)
        robot.count_delivery()
        order = _order(line)
        _, left = self.open_at[order]
        self.open_at[order] = node, left - 1
        if left == 1:
            del self.open_at[order]
            self.orders[node] -= 1
        self.dispatcher.line_done(line)
        self._open_orders()

    def _choose_place(self, pod: Pod, node: str, stop: Stop) -> None:
        """Choose the place where a pod is stored, while its robot in the station can still declare its way."""
        views = self.shelves.places_for(pod)
        call = StorageCall(self.env.now, node, self.shelves.view(pod), views, self.travel, self._draw("storage"))
        number = self._ask("storage", call, {view.number: view.number for view in views})
        self.shelves.reserve(pod, number)
        place = self.shelves.storage[number]
        self.stations.redirect(stop, place.edge, place.offset)


def _order(line: Task) -> tuple[str, str]:
    """Return the key of an order; a line without one is an order by itself."""
    return line.flow, line.order or f"#{line.number}"
