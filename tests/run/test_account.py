"""The account of time: a model in which every second is worked out by hand, and what is refused.

That the parts of any run add up is a law (tests/laws).
"""

import pytest

import desim_warehouse as dw
from desim_warehouse.outcome.account import OF_ROBOTS, OF_TASKS
from desim_warehouse.states import STATES
from tests.accounting import faults
from tests.run.ring import ring


def two_robots():
    """Two robots go round the ring of 120 for two goods, to a station with one server, home to one charger.

    An hour has 60 units of time. Counted from 5 on, to 150.

    Robot 0: drives to the good until 10, loads until 13, drives to the station until 63, unloads until 68, is home at
    128, charges the 128 that it drew until 140.8, rests until a third good is released at 145, drives to it.

    Robot 1: waits in the bay until the node before it is free, D behind robot 0, at 1. It stands behind robot 0, which
    loads, from 10 to 13; at the good at 14, loads until 17, drives to the station until 67, queues for the server
    until 68, unloads until 73, is home at 133, queues for the charger until 140.8, charges until the end.
    """
    model = ring({"capacity": 1000, "threshold": 10, "consumption": 1, "charge_rate": 10}, 150)
    model["layout"]["bays"]["home"] |= {"places": 2, "chargers": 1}
    model["layout"]["stations"] = {"pack": {"at": ["C"], "places": 2, "servers": 1}}
    model["fleet"]["size"] = 2
    model["tasks"]["goods"] = [0, 0, {"good": 0, "release": 145}]
    model["run"]["warm_up"] = 5
    model["units"] = {"seconds": 60}
    return model


@pytest.fixture(scope="module")
def run():
    return dw.simulate(dw.load(two_robots()))


def parts(table):
    """The parts of each row that are not 0."""
    return {name: {part: value for part, value in row.items() if value} for name, row in table.iterrows()}


def test_the_time_of_robots_is_divided_as_worked_by_hand(run):
    assert parts(run.account("robot")) == {
        0: pytest.approx(
            {"empty": 5 + 5, "loading": 3, "loaded": 50, "unloading": 5, "returning": 60, "charging": 12.8, "idle": 4.2}
        ),
        1: pytest.approx(
            {
                "empty": 5 + 1,
                "behind_robot": 3,
                "loading": 3,
                "loaded": 50,
                "queueing_server": 1,
                "unloading": 5,
                "returning": 60,
                "queueing_charger": 7.8,
                "charging": 9.2,
            }
        ),
    }


def test_the_time_of_tasks_from_their_release_on_warm_up_or_not(run):
    assert parts(run.account("task")) == {
        0: pytest.approx({"empty": 10, "loading": 3, "loaded": 50, "unloading": 5}),
        1: pytest.approx(
            {
                "before_intersection": 1,
                "empty": 9 + 1,
                "behind_robot": 3,
                "loading": 3,
                "loaded": 50,
                "queueing_server": 1,
                "unloading": 5,
            }
        ),
        2: pytest.approx({"empty": 5}),  # open at the end
    }


def test_the_time_spent_on_edges(run):
    assert parts(run.account("edge")) == {
        "A>B": pytest.approx({"empty": 10 + 6, "behind_robot": 3, "loading": 6, "loaded": 40}),
        "B>C": pytest.approx({"loaded": 60}),
        "C>D": pytest.approx({"returning": 60}),
        "D>A": pytest.approx({"returning": 60}),
    }


def test_the_time_spent_at_nodes_before_them_in_bays_and_in_stations(run):
    assert parts(run.account("node")) == {
        "A": pytest.approx({"charging": 12.8 + 9.2, "queueing_charger": 7.8, "idle": 4.2}),
        "B": {},
        "C": pytest.approx({"unloading": 10, "queueing_server": 1}),
        "D": {},
    }


