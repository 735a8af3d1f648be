"""Tables of a run: their columns have the same types in every run, whether there is anything in them or not."""

import pandas as pd
import pytest

import desim_warehouse as dw
from desim_warehouse.report.export import state_table

TUTORIAL = "models/tutorial.yaml"
TABLES = {
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
    assert len(table(alone)) == 0 or name in ("log", "states")


def test_edges_are_text_where_no_edge_is_logged():
    brief = dw.simulate(dw.load(TUTORIAL, {"fleet.size": 1, "tasks.goods": [1], "log": "tasks"})).log
    assert brief["edge"].isna().all()
    assert brief["edge"].dtype == pd.Series(["A>B"]).dtype
    assert (brief["other"] == -1).all()  # of robots and tasks, -1 is none
