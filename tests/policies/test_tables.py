"""Tables of a situation: any robots and tasks, in any order or none, give the sub-table of the table of all."""

import itertools
import random

import numpy as np
import pytest

import desim_warehouse as dw
from tests.laws.features import warehouse
from tests.world.test_flows import RING

PAPER = "models/multibots.yaml"
FORESIGHT = {"policies.charging": "reach-aware", "tasks.station_choice": "nearest"}
INTO_STORAGE = {
    "in": {"from": "dock", "to": "storage", "arrivals": {"schedule": [{"at": 0, "tasks": 2}]}, "load_time": 9},
    "out": {"from": "storage", "to": "pack", "arrivals": {"schedule": [{"at": 0, "tasks": 3}]}},
}
MODELS = {
    "the paper's": dw.load(PAPER, {"tasks.goods": {"random": 9}}),
    "robots that turn and look ahead": dw.load(
        PAPER, {"tasks.goods": {"random": 9}, "traffic.turn_time": 2, **FORESIGHT}
    ),
    "loads into storage": dw.load(RING, {"tasks.flows": INTO_STORAGE, "fleet.size": 3}),
    "kinds and tours": dw.load(warehouse(3, "kinds tours")),
    "closures and hours": dw.load(warehouse(5, "closures hours")),
}
DECISIONS = 4


def some(items, draw):
    """The places of none, one, a few and all of some items."""
    places = list(range(len(items)))
    return [[], draw.sample(places, 1), draw.sample(places, len(places) // 2), places]


def is_part(table, whole, *places):
    """Whether a table is the part of another at some places of each of its axes, in shape and values."""
    part = whole[np.ix_(*places)]
    return table.shape == part.shape and np.allclose(table, part, rtol=1e-9, atol=0)


def decisions(model):
    """Some decisions of a run, each with at least one robot and one task."""
    for decision in itertools.islice(dw.steps(model, 1), DECISIONS):
        yield decision
        for robot, task in itertools.product(decision.robots, decision.tasks):
            if decision.feasible(robot, task):
                decision.assign(robot, task)
                break


@pytest.mark.parametrize("name", MODELS)
def test_a_table_of_some_robots_and_tasks_is_a_part_of_the_table_of_all(name):
    draw = random.Random(name)
    for decision in decisions(MODELS[name]):
        situation, tasks, robots = decision.situation, decision.tasks, decision.situation.fleet()
        approach, allowed = situation.approach(robots, tasks), situation.allowed(robots, tasks)
        delivery, onward = situation.delivery(robots[0], tasks), situation.onward(robots[0], tasks)
        assert allowed.shape == approach.shape == (len(robots), len(tasks))
        assert onward.shape == (len(tasks), len(tasks))
        for columns in some(tasks, draw):
            these = [tasks[i] for i in columns]
            assert is_part(situation.delivery(robots[0], these), delivery, columns)
            assert is_part(situation.onward(robots[0], these), onward, columns, columns)
            for rows in some(robots, draw):
                those = [robots[i] for i in rows]
                assert is_part(situation.approach(those, these), approach, rows, columns)
                assert is_part(situation.allowed(those, these), allowed, rows, columns)


@pytest.mark.parametrize("name", MODELS)
def test_a_table_of_some_nodes_is_a_part_of_the_table_of_all(name):
    model, draw = MODELS[name], random.Random(name)
    nodes, travel = list(model.floor.graph), next(dw.steps(model)).situation.travel
    for table in (travel.times, travel.lengths, travel.between):
        whole = table(nodes, nodes)
        for rows, columns in itertools.product(some(nodes, draw), repeat=2):
            assert is_part(table([nodes[i] for i in rows], [nodes[i] for i in columns]), whole, rows, columns)
