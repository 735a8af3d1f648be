"""Nodes that differ: another time at one of them, and nodes at which nobody waits for another. D = 2, speed 1."""

import math

import pytest

import desim_warehouse as dw
from tests.accounting import faults
from tests.laws.faults import endless, standstill
from tests.laws.features import warehouse
from tests.recount import differences
from tests.world.floor import PARK, crossing, line

near = pytest.approx
MODEL = "models/multibots.yaml"


def test_at_a_free_node_nobody_waits_for_the_one_that_crosses():
    floor = crossing(free=["X"])
    first, second = floor.robot("W X E", PARK), floor.robot("N X S", PARK)
    floor.run()
    # 20 to the end, as if alone; at a node that is not free the second loses 2 (cos 30° + sin 30° - 1) = 0.73
    assert (floor.there(first), floor.there(second), floor.S) == ([near(20)], [near(20)], 0)


def test_on_the_lane_beyond_robots_keep_d_as_everywhere():
    floor = crossing(free=["X"])
    first, second = floor.robot("W X E", PARK), floor.robot("N X E", PARK)
    floor.run()
    # both reach X at 10; the second sets out when the first is D beyond, and waits for it on X>E, not at X
    assert floor.waits(first) == []
    assert [(where, whom) for where, _, _, whom in floor.waits(second)] == [("X>E", 0)]
    assert (floor.enters(first)["X>E"], floor.enters(second)["X>E"]) == (near(10), near(12))
    assert floor.there(second) == [near(22)]


def test_several_robots_stand_on_a_free_node_at_once():
    floor = crossing(free=["X"])
    stays, passes = floor.robot("W X", 50, "X E", PARK), floor.robot("N X S", PARK)
    floor.run()
    assert (floor.there(stays)[0], floor.there(passes)[0], floor.S) == (near(10), near(20), 0)


def test_the_time_of_a_node_is_spent_there_and_nowhere_else():
    floor = line("A B C D", 10, 10, 10, node_time=1, node_times={"B": 5})
    robot = floor.robot("A B C D", PARK)
    floor.run()
    # 10, 5 on B, 10, 1 on C, 10, 1 on D
    assert floor.there(robot) == [near(37)]


def test_a_slow_node_holds_up_who_comes_behind_and_free_it_does_not():
    def second(**settings):
        floor = crossing(node_times={"X": 5}, **settings)
        floor.robot("W X E", PARK)
        robot = floor.robot("N X S", PARK)
        floor.run()
        return floor.there(robot)[0]

    c = 2 * (math.cos(math.radians(30)) + math.sin(math.radians(30)) - 1)
    # the first leaves X at 15; the second sets off from its stop line 2 before X when it is c beyond, and is 5 on X
    assert second() == near(15 + c + 2 + 5 + 10)
    assert second(free=["X"]) == near(25)


def test_policies_and_batteries_know_the_time_of_a_node():
    alone = {"fleet.size": 1, "battery": None}
    usual, slow = (dw.load(MODEL, {**alone, "traffic.nodes.L": node}) for node in ({}, {"time": 100}))
    runs = [dw.simulate(model) for model in (usual, slow)]
    assert runs[0].T == dw.simulate(dw.load(MODEL, alone)).T
    passages = sum(runs[1].edges.passages[edge] for edge in runs[1].edges.index if edge.startswith("L>"))
    assert near(runs[0].T + passages * (100 - 1.5)) == runs[1].T
    from desim_warehouse.model.facts.ahead import free_travel

    times = [free_travel(model, model.floor).time("K", "R") for model in (usual, slow)]
    assert times[1] > times[0]


def test_a_model_says_which_nodes_are_free_and_older_ones_keep_their_digest():
    model = dw.load(MODEL)
    assert "nodes" not in model.content()["traffic"]
    freed = model.replace({"traffic.nodes.M.free": True})
    assert freed.content()["traffic"]["nodes"]["M"]["free"] is True
    runs = [dw.simulate(one.replace({"tasks.goods": {"random": 30}})) for one in (model, freed)]
    assert runs[0].nodes.waits["M"] > runs[1].nodes.waits["M"] == 0


def test_a_node_that_the_layout_does_not_have_is_refused():
    with pytest.raises(dw.ModelError, match=r"traffic\.nodes\.ZZ: no such node, expected one of the 18 nodes"):
        dw.load(MODEL, {"traffic.nodes.ZZ.free": True})


@pytest.mark.parametrize("part", [0, *(pytest.param(part, marks=pytest.mark.long) for part in (1, 2, 3))])
def test_work_goes_on_and_everything_adds_up_with_free_nodes_anywhere(part):
    """Random models, every other node of them free, or all, one slow."""
    for number in range(8 * part, 8 * part + 8):
        mapping = warehouse(number)
        names = list(dw.load(mapping).layout.nodes) or ["A", "B", "C", "D"]
        some = names[:: 1 + number % 2]
        nodes = {name: {"free": True} for name in some} | {names[0]: {"free": number % 3 == 0, "time": 3.0}}
        traffic = {**mapping.get("traffic", {}), "nodes": nodes}
        try:
            model = dw.load({**mapping, "traffic": traffic})
        except dw.ModelError:
            continue  # a block layout with other names
        run = dw.simulate(model, number)
        problems = [*standstill(run), *endless(run), *differences(run), *faults(run)]
        assert not problems, (number, problems[:3])
