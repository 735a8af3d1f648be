"""A run saved and read back is the same run."""

import json

import pandas as pd
import pytest

import desim_warehouse as dw
from tests.laws.features import EVERYTHING, warehouse

ODD = {
    "name": "odd names: ä > β, 'quoted' + \"double\"",
    "layout": {
        "nodes": {"A>B": [0, 0], "B": [30, 0], "Lager, 1": [30, 30], "ü+\U0001f4e6": [0, 30], "A": [15, 60]},
        "edges": [
            ["A>B", "B"],
            ["B", "Lager, 1"],
            ["Lager, 1", "ü+\U0001f4e6"],
            ["ü+\U0001f4e6", "A>B"],
            ["Lager, 1", "A"],
            ["A", "ü+\U0001f4e6"],
        ],
        "storage": [{"edge": ["A>B", "B"], "offset": 10}, {"edge": ["Lager, 1", "A"], "offset": 5}],
        "bays": {"home > away": {"at": ["A>B"], "places": 4}},
        "stations": {"pack + ship": {"at": ["ü+\U0001f4e6"], "places": 2}},
    },
    "fleet": {"size": 3, "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {
        "goods": [0, 1, {"good": 0, "release": 40, "due": 200}, 1],
        "unload_at": ["ü+\U0001f4e6"],
        "load_time": 3,
        "unload_time": 5,
    },
    "battery": {"capacity": 1000, "threshold": 100, "consumption": 1, "charge_rate": 10},
}


def same(one, other):
    assert other.model == one.model
    assert other.seed == one.seed
    assert other.record.rows == one.record.rows
    assert other.record == one.record
    assert repr(other.kpis) == repr(one.kpis)
    for table in ("log", "robots", "edges", "nodes", "waits"):
        pd.testing.assert_frame_equal(getattr(other, table), getattr(one, table))


@pytest.mark.parametrize("level", ["all", "moves", "tasks"])
def test_a_run_with_odd_names_comes_back_as_it_was(tmp_path, level):
    run = dw.simulate(dw.load(ODD, {"log": level}), seed=11)
    assert run.kpis["tasks"] == 4
    same(run, dw.load_run(run.save(tmp_path / "run")))


def test_names_that_look_like_another_edge_are_told_apart(tmp_path):
    """Edges from "A" to "B>C" and from "A>B" to "C" are both written A>B>C."""
    nodes = {"A": [0, 0], "B>C": [20, 0], "A>B": [20, 20], "C": [0, 20]}
    model = {
        "layout": {
            "nodes": nodes,
            "edges": [["A", "B>C"], ["B>C", "A>B"], ["A>B", "C"], ["C", "A"]],
            "storage": [{"edge": ["A", "B>C"], "offset": 10}],
            "bays": {"home": {"at": ["A"]}},
        },
        "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}},
        "tasks": {"goods": [0], "unload_at": ["A>B"], "load_time": 0, "unload_time": 0},
    }
    run = dw.simulate(dw.load(model))
    same(run, dw.load_run(run.save(tmp_path)))


@pytest.mark.parametrize("features", ["", "tours", "pods", EVERYTHING])
def test_a_run_of_any_warehouse_comes_back(tmp_path, features):
    for number in range(3):
        run = dw.simulate(dw.load(warehouse(number, features)), number)
        again = dw.load_run(run.save(tmp_path / f"{number}"))
        same(run, again)
        for by in ("task", "flow", "station", "robot", "edge", "node", "hour"):
            assert again.account(by).equals(run.account(by)), (number, by)


def test_a_folder_holds_what_people_and_programs_want(tmp_path):
    run = dw.simulate(dw.load(ODD), seed=11)
    run.save(tmp_path)
    assert {file.name for file in tmp_path.iterdir()} == {
        "run.json",
        "kpis.json",
        "log.parquet",
        "robots.csv",
        "edges.csv",
        "nodes.csv",
    }
    kept = json.loads((tmp_path / "kpis.json").read_text())
    assert kept["T"] == run.kpis["T"]
    assert list(pd.read_csv(tmp_path / "robots.csv", index_col="robot").columns) == list(run.robots.columns)
    assert len(pd.read_parquet(tmp_path / "log.parquet")) == len(run.log)
    assert json.loads((tmp_path / "run.json").read_text())["seed"] == 11


@pytest.mark.parametrize("damage", ["missing", "no run.json", "cut short", "another file", "a list"])
def test_what_is_no_run_is_refused_with_a_clear_message(tmp_path, damage):
    run = dw.simulate(dw.load(ODD), seed=11)
    folder = run.save(tmp_path / "run")
    if damage == "missing":
        folder = tmp_path / "nowhere"
    elif damage == "no run.json":
        (folder / "run.json").unlink()
    elif damage == "cut short":
        text = (folder / "run.json").read_text()
        (folder / "run.json").write_text(text[: len(text) // 2])
    elif damage == "another file":
        (folder / "log.parquet").write_text("time,kind\n")
    else:
        (folder / "run.json").write_text("[]")
    with pytest.raises(dw.ReportError, match="no run can be read there") as refused:
        dw.load_run(folder)
    assert str(folder) in str(refused.value)
