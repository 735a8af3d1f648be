"""Robots take time to turn: a ring A > B > C > D > A of four edges of 10, speed 1, D = 1, 4 for every right angle."""

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.check import check
from tests.auditor import audit
from tests.world import ring

RING = {
    **ring.RING,
    "fleet": {**ring.RING["fleet"], "size": 1},
    "tasks": {**ring.RING["tasks"], "goods": [1]},
    "traffic": {"turn_time": 4},
}


def simulated(model=RING, **changes):
    return dw.simulate(dw.load(model, {key.replace("__", "."): value for key, value in changes.items()}))


def when(run, kind):
    return [(row.time, row.node) for row in run.history.rows(kind)]


def entered(run, robot=0):
    return [(row.time, ">".join(row.edge)) for row in run.history.rows("enter") if row.robot == robot]


def test_it_turns_on_every_corner_and_not_out_of_a_bay_or_station():
    run = simulated()
    assert entered(run) == [(0, "A>B"), (14, "B>C"), (28, "C>D"), (46, "D>A")]
    assert when(run, "loading") == [(33, "D")]
    assert run.T == 56
    assert audit(run) == []


def test_node_time_comes_on_top():
    assert entered(simulated(traffic__node_time=1)) == [(0, "A>B"), (15, "B>C"), (30, "C>D"), (48 + 1, "D>A")]


def test_after_loading_on_a_node_it_turns_to_the_edge_that_it_leaves_by():
    assert entered(simulated(tasks__goods=[0])) == [(0, "A>B"), (19, "B>C"), (33, "C>D"), (46, "D>A")]


def test_it_turns_round_at_the_end_of_a_spur():
    spur = {
        "nodes": {"A": [0, 0], "B": [10, 0]},
        "edges": [{"from": "A", "to": "B", "two_way": True}],
        "storage": [{"node": "B"}],
        "bays": {"home": {"at": ["A"]}},
    }
    run = simulated({**RING, "layout": spur, "tasks": {**RING["tasks"], "goods": [0], "unload_at": ["A"]}})
    assert entered(run) == [(0, "A>B"), (10 + 5 + 8, "B>A")]
    assert audit(run) == []


def test_others_wait_while_one_turns():
    """The second is D behind at the corner, and may cross D beyond it."""
    run = simulated(fleet__size=2, tasks__goods=[1, 1])
    first, second = entered(run), entered(run, 1)
    assert first[1] == (14, "B>C")
    assert second[1][0] > 14 + 4
    assert audit(run) == []


def test_the_hand_calculation_of_a_task_is_what_a_robot_takes():
    """From D: 10 to A, turn, 10 to B, turn, 10 to C, turn, 5 to the good; 5 to load, 5 to D, 3 to unload."""
    changes = {"layout.storage": [RING["layout"]["storage"][1]], "tasks.goods": {"saturated": 1}}
    model = dw.load(RING, {**changes, "run.length": 6000, "run.warm_up": 600})
    cycle = check(model).calculation.cycle
    assert (cycle.empty, cycle.loaded, cycle.time) == pytest.approx((47, 5, 60))
    assert dw.simulate(model).kpis["tasks"] == 90


def test_a_decision_does_not_see_the_turns_at_the_ends_of_a_route():
    steps = dw.steps(dw.load(RING))
    decision = next(steps)
    assert decision.situation.approach(decision.robots, decision.tasks).tolist() == [[10 + 4 + 10 + 5]]


def test_a_battery_lasts_for_the_turns():
    """56 for the task by itself and 10 home; half turns where nobody knows how it stands count on top."""
    battery = {"capacity": 56 + 3 * 8, "threshold": 0, "consumption": 1, "charge_rate": 100}
    charging = {"name": "reach-aware", "margin": 0.0}
    assert simulated(battery=battery, policies__charging=charging).kpis["tasks"] == 1


@pytest.mark.parametrize("routing", ["fastest", "shortest", "highways", "congestion-aware"])
def test_a_ring_of_waiting_robots_turns_with_them(routing):
    nodes = [{"node": node} for node in "ABCD"]
    places = [{"edge": list(edge), "offset": offset} for edge in ("AB", "BC", "CD", "DA") for offset in range(1, 10)]
    run = simulated(
        fleet__size=40,
        fleet__start_on_lanes=[*places, *nodes],
        tasks__goods={"random": 60},
        tasks__unload_at=["C"],
        policies__routing=routing,
    )
    assert run.kpis["tasks"] == 60
    assert run.kpis["rotations"] > 0
    assert audit(run) == []
