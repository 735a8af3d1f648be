"""Random networks with two-way lanes: trees, cores with bridges and spurs, two-way grids, one-way rings with spurs.

`model` makes whole models on them. `Slots` simulates traffic only: robots drive from slot to slot, stop in lanes to
load, are recalled on the way, and all come home.
"""

import math
import random
from itertools import pairwise
from types import SimpleNamespace

import networkx as nx
import simpy

from desim_warehouse.layout.layout import Layout
from desim_warehouse.model.sections.fleet import RobotSpec
from desim_warehouse.model.sections.traffic import TrafficSpec
from desim_warehouse.outcome.log import Log
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.rulebook import NoDriver
from desim_warehouse.world.traffic.traffic import Traffic
from tests.auditor import Audit


def tree(_, draw, street):
    for i in range(1, draw.randint(3, 30)):
        street(f"n{draw.randrange(i)}", f"n{i}")


def cores_with_bridges(graph, draw, street):
    cores = draw.randint(2, 4)
    for core in range(cores):
        ring = [f"c{core}.{i}" for i in range(draw.randint(3, 6))]
        one_way = draw.random() < 0.5
        for a, b in pairwise([*ring, ring[0]]):
            street(a, b, two_way=not one_way)
        if core:
            street(f"c{draw.randrange(core)}.0", f"c{core}.1")
    spurs(graph, draw, street, draw.randint(0, 8))


def grid(_, draw, street):
    wide, high = draw.randint(2, 7), draw.randint(2, 7)
    for x in range(wide):
        for y in range(high):
            if x:
                street(f"{x - 1},{y}", f"{x},{y}")
            if y:
                street(f"{x},{y - 1}", f"{x},{y}")


def one_way_ring(graph, draw, street):
    ring = [f"r{i}" for i in range(draw.randint(3, 10))]
    for a, b in pairwise([*ring, ring[0]]):
        street(a, b, two_way=False)
    spurs(graph, draw, street, draw.randint(1, 12))


def spurs(graph, draw, street, count):
    for i in range(count):
        street(draw.choice([n for n in graph if not n.startswith("q")]), f"q{i}")


SHAPES = {"tree": tree, "bridges": cores_with_bridges, "grid": grid, "ring": one_way_ring}
KINDS = tuple(SHAPES)


def network(kind, draw):
    """Return a digraph with positions of nodes, and lengths and directions of edges."""
    graph = nx.DiGraph()

    def street(a, b, *, two_way=True):
        length = draw.choice([1.0, 1.5, 2.0, 2.0 + 1e-9, 2.0 - 1e-7, 3.0, 4.0, 5.5, 8.0])
        graph.add_edge(a, b, length=length, speed=math.inf, two_way=two_way)
        if two_way:
            graph.add_edge(b, a, length=length, speed=math.inf, two_way=True)

    SHAPES[kind](graph, draw, street)
    for i, name in enumerate(graph):
        angle = 2 * math.pi * i / len(graph)
        graph.nodes[name].update(x=round(30 * math.cos(angle), 3), y=round(30 * math.sin(angle), 3))
    return graph


