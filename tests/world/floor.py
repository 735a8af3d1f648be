"""A floor for stories about traffic: robots that drive told ways, and what became of them.

Unless a story says otherwise robots keep D = 2 apart and drive 1 length unit per time unit.
"""

import math
from itertools import pairwise

import simpy

from desim_warehouse.layout import build
from desim_warehouse.layout.spec import LayoutSpec
from desim_warehouse.outcome.log import Log
from desim_warehouse.world.traffic.body import Body
from desim_warehouse.world.traffic.traffic import Traffic

PARK = "park"


class Aside:
    """A step of a robot that stands on a lane: beside that lane, in a wide aisle, for a time."""

    def __init__(self, time):
        self.time = time


class Floor:
    """Nodes by name and place, edges as "A>B" or (edge, length) or (edge, length, speed limit), lifts as in a model."""

    def __init__(self, nodes, edges, *, D=2.0, theta=30.0, node_time=0.0, rotate=True, mixed=True, **special):  # noqa: N803
        lifts = special.pop("lifts", {})
        pairs = {frozenset(name.split(">")) for name in edges if isinstance(name, str)}
        spec = {"nodes": nodes, "edges": [_edge(edge) for edge in edges], "lifts": lifts}
        for edge in spec["edges"] if lifts else ():  # lanes there and back lie side by side
            edge["side_by_side"] = frozenset((edge["from"], edge["to"])) in pairs
        self.layout = build(LayoutSpec.model_validate(spec))
        self.env = simpy.Environment()
        self.log = Log("all")
        self.traffic = Traffic(
            self.env,
            self.layout,
            self.log,
            contact=D,
            theta=math.radians(theta),
            node_time=node_time,
            mixed=mixed,
            rule="rotate" if rotate else "stop",
            **special,
        )
        self.robots = []

    def robot(self, *steps, start=0.0, speed=1.0, motion=None, looks_ahead=False):
        """A robot, in the bay at the first node of its way until `start`.

        A step is a way such as "A B C" to the end of its last edge; (way, offset) to a stop on its last edge; a number
        of time units to stand still; Aside(time) beside the lane; or PARK, into the bay beside the node. Each way goes
        on where the last one ended: after ("A B", 4) comes "B C". `motion`: how it gathers speed and brakes;
        `looks_ahead`: it keeps its braking distance.
        """
        first = steps[0] if isinstance(steps[0], str) else steps[0][0]
        robot = Body(len(self.robots), speed, self.traffic.nodes[first.split()[0]], motion=motion)
        if looks_ahead:
            robot.keep_braking_distance(self.env)
        self.robots.append(robot)
        self.env.process(self._story(robot, steps, start))
        return robot

    def _story(self, robot, steps, start):
        yield self.env.timeout(start)
        for step in steps:
            if step == PARK:
                self.traffic.into_bay(robot)
            elif isinstance(step, (int, float)):
                yield self.env.timeout(step)
            elif isinstance(step, Aside):
                lane = robot.lane
                is_aside = yield from lane.stand_aside(robot)
                yield self.env.timeout(step.time)
                if is_aside:
                    yield from lane.come_back(robot)
            else:
                way, stop = (step, None) if isinstance(step, str) else step
                lanes = [self.traffic.lanes[edge] for edge in pairwise(way.split())]
                yield from self.traffic.drive(robot, lanes, stop)
                self.log.event(self.env.now, "there", robot.number, -1, None, None)

    def run(self):
        self.env.run()
        self.log.close(self.env.now)
        return self

    # What became of them

    def there(self, robot):
        """When it was at the end of each of its ways."""
        return [row[0] for row in self.log.rows if row[1] == "there" and row[2] == robot.number]

    def enters(self, robot):
        """When its centre left each node, by the edge that it took."""
        return {">".join(row[5]): row[0] for row in self.log.rows if row[1] == "enter" and row[2] == robot.number}

    def waits(self, robot):
        """Its waiting episodes in order of time: (where, begin, end, the robot waited for)."""
        return [
            (row[4] or ">".join(row[5]), row[0] - row[6], row[0], row[8])
            for row in self.log.rows
            if row[1] == "collision" and row[2] == robot.number
        ]

    @property
    def S(self):  # noqa: N802 - the paper's name
        return sum(robot.rear_ends + robot.crossings for robot in self.robots)


def _edge(edge):
    name, length, speed = (edge, None, None) if isinstance(edge, str) else (*edge, None)[:3]
    source, target = name.split(">")
    return {"from": source, "to": target, "length": length, "speed": speed}


def line(names, *lengths, limits=None, **settings):
    """A straight street through the nodes, edge by edge of these lengths."""
    names, x = names.split(), [0.0]
    for length in lengths:
        x.append(x[-1] + length)
    edges = [(f"{a}>{b}", length) for (a, b), length in zip(pairwise(names), lengths, strict=True)]
    if limits:
        edges = [(*edge, limit) for edge, limit in zip(edges, limits, strict=True)]
    return Floor({name: (at, 0.0) for name, at in zip(names, x, strict=True)}, edges, **settings)


def crossing(**settings):
    """West > X > East and North > X > South, all 10 long, at right angles; N > X > E merges."""
    nodes = {"W": (0, 10), "X": (10, 10), "E": (20, 10), "N": (10, 0), "S": (10, 20)}
    return Floor(nodes, ["W>X", "X>E", "N>X", "X>S"], **settings)
