"""Random models by number: whole warehouses at the limits of what a model file allows.

`model(17)` is always an identical model. Lengths are D and 2 D plus or minus very little, where one rule of traffic
takes over from another. Batteries have few chargers, robots several speeds, stations one place, and runs a warm-up and
an end at any time. All our policies are used.

A full battery lasts for any single task on any route, and `reserve` covers waiting in traffic. So no robot should run
flat, and no task remain undone.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field
from itertools import pairwise

import networkx as nx

OFF = (0.0, 1e-9, -1e-9, 1e-7, -1e-7, 1e-6, -1e-6, 1e-5, -1e-5)
"""Deviations of lengths from a multiple of D."""
LEAST = 1e-9
"""Least length."""
SPEEDS = (0.2, 0.5, 1.0, 1.5)
ALLOCATION = ("in-order", "nearest", "nearest-aging", "earliest-due", "hungarian", "regret", "auction", "cost-aware")
PATIENCE = 1000
"""Laps after which work that ends is given up; it takes a few dozen."""
CUT, WHOLE = "ends at an instant", "ends when the work is done"
"""Names of models whose runs are cut off, or must come to their end."""
CHOICES = ("each", "nearest", "least-loaded", "random")


@dataclass
class Ground:
    """A layout, with its facts for the rest of a model."""

    layout: dict
    nodes: list[str]
    goods: int
    around: float
    """A bound on the length of routes without a circle."""


@dataclass
class Draw:
    """The random draws of a model."""

    random: random.Random
    contact: float = 1.0
    slowest: float = 1.0
    grounds: tuple[str, ...] = ("flower", "flower", "grid", "blocks")
    ground: Ground = field(init=False)

    def some(self, chance):
        return self.random.random() < chance

    def length(self):
        """Draw a length: near a multiple of D, or uniform between 0.5 D and 8 D."""
        if self.some(0.75):
            return self.random.choice((1, 1, 2, 2, 2, 3, 5)) * self.contact + self.random.choice(OFF)
        return self.random.uniform(0.5, 8) * self.contact

    # Layouts

    def storage(self, edges):
        """Draw storage places anywhere on the edges, often just clear of a node."""
        places = []
        for _ in range(self.random.randint(1, 10)):
            (a, b), length = self.random.choice(list(edges.items()))
            exact = [p for p in (self.contact, length - self.contact, length * (1 - 1e-6)) if LEAST <= p < length]
            offset = self.random.choice([self.random.uniform(0.02, 0.98) * length, *exact])
            places.append({"edge": [a, b], "offset": offset})
        return places

    def drawn(self, positions, edges):
        """Draw a layout of nodes and edges, some of which have a speed limit."""
        limits = {edge: self.random.choice((0.1, 0.4, 0.8)) for edge in edges if self.some(0.1)}
        self.slowest = min([self.slowest, *limits.values()])
        rows = [
            {
                "from": a,
                "to": b,
                "length": length,
                "speed": limits.get((a, b)),
                "side_by_side": edges.get((b, a), length) != length or limits.get((b, a)) != limits.get((a, b)),
            }
            for (a, b), length in edges.items()
        ]
        storage = self.storage(edges)
        layout = {"nodes": positions, "edges": rows, "storage": storage}
        return Ground(layout, list(positions), len(storage), math.fsum(edges.values()))

    def flower(self):
        """Draw a one-way ring with smaller rings at some of its nodes; edges are longer than drawn."""
        n = self.random.randint(3, 6)
        positions = {
            f"c{i}": (round(9 * math.cos(2 * math.pi * i / n), 3), round(9 * math.sin(2 * math.pi * i / n), 3))
            for i in range(n)
        }
        edges = {(f"c{i}", f"c{(i + 1) % n}"): self.length() for i in range(n)}
        for petal in range(self.random.randint(0, 4)):
            root = f"c{self.random.randrange(n)}"
            angle = 2 * math.pi * self.random.random()
            names = [f"p{petal}.{i}" for i in range(self.random.randint(1, 3))]
            for i, name in enumerate(names):
                x, y = 20 + 5 * petal, 3 + 2 * i
                positions[name] = (
                    round(x * math.cos(angle) - y * math.sin(angle), 3),
                    round(x * math.sin(angle) + y * math.cos(angle), 3),
                )
            edges |= {pair: self.length() for pair in pairwise([root, *names, root])}
            if len(names) == 1 and self.some(0.5):  # there and back on one lane
                edges[names[0], root] = edges[root, names[0]]
        return self.drawn(positions, edges)

    def grid(self):
        """Draw straight streets, one-way with every node reachable (Robbins: depth-first), or some of them two-way."""
        wide, high = self.random.randint(2, 4), self.random.randint(2, 3)
        xs, ys = [0.0], [0.0]
        for places, count in ((xs, wide), (ys, high)):
            for _ in range(count - 1):
                places.append(places[-1] + self.length())
        streets = nx.grid_2d_graph(wide, high)
        order = sorted(streets)
        self.random.shuffle(order)
        rank = {node: i for i, node in enumerate(order)}
        depth, lanes = {}, []

        def visit(node, parent):
            depth[node] = len(depth)
            for other in sorted(streets[node], key=rank.get):
                if other not in depth:
                    lanes.append((node, other))
                    visit(other, node)
                elif other != parent and depth[other] < depth[node]:
                    lanes.append((node, other))

        visit(order[0], None)
        name = {node: f"n{node[0]}.{node[1]}" for node in streets}
        positions = {name[node]: (xs[node[0]], ys[node[1]]) for node in sorted(streets)}
        edges = {(name[a], name[b]): math.dist(positions[name[a]], positions[name[b]]) for a, b in lanes}
        both = self.random.choice((0.0, 0.0, 0.1, 0.5))
        edges |= {(b, a): length for (a, b), length in edges.items() if self.some(both)}
        return self.drawn(positions, edges)

    def blocks(self):
        """Draw blocks of goods, with aisles from shorter than D to many D long."""
        pick = self.random
        columns, rows, depth = pick.randint(1, 3), pick.randint(1, 2), pick.randint(1, 5)
        size, aisle = self.length() / pick.choice((1, 2, depth)), self.contact * pick.choice((1.0, 1.0 + 1e-6, 1.5))
        width = pick.randint(1, 2)
        layout = {
            "columns": columns,
            "rows": rows,
            "block_width": width,
            "block_depth": depth,
            "goods_size": size,
            "aisle_width": aisle,
        }
        names = [chr(ord("A") + i) for i in range((columns + 1) * (rows + 1))]
        across, down = columns * (width * size + aisle), rows * (depth * size + aisle)
        around = across * (rows + 1) + down * (columns + 1)
        return Ground({"blocks": layout}, names, columns * rows * width * depth, around)

    # What happens there

    def bays(self, size, battery):
        """Draw the nodes at which robots start, and bays; with a battery there are chargers, often few."""
        names = self.ground.nodes
        start = self.random.sample(names, self.random.randint(1, min(3, len(names))))
        home = {"at": start}
        if self.some(0.4):
            home["places"] = -(-size // len(start)) + self.random.randint(0, 2)
        bays = {"home": home}
        others = [name for name in names if name not in start]
        if battery and others and self.some(0.6):
            home["chargers"] = self.random.choice((0, 0, 1))
            bays["chargers"] = {
                "at": self.random.sample(others, self.random.randint(1, min(2, len(others)))),
                "places": self.random.randint(1, 3),
                "chargers": 1,
            }
        elif others and self.some(0.3):
            bays["spare"] = {"at": [self.random.choice(others)], "places": 1, "chargers": self.random.randint(0, 1)}
        return start, bays

    def kinds(self, size):
        """Draw up to three kinds of robots, each with its speed."""
        kinds, left = {}, size - 1
        for rank in range(self.random.choice((0, 0, 1, 2, 3))):
            if left > 0:
                count = self.random.randint(1, left)
                speed = self.random.choice(SPEEDS)
                kinds[f"kind{rank}"] = {"count": count, "speed": speed}
                self.slowest = min(self.slowest, speed)
                left -= count
        return kinds

    def goods(self, lap):
        """Draw a list of goods, random goods, or endless work, some of them with due times."""
        form = self.random.choice(("list", "list", "random", "saturated", "poisson"))
        if form == "random":
            return {"random": self.random.randint(1, 30)}
        if form == "saturated":
            return {"saturated": self.random.randint(1, 10), **self.due(lap)}
        if form == "poisson":
            return {"poisson": 3600 / (lap * self.random.uniform(0.05, 1)), **self.due(lap)}
        goods = []
        for _ in range(self.random.randint(1, 25)):
            good = self.random.randrange(self.ground.goods)
            if self.some(0.7):
                goods.append(good)
                continue
            release = self.random.choice((0.0, self.random.uniform(0, 5 * lap)))
            goods.append({"good": good, "release": release, "priority": self.random.randint(0, 2)})
            if self.some(0.5):
                goods[-1]["due"] = release + self.random.uniform(0, 5 * lap)
        return goods

    def due(self, lap):
        return {"due_within": self.random.uniform(0.2, 5) * lap} if self.some(0.4) else {}

    def battery(self, lap):
        """Draw a battery that lasts for any single task with all its ways, and more."""
        rate = self.random.choice((1, 0.01))
        consumption = rate
        if self.some(0.4):
            standing, empty, loaded, handling = (rate * self.random.choice((0.2, 0.5, 1.0)) for _ in range(4))
            consumption = {"standing": standing, "empty": empty, "loaded": loaded, "handling": handling}
        capacity = rate * lap * self.random.choice((6.5, 6.5, 10, 30))
        battery = {
            "capacity": capacity,
            "threshold": capacity * self.random.choice((0.1, 0.3, 0.6)),
            "consumption": consumption,
            "charge_rate": rate * self.random.choice((0.5, 3, 20)),
            "reserve": 1e9 * rate,
        }
        if battery["charge_rate"] < rate:  # waiting robots must draw little, or batteries would fall forever
            loads = ("empty", "loaded", "handling")
            drawn = consumption if isinstance(consumption, dict) else dict.fromkeys(loads, rate)
            battery["consumption"] = {**drawn, "standing": 0.01 * rate}
        if self.some(0.3):
            battery["taper"] = {"start": self.random.choice((0.5, 0.8)), "end_rate": self.random.choice((0.1, 0.5))}
        return battery

    def start_energy(self, battery):
        """Draw the initial levels: mostly full, else equal or random, but not so low that one charger is too few."""
        if battery is None or self.some(0.7):
            return 1
        return self.random.choice((0.3, 0.5, 0.9, {"uniform": [0.2, 1]}, {"uniform": [0.3, 0.5]}))

    def charging(self, lap):
        charger = self.random.choice(("own", "nearest", "least-loaded"))
        margin = self.random.choice((0.0, 0.1, 0.2))
        return self.random.choice(
            (
                "threshold",
                {"name": "threshold", "charger": charger},
                {"name": "reach-aware", "margin": margin, "charger": charger},
                {
                    "name": "opportunity",
                    "minimum": self.random.choice((0.0, 0.2, 0.4)),
                    "margin": margin,
                    "charger": charger,
                },
                {
                    "name": "four-thresholds",
                    "critical": 0.1,
                    "good": self.random.choice((0.3, 0.6)),
                    "sufficient": self.random.choice((0.2, 0.5)),
                    "margin": margin,
                    "charger": charger,
                },
                {"name": "swap", "time": self.random.choice((0.0, 0.3 * lap)), "margin": margin, "charger": charger},
            )
        )

    def policies(self, lap):
        allocation = self.random.choice(ALLOCATION)
        if allocation in {"regret", "auction"}:
            allocation = {"name": allocation, "depth": self.random.randint(1, 4), "commit": self.some(0.5)}
        routing = self.random.choice(
            ("highways", "shortest", "fastest", {"name": "congestion-aware", "detours": self.random.randint(0, 3)})
        )
        return {
            "allocation": allocation,
            "routing": routing,
            "charging": self.charging(lap),
            "parking": self.random.choice(("home", "stay", "nearest", "spread")),
            "interval": self.random.choice((0, 0, 0, 0.1 * lap, self.random.uniform(0, lap))),
        }

    def run(self, goods, lap):
        """Draw the length and warm-up of the run, and whether it is cut off."""
        lifelong = isinstance(goods, dict) and "random" not in goods
        early = lifelong or self.some(0.4)
        length = self.random.uniform(1, 25) * lap if early else PATIENCE * lap
        warm_up = self.random.uniform(0, 0.9) * (length if early else 3 * lap) if self.some(0.5) else 0.0
        return {"length": length, "warm_up": warm_up}, early

    def whole(self):
        """Draw the whole model."""
        pick = self.random
        radius, margin = pick.choice((0.2, 0.5)), pick.choice((0.0, 0.04, 0.2))
        self.contact = 2 * radius + margin
        self.slowest = speed = pick.choice(SPEEDS)
        size = pick.choice((1, 2, 3, pick.randint(1, 12), pick.randint(1, 25)))
        kinds = self.kinds(size)
        self.ground = getattr(self, pick.choice(self.grounds))()
        node_time = pick.choice((0.0, 0.0, 0.4, 3.0))
        handling = [pick.choice((0.0, 1.0, 7.5)) for _ in range(3)]
        exits = [pick.choice((0.0, 2.0)) for _ in range(2)]
        lap = self.ground.around / self.slowest + node_time * len(self.ground.nodes) + sum(handling) + sum(exits)
        battery = self.battery(lap) if self.some(0.6) else None
        start, bays = self.bays(size, battery)
        if battery:
            enough_at_rest(battery, chargers_of(bays, size), size)
        unload = pick.sample(self.ground.nodes, pick.randint(1, min(3, len(self.ground.nodes))))
        choice = "each" if len(unload) == 1 and self.some(0.5) else pick.choice(CHOICES[1:])
        stations = {}
        for i, node in enumerate(unload):
            if self.some(0.6):
                places = pick.choice((1, 1, 2, 4))
                stations[f"s{i}"] = {"at": [node], "places": places, "servers": pick.randint(1, min(2, places))}
        goods = self.goods(lap)
        run, early = self.run(goods, lap)
        return {
            "name": CUT if early else WHOLE,
            "layout": {**self.ground.layout, "bays": bays, "stations": stations},
            "fleet": {
                "size": size,
                "start": start,
                "robot": {"radius": radius, "speed": speed, "margin": margin},
                "kinds": kinds,
                "start_energy": self.start_energy(battery),
                "first_exit_time": exits[0],
                "exit_time": exits[1],
            },
            "tasks": {
                "goods": goods,
                "unload_at": unload,
                "station_choice": choice if choice != "each" or len(unload) == 1 else "nearest",
                "load_time": handling[0],
                "unload_time": handling[1],
                "clear_time": handling[2],
            },
            "battery": battery,
            "traffic": {"collision_angle": pick.choice((0, 30, 45, 90)), "node_time": node_time},
            "policies": self.policies(lap),
            "run": run,
            "cost": {"distance": 0.5, "time": 2.0, "collisions": 30.0},
        }


def chargers_of(bays, size):
    """How many chargers there are for a fleet; where a bay does not say, each of its slots has one."""
    if any("chargers" not in bay for bay in bays.values()):
        return size
    return sum(bay["chargers"] * len(bay["at"]) for bay in bays.values())


def enough_at_rest(battery, chargers, size):
    """Raise the rate of chargers that give a fleet at rest less than it draws: batteries would fall for ever.

    A tenth of what they give is for drives to a charger and back; tapered, a charger gives the least rate at the end.
    """
    drawn = battery["consumption"]
    standing = drawn["standing"] if isinstance(drawn, dict) else drawn
    gives = 0.9 * chargers * battery.get("taper", {"end_rate": 1})["end_rate"]
    battery["charge_rate"] = max(battery["charge_rate"], (size - chargers) * standing / gives)


MOST = 1e12
"""The largest amount of energy in a model."""


def lasting(battery, times):
    """Return a battery that lasts `times` as long, and is charged in an equal time; None without a battery."""
    amounts = ("capacity", "threshold", "charge_rate", "reserve")
    return battery and {**battery, **{key: min(times * battery[key], MOST) for key in amounts if key in battery}}


def model(number):
    """Return the model of a number as a mapping; the number is also the seed of its run."""
    return Draw(random.Random(number)).whole()
