"""Two-way lanes: trips an hour on plants and networks, deliveries of a core with bridges, and what a grant costs.

`python -m benchmarks.two_way [plants|networks|strict|core|grant] ...`, all by default; about ten minutes. `plants`
reads the plant models of others from the folder that the variable DESIM_PLANTS names.

Trips: robots drive from one slot to another drawn among the free ones, and stay for 10 to 30 s. D = 1 m, 1 m/s.
"""

from __future__ import annotations

import math
import os
import random
import statistics
import sys
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import networkx as nx
import simpy

import desim_warehouse as dw
from benchmarks.traffic import bare_timeouts
from desim_warehouse.layout import build
from desim_warehouse.layout.layout import Layout
from desim_warehouse.outcome.log import Log
from desim_warehouse.plants import import_layout
from desim_warehouse.world.traffic.avoidance import Avoidance
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.rulebook import NoDriver
from desim_warehouse.world.traffic.traffic import Traffic
from tests.laws.test_brute_force import refused
from tests.laws.two_way import KINDS

HOUR = 3600.0
SEEDS = 5
PLANTS = {
    "zhaoqin": {2: 128, 5: 298, 8: 388},
    "tsh": {2: 96, 8: 263},
    "xxx": {2: 82, 10: 382, 20: 596},
}
"""Plants of others, by robots: trips an hour of the trial of the same rule that the design rests on (one seed)."""


class Tenant(NoDriver):
    """A robot that gives its slot back when it leaves."""

    def __init__(self, free: dict[str, int]) -> None:
        self.free = free
        self.slot = ""

    def left_bay(self) -> None:
        self.free[self.slot] += 1


class Trips:
    """Robots that drive from slot to slot without end: traffic alone. `slots`: how many are beside a node.

    `rule` is that of `Traffic`; `stalled` says that robots are out and none of them will ever move.
    """

    def __init__(self, graph: nx.DiGraph, slots: dict[str, int], robots: int, seed: int, rule: str = "avoid") -> None:
        self.random = random.Random(seed)
        self.graph = graph
        self.free = dict(slots)
        self.env = simpy.Environment()
        self.traffic = Traffic(
            self.env,
            Layout(graph, (), {}, {}),
            Log("tasks"),
            contact=1.0,
            theta=math.radians(30),
            node_time=0.0,
            mixed=False,
            rule=rule,  # type: ignore[arg-type]
            patience=300.0,
        )
        self.guard = self.traffic.rules.guard
        self.ways = {goal: self._ways_to(goal) for goal in slots}
        self.done = self.out = 0
        places = [node for node, count in slots.items() for _ in range(count)]
        assert robots < len(places)
        self.random.shuffle(places)
        self.robots = []
        for number, at in enumerate(places[:robots]):
            self.free[at] -= 1
            robot = Body(number, 1.0, self.traffic.nodes[at], Tenant(self.free))
            self.robots.append(robot)
            self.env.process(self.life(robot, at))

    def _ways_to(self, goal: str) -> dict[str, list[str]]:
        """Shortest ways to a node, from every node."""
        return {
            node: way[::-1]
            for node, way in nx.single_source_dijkstra_path(
                self.graph.reverse(copy=False), goal, weight="length"
            ).items()
        }

    def life(self, robot: Body, at: str) -> Any:
        yield self.env.timeout(self.random.uniform(0, 30))
        while True:
            goals = [node for node, free in self.free.items() if free and node != at]
            if not goals:
                yield self.env.timeout(5)
                continue
            goal = self.random.choice(goals)
            self.free[goal] -= 1
            route = [self.traffic.lanes[edge] for edge in pairwise(self.ways[goal][at])]
            if self.guard is not None:
                self.guard.declare(robot, route)
            self.out += 1
            robot.driver.slot = at  # type: ignore[attr-defined]
            yield from self.traffic.drive(robot, route)
            self.traffic.into_bay(robot)
            self.out -= 1
            self.done += 1
            at = goal
            yield self.env.timeout(self.random.uniform(10, 30))

    def run(self, until: float = HOUR) -> Trips:
        """Drive until a time, which no robot reaches if all are stuck."""
        self.env.run(until=until)
        return self

    @property
    def stalled(self) -> bool:
        """Whether robots are out and none has anything to come."""
        return self.out > 0 and self.env.peek() == math.inf


