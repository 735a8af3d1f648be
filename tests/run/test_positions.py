"""Where robots are at given times, as a table."""

import pytest

import desim_warehouse as dw

MODEL = "models/multibots.yaml"


@pytest.fixture(scope="module")
def run():
    return dw.simulate(dw.load(MODEL, {"log": "all", "fleet.size": 3}))


def test_a_row_for_each_time_and_robot_in_the_order_asked_for(run):
    table = run.positions([50, 0.0, run.record.end])
    assert table["time"].tolist() == [50.0] * 3 + [0.0] * 3 + [run.record.end] * 3
    assert table["robot"].tolist() == [0, 1, 2] * 3
    assert list(table) == ["time", "robot", "x", "y", "heading", "node"]
    assert run.positions(range(0)).empty


def test_a_robot_that_leaves_a_node_is_there(run):
    entered = run.log[run.log["kind"] == "enter"].head(60)
    assert len(entered) == 60
    for time, robot, edge in zip(entered["time"], entered["robot"], entered["edge"], strict=True):
        node = run.layout.graph.nodes[edge.split(">")[0]]
        here = run.positions([time]).iloc[robot]
        assert (here["x"], here["y"]) == pytest.approx((node["x"], node["y"]))


def test_it_needs_the_whole_log():
    done = dw.simulate(dw.load(MODEL, {"log": "tasks", "fleet.size": 1}))
    with pytest.raises(dw.ReportError, match="where robots are needs log: all"):
        done.positions([0])


@pytest.mark.parametrize("time", [float("nan"), float("inf"), "5", None, [5], True])
def test_a_time_is_a_finite_number(time):
    done = dw.simulate(dw.load(MODEL, {"log": "all", "fleet.size": 1}))
    with pytest.raises(dw.ReportError, match=r"positions at time .*: expected a finite number"):
        done.positions([0, time])
