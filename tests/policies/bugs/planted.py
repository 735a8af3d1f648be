"""Policies with one planted bug each, as people write them; `# bug` marks the line that a message should name."""

import random
from dataclasses import dataclass
from itertools import count

import networkx as nx
import numpy as np

from desim_warehouse import Levels

TURNS = count()


def allowed(s, tasks):
    return [
        (robot.number, task.number) for robot, task in zip(s.robots, tasks, strict=False) if s.feasible(robot, task)
    ]


class Returns:
    def assign(self, s):  # bug
        return (s.robots[0].number, s.tasks[0].number)


class Swapped:
    def assign(self, s):  # bug
        for robot, task in zip(s.robots, s.tasks, strict=False):
            yield task.number + 50, robot.number


class Objects:
    def assign(self, s):  # bug
        yield from zip(s.robots, s.tasks, strict=False)


class NoneBack:
    def assign(self, s):  # bug
        [(robot.number, task.number) for robot, task in zip(s.robots, s.tasks, strict=False)]


class Typo:
    def assign(self, s):
        for robot in s.robots:
            yield robot.number, s.tasks[0].numbr  # bug


class Twice:
    def assign(self, s):  # bug
        for robot in s.robots:
            yield robot.number, s.tasks[0].number


class Generated:
    def assign(self, s):
        tasks = s.tasks[:]
        np.random.shuffle(tasks := list(tasks))  # noqa: NPY002
        yield from allowed(s, tasks)


class GlobalRandom:
    def assign(self, s):
        tasks = list(s.tasks)
        random.shuffle(tasks)
        yield from allowed(s, tasks)


class Unseeded:
    def assign(self, s):
        task = np.random.default_rng().choice(s.tasks)
        return allowed(s, [task])


class State:
    calls = 0

    def assign(self, s):
        State.calls += 1
        tasks = s.tasks[:: -1 if State.calls > 9 else 1]
        yield from allowed(s, tasks)


class Counted:
    def assign(self, s):
        tasks = s.tasks[:: -1 if next(TURNS) % 7 else 1]
        yield from allowed(s, tasks)


class Mutates:
    def assign(self, s):
        s.tasks[0].release = 0  # bug
        return []


class Moves:
    def assign(self, s):
        s.robots[0].energy -= 1  # bug
        return []


class WrongName:  # bug
    def allocate(self, s):
        return []


class Endless:
    def assign(self, s):
        return any(forever for forever in iter(int, 1))  # bug


class IndexOfNothing:
    def assign(self, s):
        return [(s.robots[9].number, s.tasks[0].number)]  # bug


class KeyOfDict:
    def assign(self, s):
        nodes = {robot.node: robot for robot in s.robots}
        return [(nodes["nowhere"].number, 0)]  # bug


class Negative:
    def assign(self, s):  # bug
        return [(-1, 0)]


class Text:
    def assign(self, s):  # bug
        return "01"


class Triple:
    def assign(self, s):  # bug
        return [(0, 0, 1.0)]


class WrongArguments:
    def assign(self):  # bug
        return []


class Divides:
    def assign(self, s):
        return [(0, int(1 / (len(s.robots) - len(s.robots))))]  # bug


class Exits:
    def assign(self, s):
        raise SystemExit(1)  # bug


class RouteBad:
    def route(self, a, b, roads):  # bug
        return [a, b, a, b]


class RouteNoEnd:
    def route(self, a, b, roads):  # bug
        return nx.dijkstra_path(roads.graph, a, b, weight="length")[:-1]


class RouteNone:
    def route(self, a, b, roads):  # bug
        nx.dijkstra_path(roads.graph, a, b, weight="length")


class RouteWeight:
    def route(self, a, b, roads):
        return nx.dijkstra_path(roads.graph, a, b, weight="lenght")  # bug


class RouteAttribute:
    def route(self, a, b, roads):
        return nx.dijkstra_path(roads.graph, a, b, weight=lambda i, j, of: of["distance"])  # bug


class LevelsShare:
    def levels(self, robot):  # bug
        return Levels(critical=0.2, good=0.4, sufficient=0.8, full=1.0)


class LevelsDict:
    def levels(self, robot):  # bug
        return {"critical": 2, "good": 3, "sufficient": 8, "full": 10}


class LevelsOrder:
    def levels(self, robot):  # bug
        return Levels(critical=9, good=9, sufficient=2, full=8)


class ParkObject:
    def choose(self, robot, bays, travel):  # bug
        return bays[0]


@dataclass(frozen=True)
class ParkTypo:
    def choose(self, robot, bays, travel):
        return min(bays, key=lambda bay: travel.tim(robot.node, bay.node)).node  # bug
