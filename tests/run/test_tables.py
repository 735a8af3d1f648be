"""Tables of a run: their columns have the same types in every run, whether there is anything in them or not."""

import pandas as pd
import pytest

import desim_warehouse as dw
from desim_warehouse.report.export import state_table
from tests.world.test_battery_instants import play

TUTORIAL = "models/tutorial.yaml"
TABLES = {
    "tasks": lambda run: run.tasks,
    "log": lambda run: run.log,
    "waits": lambda run: run.waits,
    "lost_time": lambda run: run.lost_time,
    "rotations": lambda run: run.rotations[["time"]],
    "states": state_table,
}


@pytest.fixture(scope="module")
def busy():
    """Three robots that wait for one another."""
    return dw.simulate(TUTORIAL)


@pytest.fixture(scope="module")
def alone():
    """A robot that waits for none, without a battery."""
    return dw.simulate(dw.load(TUTORIAL, {"fleet.size": 1, "tasks.goods": [1], "battery": dw.UNSET}))


@pytest.mark.parametrize("name", TABLES)
def test_a_column_has_its_type_if_no_row_has_a_value_there(busy, alone, name):
    """A script that joins tables of many runs joins text with text, numbers with numbers."""
    table = TABLES[name]
    assert (table(busy).dtypes == table(alone).dtypes).all()
    assert len(table(alone)) == 0 or name in ("log", "states", "tasks")


def test_edges_are_text_where_no_edge_is_logged():
    brief = dw.simulate(dw.load(TUTORIAL, {"fleet.size": 1, "tasks.goods": [1], "log": "tasks"})).log
    assert brief["edge"].isna().all()
    assert brief["edge"].dtype == pd.Series(["A>B"]).dtype
    assert (brief["other"] == -1).all()  # of robots and tasks, -1 is none


def test_a_task_has_a_row_with_its_times_and_its_robot():
    """The robot loads at 45 and has unloaded at 65; it parks at A at 105. The second task comes a second too late."""
    goods = [{"good": 0, "due": 300}, {"good": 1, "release": 140}]
    tasks = play(battery__threshold=20, tasks__goods=goods, run={"length": 141}).tasks
    first = ["released", "due", "assigned", "loaded", "delivered", "done", "robot", "station"]
    assert tasks.loc[0, first].to_list() == [0, 300, 0, 45, 65, 65, 0, "C"]
    assert tasks.loc[1, ["released", "assigned", "robot"]].to_list() == [140, 140, 0]
    assert tasks.loc[1, ["due", "loaded", "delivered", "done", "flow", "order", "station"]].isna().all()


def test_a_task_that_was_given_back_has_the_times_of_its_last_assignment():
    """At 25 the robot turns back; it is out again with a full battery, and loads 90 later than without a threshold."""
    run = play(battery__threshold=175)
    assigned = [row.time for row in run.history.rows("assigned")]
    assert len(assigned) == 2
    assert run.tasks.loc[0, ["assigned", "loaded", "delivered"]].to_list() == [max(assigned), 45 + 90, 65 + 90]


def test_a_task_that_no_robot_took_has_none():
    """Both robots are at work when the third task comes."""
    goods = [0, 0, {"good": 1, "release": 1}]
    tasks = play(fleet__size=2, tasks__goods=goods, run={"length": 20}).tasks
    assert tasks["robot"].to_list() == [0, 1, -1]
    assert tasks["assigned"].isna().to_list() == [False, False, True]
