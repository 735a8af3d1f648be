"""What realism costs: `python -m benchmarks.plain`, a draft beside the plainest SimPy model of its floor.

In the plain model each edge and each node is a resource, each robot a process that waits for the next order and drives
the shortest way. Nothing gathers speed, no battery runs down, no two orders are compared, and robots may block each
other for ever. Both models serve 200 orders an hour. Processor time of runs without their building.
"""

from __future__ import annotations

import random
import time
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import networkx as nx
import simpy
from ruamel.yaml import YAML

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.world import World

if TYPE_CHECKING:
    from desim_warehouse.layout import Layout

ROBOTS, HOURS, AN_HOUR = 9, 6, 200
"""The fleet, the length of a run and its orders an hour."""
SPEED, TURN, LOAD, PACK = 1.5, 0.6, 10.0, 20.0
"""Metres a second, and seconds of an average turn, of a load and of a packer."""


class Plain:
    """The plain model of a floor, with what it has driven and delivered so far."""

    def __init__(self, layout: Layout, gap: float, robots: int) -> None:
        self.graph, self.env, self.random = layout.graph, simpy.Environment(), random.Random(1)
        self.lengths = {edge: layout.length(edge) for edge in layout.graph.edges}
        self.lanes = {
            edge: simpy.Resource(self.env, max(int(length / gap), 1)) for edge, length in self.lengths.items()
        }
        self.crossings = {node: simpy.Resource(self.env) for node in layout.graph}
        self.desks = {node: simpy.Resource(self.env) for node in layout.stations}
        self.orders: simpy.Store = simpy.Store(self.env)
        self.ways: dict[tuple[str, str], list[str]] = {}
        self.moves = self.done = 0
        self.env.process(self.arrivals())
        for _ in range(robots):
            self.env.process(self.robot(self.random.choice(list(self.graph))))

    def arrivals(self) -> Any:
        """Put orders from anywhere to any station."""
        nodes, stations = list(self.graph), list(self.desks)
        while True:
            yield self.env.timeout(self.random.expovariate(AN_HOUR / 3600))
            self.orders.put((self.random.choice(nodes), self.random.choice(stations)))

    def robot(self, at: str) -> Any:
        """Serve one order after the other, for ever."""
        while True:
            good, station = yield self.orders.get()
            yield from self.drive(at, good)
            yield self.env.timeout(LOAD)
            yield from self.drive(good, station)
            with self.desks[station].request() as turn:
                yield turn
                yield self.env.timeout(PACK)
            at, self.done = station, self.done + 1

    def drive(self, start: str, goal: str) -> Any:
        """Drive the shortest way, on each edge with a part of its room, and over each node alone."""
        if (start, goal) not in self.ways:
            self.ways[start, goal] = nx.shortest_path(self.graph, start, goal, lambda a, b, _: self.lengths[a, b])
        behind = None
        for edge in pairwise(self.ways[start, goal]):
            room = self.lanes[edge].request()
            yield room
            if behind is not None:
                behind.resource.release(behind)
            yield self.env.timeout(self.lengths[edge] / SPEED)
            with self.crossings[edge[1]].request() as crossing:
                yield crossing
                yield self.env.timeout(TURN)
            behind, self.moves = room, self.moves + 1
        if behind is not None:
            behind.resource.release(behind)


def drafted() -> dw.Model:
    """Draft the warehouse whose floor both models have."""
    text = draft(Draft(size=(60, 40), aisles=8, stations=3, orders=AN_HOUR, due=5, robots=ROBOTS))
    return dw.load(
        YAML(typ="safe").load(text), {"run.length": HOURS * 3600, "run.warm_up": 0, "fleet.start_energy": 1.0}
    )


def report() -> str:
    """Return the times of both models for a move and for a task, in microseconds, and their ratios."""
    model = drafted()
    world = World(model, 0)
    begin = time.process_time()
    world.run()
    ours = time.process_time() - begin
    run = dw.simulate(model, 0)
    plain = Plain(model.floor, model.fleet.contact, ROBOTS)
    begin = time.process_time()
    plain.env.run(HOURS * 3600)
    theirs = time.process_time() - begin
    lines = [f"{ROBOTS} robots, {AN_HOUR} orders an hour, {HOURS} h: {ours:.2f} s; plain SimPy {theirs:.2f} s"]
    for what, here, there in (
        ("move", run.kpis["moves"], plain.moves),
        ("task", run.kpis["tasks"], plain.done),
    ):
        mine, its = 1e6 * ours / here, 1e6 * theirs / there
        lines.append(f"a {what}: {mine:,.0f} and {its:,.0f} microseconds, {mine / its:.1f} times")
    return "\n".join(lines)


if __name__ == "__main__":
    print(report())
