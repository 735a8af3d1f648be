"""Cost of an edge move, as a ratio to a bare SimPy timeout measured in the same process right before and after.

Processor time, so that other programs on the machine disturb little.
"""

from __future__ import annotations

import gc
import math
import random
import time
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

import simpy
from simpy.events import Timeout

import desim_warehouse as dw
from benchmarks import GROUPS, sorting, up_to
from benchmarks.memory import peak
from desim_warehouse.layout import build
from desim_warehouse.layout.naming import block_nodes
from desim_warehouse.layout.oracle import RouteOracle
from desim_warehouse.layout.spec import LayoutSpec
from desim_warehouse.outcome.log import Log
from desim_warehouse.world import World
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.events import Clock
from desim_warehouse.world.traffic.traffic import Traffic

if TYPE_CHECKING:
    from desim_warehouse.world.traffic.lane import Lane

ROOT = Path(__file__).parents[1]
MODELS = Path(__file__).parent / "models_0_2"
"""Models as version 0.2.0 shipped them, without acceleration: speed is measured on what was always measured."""
STATIONS = 1100


def bare_timeouts(processes: int = 100, each: int = 1000) -> float:
    """Timeouts per second of SimPy alone."""
    env = simpy.Environment()

    def wait(delay: float) -> Any:
        for _ in range(each):
            yield env.timeout(delay)

    for number in range(processes):
        env.process(wait(1 + number / 1000))
    gc.collect()
    begin = time.process_time()
    env.run()
    return processes * each / (time.process_time() - begin)