def side_by_side(graph: nx.DiGraph) -> nx.DiGraph:
    """The same network with two lanes, each its own, where one served both directions."""
    other = nx.DiGraph(graph)
    for _, _, data in other.edges(data=True):
        data["two_way"] = False
    return other


# Networks


def comb(teeth: int = 84, spur: int = 2, length: float = 3.0) -> tuple[nx.DiGraph, dict[str, int]]:
    """A trunk with a spur at every node, all two-way: a tree with slots at its tips."""
    graph = nx.DiGraph()
    for i in range(teeth):
        if i:
            _lane(graph, f"t{i - 1}", f"t{i}", length)
        for j in range(spur):
            _lane(graph, f"s{i}.{j - 1}" if j else f"t{i}", f"s{i}.{j}", length)
    slots = {f"s{i}.{spur - 1}": 2 for i in range(teeth)}
    return _placed(graph), slots


def grid(side: int = 16, length: float = 3.0) -> tuple[nx.DiGraph, dict[str, int]]:
    """A two-way grid with slots beside every third node."""
    graph = nx.DiGraph()
    for x in range(side):
        for y in range(side):
            if x:
                _lane(graph, f"{x - 1},{y}", f"{x},{y}", length)
            if y:
                _lane(graph, f"{x},{y - 1}", f"{x},{y}", length)
    return _placed(graph), dict.fromkeys(list(graph)[::3], 2)


