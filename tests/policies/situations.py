"""Situations made by hand: places on a line of nodes, times given as a table."""

import math

import numpy as np

from desim_warehouse.policies import Handling, RobotView, Situation, Task


class Table:
    """Travel by a table of times {(origin, goal): time}; lengths are the same numbers."""

    def __init__(self, times):
        self._times = times

    def time(self, origin, goal):
        return self._times[origin, goal]

    distance = time

    def times(self, origins, goals):
        return np.array([[float(self._times[o, g]) for g in goals] for o in origins])

    lengths = times

    def way(self, origin, goal):
        return [origin, goal]


def task(number, place, **more):
    return Task(number, number, (place, place + "'"), 0.0, **more)


def robot(number, node, **more):
    return RobotView(number, node, node, 10.0, 10.0, 3.0, **more)


def situation(robots, tasks, times, *, forbidden=(), busy=(), station="S", waits=None, collisions=None, time=0.0):
    forbidden = set(forbidden)

    def may(one, other):
        return (one.number, other.number) not in forbidden

    return Situation(
        time=time,
        robots=robots,
        tasks=tasks,
        travel=Table(times),
        station=lambda *_: station,
        feasible=may,
        may=may,
        allowed=lambda some, others: np.array([[may(r, t) for t in others] for r in some]),
        fleet=lambda: [*robots, *busy],
        waits=lambda: waits or {},
        collisions=lambda: collisions or {},
        random=lambda: np.random.default_rng(0),
        handling=Handling(load_time=1, unload_time=2, clear_time=0),
        length=lambda edge: 0.0,
        tour_time=lambda one, other: math.nan,  # no tours here
    )


def table(rows, robots="abcdef", tasks="uvwxyz"):
    """Times from robots at a, b, ... (rows) to goods at u, v, ... (columns)."""
    return {(robots[i], tasks[j]): value for i, row in enumerate(rows) for j, value in enumerate(row)}


def world_of(rows):
    """Robots and tasks of a table."""
    return (
        [robot(i, "abcdef"[i]) for i in range(len(rows))],
        [task(10 + j, "uvwxyz"[j]) for j in range(len(rows[0]))],
        table(rows),
    )