class Core:
    """Robots that drive between storage places and the bottom row: traffic alone, nothing decided or logged.

    A block grid of `columns` x `rows` nodes in MultiBots' measures; ways are worked out beforehand.
    """

    def __init__(self, columns: int, rows: int, robots: int, *, spread: bool = False) -> None:
        blocks = {"columns": columns - 1, "rows": rows - 1, "block_depth": 4, "goods_size": 50, "aisle_width": 50}
        self.layout = build(LayoutSpec.model_validate({"blocks": blocks}))
        self.env = Clock()
        self.traffic = Traffic(
            self.env, self.layout, Log("tasks"), contact=33.0, theta=math.radians(30), node_time=1.5, mixed=False
        )
        self.random = random.Random(1)
        names = block_nodes(columns - 1, rows - 1)
        edges = list(self.layout.graph.edges)
        bottom = set(names[-1])
        self.storage = sorted({place.edge for place in self.layout.storage})
        self.stations = [edge for edge in edges if bottom.issuperset(edge)]
        if spread:
            self.storage = self.stations = self.random.sample(self.storage, min(100, len(self.storage)))
        self.ways = RouteOracle(self.layout.graph, "length", 4.0, 1.5)
        for edge in {*self.storage, *self.stations}:
            self.ways.length(edge[1], edge[0])
        self.cache: dict[tuple[str, str], list[Lane]] = {}
        starts = [name for row in names for name in row] if spread else names[0]
        self.robots = [Body(number, 4.0, self.traffic.nodes[starts[number % len(starts)]]) for number in range(robots)]
        self.done = 0
        for number, robot in enumerate(self.robots):
            self.env.process(self.life(robot, starts[number % len(starts)], number // len(starts) * 20))

    def way(self, origin: str, goal: str) -> list[Lane]:
        """The lanes of the shortest way."""
        lanes = self.cache.get((origin, goal))
        if lanes is None:
            steps = pairwise(self.ways.way(origin, goal))
            lanes = self.cache[origin, goal] = [self.traffic.lanes[step] for step in steps]
        return lanes

    def life(self, robot: Body, at: str, delay: float) -> Any:
        """Fetch and deliver without end."""
        yield Timeout(self.env, self.random.random() * 500 + delay)
        while True:
            for edges, handling in ((self.storage, 10), (self.stations, 20)):
                edge = self.random.choice(edges)
                yield from self.traffic.drive(robot, [*self.way(at, edge[0]), self.traffic.lanes[edge]], 75.0)
                yield Timeout(self.env, handling)
                at = edge[1]
            self.done += 1

    @property
    def moves(self) -> int:
        """Edges driven so far."""
        return sum(robot.moves for robot in self.robots)

    def measure(self, warm_up: float, until: float, processes: int = 100) -> tuple[float, float]:
        """Moves per second between two times of the run, and those of as many processes of bare timeouts beside it."""
        up_to(self.env, warm_up)
        before, bare = self.moves, bare_timeouts(processes, 100_000 // processes)
        gc.collect()
        gc.disable()
        begin = time.process_time()
        up_to(self.env, until)
        spent = time.process_time() - begin
        gc.enable()
        return (self.moves - before) / spent, max(bare, bare_timeouts(processes, 100_000 // processes))


def core(name: str, columns: int, rows: int, robots: int, until: float, *, spread: bool = False) -> float:
    """Print the cost of traffic alone; returns the ratio to bare timeouts."""
    runs = [Core(columns, rows, robots, spread=spread) for _ in range(2)]
    ratios = []
    for run in runs:
        moves, bare = run.measure(until / 4, until)
        ratios.append(moves / bare)
    last = runs[-1]
    print(
        f"{name:<46} {moves:>9,.0f} moves/s  {bare:>10,.0f} timeouts/s  ratio {max(ratios):.3f}"
        f"  ({last.done / until * 1000:.1f} deliveries per 1,000 steps, {last.traffic.gridlock.rotations} rotations)",
        flush=True,
    )
    return max(ratios)


def driven(model: dw.Model, since: float, until: float) -> tuple[int, float]:
    """Moves between two times of a run, and the seconds they take with everything: decisions, batteries, log."""
    world = World(model)
    world.begin()
    up_to(world.env, since)
    before = sum(robot.body.moves for robot in world.robots)
    gc.collect()
    gc.disable()
    begin = time.process_time()
    up_to(world.env, until)
    spent = time.process_time() - begin
    gc.enable()
    return sum(robot.body.moves for robot in world.robots) - before, spent


def whole(name: str, model: dw.Model, since: float, until: float) -> None:
    """Print moves per bare timeout with everything on, the median of three rounds.

    Before them all routes are searched for, which the runs of a model share.
    """
    driven(model, since, until)
    rounds = []
    for _ in range(3):
        bare = bare_timeouts()
        moves, spent = driven(model, since, until)
        bare = max(bare, bare_timeouts())
        rounds.append((moves / spent / bare, moves / spent, bare, (until - since) / spent))
    _, (ratio, rate, bare, real), _ = sorted(rounds)
    print(
        f"{name:<46} {rate:>9,.0f} moves/s  {bare:>10,.0f} timeouts/s  ratio {ratio:.3f}  ({real:,.0f} x real time)",
        flush=True,
    )


def medium() -> None:
    """The medium model."""
    whole("medium model, all included", dw.load(MODELS / "medium.yaml"), 1, 7200)


def many_stations() -> None:
    """A sorting floor with as many stations as fit beside its cells: each robot its own, or drawn for each task."""
    floor = sorting.model(50, 1000, 0)
    ends = sorted(floor["layout"]["nodes"])[::2][:STATIONS]
    floor["layout"]["stations"]["chutes"]["at"] = ends
    model = dw.load(floor)
    own = {"tasks.station_choice": "each", "tasks.unload_at": ends[:: STATIONS // 50][:50]}
    each = model.replace(own)
    ratios = []
    for _ in range(5):  # in turn, as other work on the machine disturbs
        (moves, spent), (others, taken) = driven(model, 100, 1000), driven(each, 100, 1000)
        ratios.append(spent / moves / (taken / others))
    print(
        f"{'cells, 50 robots':<46} a move costs {median(ratios):.2f} times as much with {STATIONS:,} stations drawn at "
        f"random as with one for each (aim 1.3)"
    )


def cells() -> None:
    """The paper's 30 cells, without start-up."""
    models = [
        dw.load(ROOT / "models/multibots.yaml", {"fleet.size": robots, "tasks.goods": list(goods)})
        for robots in range(1, 7)
        for goods in GROUPS
    ]
    for model in models:
        dw.simulate(model)
    measured = {"building the World": World, "T, S, C": _paper, "all indicators": lambda model: dw.simulate(model).kpis}
    timeouts: dict[str, list[float]] = {name: [] for name in measured}
    for _ in range(7):
        for name, run in measured.items():
            bare = bare_timeouts(each=300)
            gc.collect()
            begin = time.process_time()
            for model in models:
                run(model)
            spent = time.process_time() - begin
            timeouts[name].append(spent / len(models) * (bare + bare_timeouts(each=300)) / 2)
    costs = ", ".join(f"{name} {median(costs):,.0f}" for name, costs in timeouts.items())
    print(f"{'the 30 cells of the paper':<46} bare timeouts a run: {costs}", flush=True)


def _paper(model: dw.Model) -> tuple[float, int, int]:
    """The three numbers of the paper."""
    run = dw.simulate(model)
    return run.T, run.S, run.C


def growth() -> None:
    """Cost per move at equal density, from 10 to 10,000 robots, beside SimPy with as many processes.

    Measured from when all have set out on their first ways, which takes up the whole time in the larger ones: nothing
    but driving is measured.
    """
    speeds = []
    for side, robots, until in ((8, 10, 20_000), (25, 100, 8_000), (80, 1000, 2_000), (253, 10_000, 1_000)):
        measured = [Core(side, side, robots, spread=True).measure(600, until, robots) for _ in range(3)]
        moves, bare = (max(rates) for rates in zip(*measured, strict=True))
        speeds.append((moves, bare))
        print(
            f"{f'equal density: {robots:,} robots on {side} x {side}':<46} {moves:>9,.0f} moves/s  "
            f"{bare:>10,.0f} timeouts/s of as many processes  ratio {moves / bare:.3f}",
            flush=True,
        )
    (few, bare_few), (many, bare_many) = speeds[0], speeds[-1]
    print(
        f"from 10 to 10,000 robots: cost of a move {few / many - 1:+.0%}, of a bare timeout "
        f"{bare_few / bare_many - 1:+.0%}, of a move in bare timeouts {few / bare_few * bare_many / many - 1:+.0%}"
    )


def shift() -> None:
    """An eight-hour shift of the large model, on one core."""
    world = World(dw.load(MODELS / "large.yaml"))
    begin = time.process_time()
    world.run()
    spent = time.process_time() - begin
    moves = sum(robot.body.moves for robot in world.robots)
    print(
        f"large model, 8 h, 1,000 robots: {spent:.1f} s = {world.env.now / spent:,.0f} x real time, "
        f"{moves:,} moves, {peak() / 1024:.2f} GiB at most"
    )


def report(*, long: bool = False) -> None:
    """Print all measurements; `long` also those that take minutes."""
    cells()
    core("10 robots on 6 x 4, uncontended", 6, 4, 10, 60_000)
    core("1,000 robots on 40 x 40, moderate density", 40, 40, 1000, 4_000, spread=True)
    for robots in (40, 60, 80, 120):
        core(f"{robots} robots on 6 x 4, contention", 6, 4, robots, 20_000)
    medium()
    whole("large model, 1,000 robots, all included", dw.load(MODELS / "large.yaml"), 600, 1200)
    whole("cells, 300 robots, all included", dw.load(sorting.model(300, 1000, 0)), 300, 900)
    many_stations()
    if long:
        growth()
        shift()


if __name__ == "__main__":
    import sys

    report(long="--long" in sys.argv)