def model(kind, seed):
    """Return a model on a random network, with goods on lanes, bays and stations, and unloading in the lane."""
    draw = random.Random(f"model {kind} {seed}")
    graph = network(kind, draw)
    nodes = list(graph)
    size = draw.randint(2, 25)
    homes = draw.sample(nodes, draw.randint(1, min(3, len(nodes))))
    unload = draw.sample(nodes, draw.randint(1, min(3, len(nodes))))
    edges = [{"from": a, "to": b, "length": length} for a, b, length in graph.edges(data="length")]
    speeds = random.Random(f"speeds {kind} {seed}")
    if speeds.random() < 0.3:  # limits differ between the two directions
        edges = [{**edge, "speed": speeds.choice((0.3, 0.6, 1.0))} for edge in edges]
    battery = {"capacity": 4000.0, "threshold": 0.0, "consumption": 1, "charge_rate": 20, "reserve": 1e9}
    charging = "threshold"
    if draw.random() < 0.5:
        charging = {"name": "reach-aware", "margin": draw.choice([0.1, 0.4])}
    else:
        battery["threshold"] = 4000.0 - draw.randint(50, 800)
    places = []
    for _ in range(draw.randint(1, 8)):
        a, b, length = draw.choice(list(graph.edges(data="length")))
        places.append({"edge": [a, b], "offset": round(length * draw.uniform(0.05, 0.95), 3)})
    return {
        "layout": {
            "nodes": {name: [data["x"], data["y"]] for name, data in graph.nodes(data=True)},
            "edges": edges,
            "storage": places,
            "bays": {"home": {"at": homes, "places": -(-size // len(homes)) + draw.choice([0, 1])}},
            "stations": {f"s{i}": {"at": [node], "places": 2} for i, node in enumerate(unload) if draw.random() < 0.5},
        },
        "fleet": {"size": size, "robot": {"radius": 0.5, "speed": 1.0}, "exit_time": draw.choice([0.0, 1.5])},
        "tasks": {
            "goods": {"random": draw.randint(1, 60)},
            "unload_at": unload,
            "station_choice": draw.choice(["nearest", "random", "least-loaded"]),
            "load_time": 2.0,
            "unload_time": 3.0,
        },
        "traffic": {"node_time": draw.choice([0.0, 0.4])},
        "battery": battery if draw.random() < 0.6 else None,
        "policies": {
            "routing": draw.choice(["shortest", {"name": "congestion-aware", "detours": draw.randint(1, 3)}]),
            "charging": charging,
            "parking": draw.choice(["home", "nearest", "stay", "spread"]),
        },
    }


class Tenant(NoDriver):
    """A driver that frees its slot when its robot leaves."""

    def __init__(self, free):
        self.free = free
        self.slot = None

    def left_bay(self):
        self.free[self.slot] += 1


class Slots:
    """Robots with slots off the lanes at the nodes of a network."""

    def __init__(self, kind, seed, *, rule="avoid", trips=10, recalls=True, patience=300.0, robots=None):
        self.draw = random.Random(f"{kind} {seed}")
        self.graph = network(kind, self.draw)
        nodes = list(self.graph)
        count = robots or self.draw.randint(2, min(50, 3 * len(nodes)))
        self.free = dict.fromkeys(nodes, 0)
        for _ in range(count + self.draw.choice([1, 2, count])):
            self.free[self.draw.choice(nodes)] += 1
        self.env = simpy.Environment()
        self.layout = Layout(nx.freeze(self.graph), (), {}, {})
        self.log = Log("all")
        self.traffic = Traffic(
            self.env,
            self.layout,
            self.log,
            contact=1.0,
            theta=math.radians(30),
            node_time=self.draw.choice([0.0, 0.5]),
            mixed=False,
            rule=rule,
            patience=patience,
        )
        self.guard = self.traffic.rules.guard
        self.recalls = recalls
        self.home = 0
        self.robots = []
        for number in range(count):
            at = self.draw.choice([node for node in nodes if self.free[node]])
            self.free[at] -= 1
            robot = Body(number, 1.0, self.traffic.nodes[at], Tenant(self.free))
            self.robots.append(robot)
            self.env.process(self.life(robot, at, trips))

    def way(self, a, b):
        return [self.traffic.lanes[edge] for edge in pairwise(nx.shortest_path(self.graph, a, b, weight="length"))]

    def other_slot(self, at):
        goals = [node for node, free in self.free.items() if free and node != at]
        return self.draw.choice(goals) if goals else None

    def life(self, robot, at, trips):
        yield self.env.timeout(self.draw.random() * 50)
        for _ in range(trips):
            goal = self.other_slot(at)
            if goal is not None:
                self.free[goal] -= 1
                at = yield from self.trip(robot, at, goal)
            yield self.env.timeout(self.draw.random() * 30)
        self.home += 1

    def trip(self, robot, at, goal):
        robot.driver.slot = at
        route = self.way(at, goal)
        if self.guard is not None:
            self.guard.declare(robot, route)
        if self.recalls and self.draw.random() < 0.3:
            robot.recall_at = self.env.now + self.draw.random() * 40
        if self.draw.random() < 0.5:
            upto = self.draw.randrange(len(route)) + 1
            stop = route[upto - 1].length / 2
            has_arrived = yield from self.traffic.drive(robot, route[:upto], stop)
            if has_arrived:
                yield self.env.timeout(20)
        while True:
            done = route.index(robot.lane) + 1 if robot.lane in route else 0
            if robot.recall_at <= self.env.now and robot.held is not None:
                robot.recall_at = math.inf
                node = robot.at.name if robot.lane is None else robot.lane.edge[1]
                other = self.other_slot(goal)
                if other not in (None, node):
                    new = self.way(node, other)
                    if self.guard is None or self.guard.change(robot, new):
                        self.free[goal] += 1
                        self.free[other] -= 1
                        goal, route, done = other, new, 0
            if (yield from self.traffic.drive(robot, route[done:])):
                break
        self.log.event(self.env.now, "parked", robot.number, -1, goal, None)
        self.traffic.into_bay(robot)
        robot.recall_at = math.inf
        return goal

    def run(self):
        self.env.run()
        self.log.close(self.env.now)
        return self

    @property
    def problems(self):
        """The faults of the log."""
        robot = RobotSpec(radius=0.5, speed=1.0)
        fleet = SimpleNamespace(size=len(self.robots), robot=robot, robots=lambda: [robot] * len(self.robots))
        fleet.start_on_lanes = ()
        traffic = TrafficSpec()
        model = SimpleNamespace(fleet=fleet, traffic=traffic)
        return Audit(SimpleNamespace(model=model, layout=self.layout, record=self.log)).check_traffic()

    @property
    def stalled(self):
        return self.home < len(self.robots)
