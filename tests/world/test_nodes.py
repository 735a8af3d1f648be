"""Goods at nodes, and tasks that say where they go: a ring A > B > C > D > A of four edges of 10, speed 1."""

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.check import check

RING = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [10, 10], "D": [0, 10]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"node": "B"}, {"edge": ["C", "D"], "offset": 5}, {"node": "A"}],
        "bays": {"home": {"at": ["A"]}},
        "stations": {"pack": {"at": ["D"]}, "ship": {"at": ["B", "C"]}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {"goods": [0], "unload_at": ["pack"], "station_choice": "nearest", "load_time": 5, "unload_time": 3},
}


def simulated(**changes):
    return dw.simulate(dw.load(RING, {key.replace("__", "."): value for key, value in changes.items()}))


def when(run, kind):
    return [(row.time, row.node) for row in run.history.rows(kind)]


def test_a_good_at_a_node_is_loaded_standing_on_the_node():
    run = simulated()
    assert when(run, "loading") == [(10, "B")]
    assert when(run, "loaded") == [(15, "B")]
    assert when(run, "delivered") == [(38, "D")]
    assert run.T == 48
    assert run.kpis["distance"] == 40


def test_a_good_at_the_node_of_its_own_bay_takes_no_drive():
    run = simulated(tasks__goods=[2])
    assert when(run, "loading") == [(0, "A")]
    assert when(run, "delivered") == [(38, "D")]


@pytest.mark.parametrize(
    ("to", "node", "time"),
    [("pack", "D", 38), ("C", "C", 28), ("ship", "B", 18), ("A", "A", 48)],
    ids=["a station", "a node", "the nearer node of a station", "a place in the lane"],
)
def test_a_task_goes_where_it_says(to, node, time):
    assert when(simulated(tasks__goods=[{"good": 0, "to": to}]), "delivered") == [(time, node)]


@pytest.mark.parametrize("choice", ["nearest", "least-loaded", "random", "each"])
def test_whatever_the_choice_of_others_is(choice):
    goods = [{"good": 0, "to": "C"}, {"good": 1, "to": "ship"}, 1]
    run = simulated(tasks__goods=goods, tasks__station_choice=choice)
    nodes = [node for _, node in when(run, "delivered")]
    assert nodes[0] == "C"
    assert nodes[1] in {"B", "C"}
    assert nodes[2] == "D"


def test_a_robot_that_loads_on_a_node_keeps_others_off_it():
    """Both want the good at B; the second sets out D before it when the first is a closing distance of 0.37 beyond."""
    run = simulated(tasks__goods=[0, 0], fleet__size=2)
    assert when(run, "loading") == [(10, "B"), (pytest.approx(16.366, abs=1e-3), "B")]
    assert [wait.node for wait in run.history.waits] == ["A", "B"]


def test_distances_of_policies_are_to_the_node():
    """Nearest: from A the good at B, 10 away, before that on C>D, 25 away."""
    run = simulated(tasks__goods=[1, 0], policies__allocation="nearest", tasks__unload_at=["A"])
    assert [row.value for row in run.history.rows("released")] == [1, 0]
    assert [row.task for row in run.history.rows("loading")] == [1, 0]


def test_a_decision_shows_where_a_task_lies_and_goes():
    steps = dw.steps(dw.load(RING, {"tasks.goods": [{"good": 0, "to": "ship"}]}))
    decision = next(steps)
    assert (decision.tasks[0].edge, decision.tasks[0].offset, decision.tasks[0].to) == (("B", "B"), 0, ("B", "C"))
    assert decision.situation.approach(decision.robots, decision.tasks).tolist() == [[10]]
    assert decision.situation.delivery(decision.robots[0], decision.tasks).tolist() == [8]


def test_the_hand_calculation_of_a_task_is_what_a_robot_takes():
    """Saturated with the good at B and a station beside D: 20 loaded, 20 empty, 8 of handling."""
    model = dw.load(RING, {"layout.storage": [{"node": "B"}], "tasks.goods": {"saturated": 1}, "run.length": 4800})
    assert dw.simulate(model).kpis["tasks"] == 100
    calculation = check(model).calculation
    cycle = calculation.cycle
    assert (cycle.time, cycle.empty, cycle.loaded) == pytest.approx((48, 20, 20))


def test_the_hand_calculation_knows_the_destinations_of_the_list():
    """From B to C and back 10 and 30, from B to D and back 20 and 20."""
    model = dw.load(RING, {"tasks.goods": [{"good": 0, "to": "C"}, 0]})
    calculation = check(model).calculation
    assert {item.node: item.share for item in calculation.stations} == pytest.approx({"C": 0.5, "D": 0.5}, abs=0.0025)
    assert (calculation.cycle.loaded, calculation.cycle.empty) == pytest.approx((15, 25), abs=0.025)


def test_a_battery_that_lasts_for_a_task_by_hand_does_in_a_run():
    """Standing on B for the good: 10 there, 5 loading, 20 to D, 3 unloading, 10 home are 48 time units."""
    battery = {"threshold": 0, "consumption": 1, "charge_rate": 100}
    charging = {"name": "reach-aware", "margin": 0.0}
    run = simulated(battery={"capacity": 48.001, **battery}, policies__charging=charging)
    assert run.kpis["energy_lowest"] == pytest.approx(0.001 / 48.001)
    with pytest.raises(dw.CheckError, match="good 0 draws at least 48"):
        simulated(battery={"capacity": 47.99, **battery}, policies__charging=charging)


def test_one_recalled_on_the_last_edge_to_its_good_finishes_the_task():
    """It is at the threshold after 5 of the 10 to B."""
    battery = {"capacity": 100, "threshold": 95, "consumption": 1, "charge_rate": 100}
    run = simulated(battery=battery, accept=["BATTERY_TOO_SMALL"])
    assert when(run, "returned") == []
    assert when(run, "delivered") == [(38, "D")]