def test_without_a_warm_up_robot_1_waits_in_its_bay_before_the_node():
    model = two_robots()
    del model["run"]["warm_up"]
    before = dw.simulate(dw.load(model)).account("node")["before_intersection"]
    assert before.to_dict() == pytest.approx({"A": 1, "B": 0, "C": 0, "D": 0})


def test_the_time_of_the_fleet_hour_by_hour_from_the_end_of_the_warm_up(run):
    assert parts(run.account("hour")) == {
        0: pytest.approx(  # 5 to 65
            {"empty": 5 + 6, "behind_robot": 3, "loading": 6, "loaded": 50 + 48, "unloading": 2}
        ),
        1: pytest.approx(  # to 125
            {"loaded": 2, "queueing_server": 1, "unloading": 3 + 5, "returning": 57 + 52}
        ),
        2: pytest.approx(  # to 150
            {"empty": 5, "returning": 3 + 8, "charging": 12.8 + 9.2, "queueing_charger": 7.8, "idle": 4.2}
        ),
    }


def test_parts_are_what_was_tallied(run):
    assert faults(run) == []


@pytest.mark.parametrize("allocation", ["in-order", {"name": "regret", "depth": 2, "commit": True}])
def test_a_task_waits_for_a_robot_in_the_list_or_in_its_queue(allocation):
    """One robot, busy with the one good until 68, is at the other at 138 and delivers it at 196."""
    model = ring(None, 250)
    model["tasks"]["goods"] = [0, 0]
    model["policies"] = {"allocation": allocation}
    run = dw.simulate(dw.load(model))
    later = run.history.delivered[-1].number
    assert parts(run.account("task"))[later] == pytest.approx(
        {"waiting_for_robot": 68, "empty": 70, "loading": 3, "loaded": 50, "unloading": 5}
    )


def test_a_task_that_is_given_back_waits_for_a_robot_again():
    """The battery calls the robot back at 35, before it is at B, where the edge of the good begins, at 40.

    It is home at 130, charges 130 until 143, comes to the good at 183, leaves it at 186 and is at the station at 206.
    """
    model = ring({"capacity": 200, "threshold": 165, "consumption": 1, "charge_rate": 10}, 250)
    model["layout"]["storage"] = [{"edge": ["B", "C"], "offset": 10}]
    model["fleet"]["first_exit_time"] = 10
    model["tasks"]["goods"] = [0]
    assert parts(dw.simulate(dw.load(model)).account("task")) == {
        0: pytest.approx({"empty": 35 + 40, "waiting_for_robot": 108, "loading": 3, "loaded": 20, "unloading": 5})
    }


def test_cycle_times_are_the_sums_of_their_parts():
    run = dw.simulate(dw.load("models/multibots.yaml"))
    assert run.account("task").sum(axis=1).mean() == pytest.approx(run.kpis["cycle_time_mean"])


def test_every_state_is_a_part():
    assert set(STATES) - {"queueing"} < set(OF_ROBOTS)
    assert set(OF_TASKS) - set(OF_ROBOTS) == {
        "waiting_for_batch",
        "waiting_for_robot",
        "waiting_for_pod",
        "waiting_for_lines",
        "waiting_for_worker",
        "worked_on",
    }
    assert len({part.colour for part in OF_TASKS.values()}) == len(OF_TASKS)


@pytest.mark.parametrize("level", ["tasks", "moves"])
def test_a_log_without_waits_is_refused(level):
    run = dw.simulate(dw.load({**two_robots(), "log": level}))
    with pytest.raises(dw.ReportError, match=rf"needs log: all \(now log: {level}\), run with --set log=all"):
        run.account()
    with pytest.raises(dw.ReportError, match="a table of waits needs log: all"):
        _ = run.waits
    with pytest.raises(dw.ReportError, match="a table of lost time needs log: all"):
        _ = run.lost_time


def test_another_table_is_refused(run):
    with pytest.raises(dw.ReportError, match="account by 'day': expected one of task, flow, station, robot,"):
        run.account("day")