def random_plant(points: int = 260, seed: int = 1) -> tuple[nx.DiGraph, dict[str, int]]:
    """As real plants are: a tree of two-way lanes 1 to 8 m long, a few rings in it, slots at a quarter of the tips."""
    draw, graph = random.Random(seed), nx.DiGraph()
    for i in range(1, points):
        _lane(graph, f"p{draw.randrange(max(0, i - 8), i)}", f"p{i}", draw.choice([1.0, 1.5, 2.0, 3.0, 5.0, 8.0]))
    for _ in range(points // 20):
        a, b = draw.sample(range(points), 2)
        if abs(a - b) > 1 and not graph.has_edge(f"p{a}", f"p{b}"):
            _lane(graph, f"p{a}", f"p{b}", 8.0)
    tips = [node for node in graph if graph.out_degree(node) == 1]
    return _placed(graph), dict.fromkeys(draw.sample(tips, max(len(tips) // 2, 2)), 2)


def _lane(graph: nx.DiGraph, a: str, b: str, length: float, *, two_way: bool = True) -> None:
    graph.add_edge(a, b, length=length, speed=math.inf, two_way=two_way)
    if two_way:
        graph.add_edge(b, a, length=length, speed=math.inf, two_way=True)


def _placed(graph: nx.DiGraph) -> nx.DiGraph:
    """A position for every node: only right angles matter, not distances."""
    for number, data in enumerate(graph.nodes.values()):
        data.update(x=float(number % 20), y=float(number // 20))
    return graph


# Reports


def _over_seeds(graph: nx.DiGraph, slots: dict[str, int], robots: int, rule: str = "avoid") -> tuple[str, float]:
    runs = [Trips(graph, slots, robots, seed, rule).run() for seed in range(SEEDS)]
    assert not any(run.stalled for run in runs)
    done = [run.done for run in runs]
    return f"{statistics.mean(done):.0f} ({min(done)} to {max(done)})", statistics.mean(done)


def plants() -> None:
    """Trips an hour on plants of others, beside the trial's figures; two slots at every location and parking point."""
    folder = os.environ.get("DESIM_PLANTS")
    if folder is None:
        print("plants: DESIM_PLANTS names no folder with plant models, so they are left out")
        return
    for name, figures in PLANTS.items():
        made = import_layout(Path(folder) / "opentcs-touchmii" / f"{name}.xml")
        graph = build(made.model.layout).graph
        main = max(nx.strongly_connected_components(graph), key=len)
        points = [point for location in made.plant.locations for point in location.operations]
        points += [point.name for point in made.plant.points.values() if point.parking]
        slots = dict.fromkeys(sorted(main.intersection(points)), 2)
        side = side_by_side(graph)
        for robots, trial in figures.items():
            text, mean = _over_seeds(graph, slots, robots)
            bound, _ = _over_seeds(side, slots, robots, "rotate")
            print(
                f"{name:<8} {robots:>3} robots: {text} trips/h, trial {trial}: {mean / trial:.2f}; side by side {bound}"
            )


def networks() -> None:
    """Trips an hour on networks of 250 points and more."""
    for name, (graph, slots) in {
        "comb, 84 spurs of 6 m": comb(),
        "grid of 16 x 16, 3 m": grid(),
        "tree with rings, 260 points": random_plant(),
    }.items():
        side = side_by_side(graph)
        for robots in (3, 10, 20, 30, 50):
            text, _ = _over_seeds(graph, slots, robots)
            bound, _ = _over_seeds(side, slots, robots, "rotate")
            print(f"{name:<28} {len(graph)} points, {robots:>3} robots: {text} trips/h; side by side {bound}")


def core_model(kind: str, robots: int = 100, bridges: int = 20, columns: int = 11, rows: int = 8) -> dict[str, Any]:
    """A core of streets with stations at the tips of spurs: `kind` says what is two-way: bridges, all, or nothing.

    Streets are one-way, in alternating directions; spurs (bridges of the network) are 6 m long.
    """
    nodes = {f"c{x}.{y}": [x * 8.0, y * 8.0] for x in range(columns) for y in range(rows)}
    edges: list[dict[str, Any]] = []
    both = {"two_way": True} if kind == "all two-way" else {}
    outer = _clockwise(columns, rows)
    for x in range(columns):
        for y in range(rows):
            for a, b, east in ((f"c{x}.{y}", f"c{x + 1}.{y}", y % 2), (f"c{x}.{y}", f"c{x}.{y + 1}", x % 2)):
                if b in nodes:
                    forward = (a, b) in outer or ((b, a) not in outer and bool(east))
                    source, target = (a, b) if forward else (b, a)
                    edges.append({"from": source, "to": target, **both})
    rim = [*dict.fromkeys(node for edge in outer for node in edge)]
    mouths = [rim[i * len(rim) // bridges] for i in range(bridges)]
    stations = {}
    for number, mouth in enumerate(mouths):
        x, y = nodes[mouth]
        dx, dy = (0, -6) if y == 0 else (0, 6) if y == (rows - 1) * 8 else (-6, 0) if x == 0 else (6, 0)
        tip = f"s{number}"
        nodes[tip] = [x + dx, y + dy]
        stations[tip] = {"at": [tip], "places": 4, "servers": 2}
        if kind == "side by side":
            edges += [{"from": mouth, "to": tip, "side_by_side": True}, {"from": tip, "to": mouth}]
        else:
            edges.append({"from": mouth, "to": tip, "two_way": True})
    inner = [edge for edge in edges if edge["from"][0] == edge["to"][0] == "c"]
    homes = [name for name in nodes if name[0] == "c" and name not in mouths]
    return {
        "name": kind,
        "layout": {
            "nodes": nodes,
            "edges": edges,
            "storage": [{"edge": [edge["from"], edge["to"]], "offset": 4.0} for edge in inner],
            "bays": {"home": {"at": homes, "places": -(-robots // len(homes)) + 1}},
            "stations": stations,
        },
        "fleet": {"size": robots, "robot": {"radius": 0.5, "speed": 1.0}},
        "tasks": {
            "goods": {"saturated": robots},
            "unload_at": list(stations),
            "station_choice": "random",
            "load_time": 10.0,
            "unload_time": 10.0,
        },
        "policies": {"allocation": "nearest", "routing": "shortest", "parking": "nearest"},
        "run": {"length": HOUR * 1.5, "warm_up": HOUR / 2},
        "log": "tasks",
    }


def _clockwise(columns: int, rows: int) -> list[tuple[str, str]]:
    """The edges of the outer ring of a core."""
    top, right = [(x, 0) for x in range(columns)], [(columns - 1, y) for y in range(1, rows)]
    bottom = [(x, rows - 1) for x in range(columns - 2, -1, -1)]
    left = [(0, y) for y in range(rows - 2, 0, -1)]
    ring = [f"c{x}.{y}" for x, y in (*top, *right, *bottom, *left)]
    return list(pairwise([*ring, ring[0]]))


def core() -> None:
    """Deliveries an hour of a one-way core with 20 bridges, beside all two-way and beside side by side."""
    for kind in ("one-way core, two-way bridges", "all two-way", "side by side"):
        model = dw.load(core_model(kind))
        for robots, most_out in ((25, None), (50, None), (100, None), (100, 50)):
            changes = {"fleet.size": robots, "tasks.goods": {"saturated": robots}, "traffic.most_out": most_out}
            runs = [dw.simulate(model.replace(changes), seed) for seed in range(SEEDS)]
            rate = statistics.mean(run.kpis["throughput_per_hour"] for run in runs)
            cap = "" if most_out is None else f", at most {most_out} under way"
            print(f"{kind:<30} {robots:>3} robots{cap}: {rate:.0f} deliveries/h", flush=True)


def strict() -> None:
    """States that the rule refuses, of fleets of up to six robots, each searched: dead, or refused needlessly."""
    for kind in KINDS:
        live, dead = refused(kind, range(700))
        print(f"{kind:<8} refused and dead {dead:,}, refused but live {live:,}", flush=True)


class _Timed(Avoidance):
    """Knows how long its answers took."""

    spent = 0.0
    asked = agreed = 0

    def admit(self, *step: Any) -> bool:
        begin = time.process_time()
        answer = super().admit(*step)
        type(self).spent += time.process_time() - begin
        type(self).asked += 1
        type(self).agreed += answer
        return answer


def grant() -> None:
    """What a grant costs in bare timeouts, refusals before it included, against the number of robots."""
    core = build(dw.load(core_model("one-way core, two-way bridges")).layout).graph
    for name, (graph, slots) in {
        "grid of 20 x 20": grid(20),
        "comb, 60 spurs of 9 m": comb(60, 3),
        "one-way core, 20 spurs": (core, list(core)),
    }.items():
        for robots in (10, 20, 50, 100):
            run = Trips(graph, dict.fromkeys(slots, 4), robots, 1)
            run.guard.__class__ = _Timed
            _Timed.spent, _Timed.asked, _Timed.agreed = 0.0, 0, 0
            run.run(HOUR / 2)
            clock = min(_clock() for _ in range(5))
            each = (_Timed.spent - clock * _Timed.asked) / max(_Timed.agreed, 1)
            refused = 1 - _Timed.agreed / max(_Timed.asked, 1)
            print(
                f"{name:<24} {robots:>3} robots: a grant costs {each * bare_timeouts():.2f} bt ({each * 1e6:.1f} us, "
                f"{_Timed.asked / _Timed.agreed:.2f} answers a grant, {refused:.0%} refused)",
                flush=True,
            )


def _clock(times: int = 10_000) -> float:
    """What reading the clock costs within one measurement."""
    total = 0.0
    for _ in range(times):
        begin = time.process_time()
        total += time.process_time() - begin
    return total / times


if __name__ == "__main__":
    parts = {"plants": plants, "networks": networks, "strict": strict, "core": core, "grant": grant}
    for part in sys.argv[1:] or parts:
        parts[part]()
