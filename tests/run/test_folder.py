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
    for table in ("log", "robots", "edges", "nodes", *(["waits"] if one.record.level == "all" else [])):
        pd.testing.assert_frame_equal(getattr(other, table), getattr(one, table))


@pytest.mark.parametrize("level", ["all", "moves", "tasks"])
def test_a_run_with_odd_names_comes_back_as_it_was(tmp_path, level):
    run = dw.simulate(dw.load(ODD, {"log": level}), seed=11)
    assert run.kpis["tasks"] == 4
    same(run, dw.load_run(run.save(tmp_path / "run")))


@pytest.mark.parametrize("features", ["", "tours", "pods", EVERYTHING])
@pytest.mark.parametrize("count", [1, pytest.param(5, marks=pytest.mark.long)])
def test_a_run_of_any_warehouse_comes_back(tmp_path, features, count):
    for number in range(count):
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


@pytest.mark.parametrize(
    "damage", ["missing", "no run.json", "cut short", "another file", "a list", "edges of one label"]
)
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
    elif damage == "a list":
        (folder / "run.json").write_text("[]")
    else:  # version 0.3 simulated such layouts: here A to B>B, and A>B to B
        text = (folder / "run.json").read_text()
        (folder / "run.json").write_text(text.replace(json.dumps("ü+\U0001f4e6"), '"B>B"'))
    with pytest.raises(dw.ReportError, match="no run can be read there") as refused:
        dw.load_run(folder)
    assert str(folder) in str(refused.value)


FILES = ("run.json", "log.parquet", "kpis.json", "robots.csv")


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_somebody_else_is_not_overwritten(tmp_path, name):
    run = dw.simulate(dw.load(ODD), seed=11)
    (tmp_path / name).write_text("mine")
    (tmp_path / "notes.txt").write_text("mine, too")
    words = f"{name} is a file of somebody else; expected another folder"
    with pytest.raises(dw.ReportError, match=words):
        run.save(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([name, "notes.txt"])
    assert (tmp_path / name).read_text() == "mine"


def test_a_run_is_written_again_beside_files_that_it_does_not_touch(tmp_path):
    run = dw.simulate(dw.load(ODD), seed=11)
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "kpis.json").touch()  # nothing in it
    run.save(tmp_path)
    (tmp_path / "run.json").write_text((tmp_path / "run.json").read_text()[:-40])  # cut short, but ours
    same(run, dw.load_run(run.save(tmp_path)))
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_search_and_study_refuse_a_folder_of_somebody_else(tmp_path):
    for name in ("answer.json", "results.parquet", "study.json", "runs.jsonl", "notes.txt"):
        (tmp_path / name).write_text("mine")
    words = (
        "runs.jsonl, results.parquet, study.json and answer.json are files of somebody else; expected another folder"
    )
    with pytest.raises(dw.StudyError, match=words):
        dw.Search(out=tmp_path)
    assert {path.read_text() for path in tmp_path.iterdir()} == {"mine"}
    (tmp_path / "runs.jsonl").write_text('damaged line\n0123abcd {"model": "x"}\n')  # a journal of ours makes it ours
    dw.Search(out=tmp_path)


def changed_table(folder, change):
    """Another log.parquet, in a folder that does not say what was written, as 0.3.0 left it."""
    table = pd.read_parquet(folder / "log.parquet")
    change(table).to_parquet(folder / "log.parquet", index=False)
    content = json.loads((folder / "run.json").read_text())
    assert list(content.pop("sha256")) == ["log.parquet"]
    (folder / "run.json").write_text(json.dumps(content))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table[::-1], "not in order of time"),
        (lambda table: table.assign(robot=table["robot"] + 3), "no such kind of row, robot, task or node"),
        (lambda table: table.assign(robot=0.5), "no such kind of row, robot, task or node"),
        (lambda table: table.assign(kind="gone"), "no such kind of row, robot, task or node"),
        (lambda table: table.assign(node="gone"), "no such kind of row, robot, task or node"),
        (lambda table: table.assign(edge="A>gone"), "'A>gone' is missing"),
        (lambda table: table.drop(columns="time"), "log.parquet has no column time"),
        (lambda table: table.drop(columns="kind"), "log.parquet has no column kind"),
        (lambda table: table.drop(columns=["node", "until"]), "log.parquet has no column node and until"),
        (lambda table: table.assign(time=table["time"] * 2), "not in order of time"),
        (lambda table: table.assign(time=float("nan")), "not supported between"),
        (lambda table: table.assign(task="one"), "not supported between"),
    ],
)
def test_rows_that_no_run_of_the_model_has_are_refused_where_they_are_read(tmp_path, change, message):
    folder = dw.simulate(dw.load(ODD), seed=11).save(tmp_path / "run")
    changed_table(folder, change)
    with pytest.raises(dw.ReportError, match=message):
        dw.load_run(folder)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table.assign(value=None), "drive without edge, value and until"),
        (lambda table: table.assign(until=None), "drive without edge, value and until"),
        (lambda table: table.assign(edge=None), "(enter without edge|drive without edge, value and until)"),
        (lambda table: table.assign(node=None), "(parked|docked) without node"),
        (lambda table: table[table["kind"] != "released"], "no run can be read there"),
    ],
)
def test_rows_that_lack_what_others_build_on_are_refused_where_they_are_read(tmp_path, change, message):
    """They ended `replay`, `export` and `calibrate` in a traceback."""
    folder = dw.simulate(dw.load(ODD, {"log": "all"}), seed=11).save(tmp_path / "run")
    changed_table(folder, change)
    with pytest.raises(dw.ReportError, match=message):
        dw.load_run(folder)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("edges", []),
        ("edges", 1e300),
        ("nodes", {}),
        ("nodes", -1),
        ("stations", "x"),
        ("energy", None),
        ("energy", [1.0] * 99),
    ],
)
def test_tallies_that_are_not_those_of_a_run_are_refused(tmp_path, key, value):
    folder = dw.simulate(dw.load(ODD), seed=11).save(tmp_path / "run")
    content = json.loads((folder / "run.json").read_text())
    content["log"][key] = value
    (folder / "run.json").write_text(json.dumps(content))
    with pytest.raises(dw.ReportError, match="no run can be read there"):
        dw.load_run(folder)


def test_a_log_that_is_not_the_one_that_was_written_is_refused(tmp_path):
    folder = dw.simulate(dw.load(ODD), seed=11).save(tmp_path / "run")
    pd.read_parquet(folder / "log.parquet")[:-1].to_parquet(folder / "log.parquet", index=False)
    with pytest.raises(dw.ReportError, match=r"log\.parquet is not as it was written"):
        dw.load_run(folder)


@pytest.mark.parametrize(
    "change",
    [{"robots": []}, {"level": "some"}, {"end": -1.0}, {"end": None}, {"begin": "x"}, {"robots": None}, {"rows": 1}],
)
def test_what_stands_beside_the_rows_is_checked_too(tmp_path, change):
    folder = dw.simulate(dw.load(ODD), seed=11).save(tmp_path / "run")
    content = json.loads((folder / "run.json").read_text())
    content["log"] |= change
    (folder / "run.json").write_text(json.dumps(content))
    if "rows" in change:  # not looked at
        dw.load_run(folder)
        return
    with pytest.raises(dw.ReportError, match="no run can be read there"):
        dw.load_run(folder)
