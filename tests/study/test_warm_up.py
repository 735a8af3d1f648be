"""How long a warehouse takes to settle: one model, and each design of a study by itself."""

import json

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ModelError, StudyError
from desim_warehouse.study.warm_up import settle

from .conftest import ROOT

ROUND = 40.0
LOOP = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [10, 10], "E": [0, 10]},
        "edges": [["A", "B"], ["B", "C"], ["C", "E"], ["E", "A"]],
        "storage": [{"edge": ["B", "C"], "offset": 5}],
        "bays": {"home": {"at": ["A"]}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.2, "speed": 1}},
    "tasks": {"goods": {"saturated": 19}, "unload_at": ["A"], "load_time": 0, "unload_time": 0},
    "run": {"length": 4000},
    "log": "tasks",
}
"""One robot on a round of 40 m at 1 m/s, 19 tasks before it at all times and one in hand: one done every 40 s."""


def loop(**changes):
    return dw.load(LOOP, {key.replace("__", "."): value for key, value in changes.items()})


def test_a_cycle_time_settles_when_the_first_twenty_tasks_are_through():
    """The n-th task of the first 20 takes n rounds, every later one 20 rounds: settled after 800 s."""
    warm_up = settle(loop(), replications=1, observations=100, observed="cycle_time")
    assert warm_up.width == ROUND
    assert warm_up.series[1:4] == pytest.approx([40, 80, 120])  # nothing is delivered before 40 s
    assert warm_up.series[25:] == pytest.approx([800] * 75)
    assert warm_up.time == 800


def test_throughput_has_settled_long_before():
    """The first task is delivered after 40 s as all others: an hour has 90 from the start."""
    warm_up = settle(loop(), replications=1, observations=100)
    assert warm_up.series[1:] == pytest.approx([90] * 99)
    assert warm_up.time in {0, 200}  # the first interval has no delivery; cuts are by five intervals


def test_each_design_of_a_study_has_its_own_warm_up():
    """Twice as many tasks at a time take twice as long to get through: 800 s and 1,600 s."""
    study = dw.Study(loop(), {"tasks.goods": [{"saturated": 19}, {"saturated": 39}]}, warm_up="auto")
    results = study.run().results
    assert study.plan.warm_up == (800, 1600)
    assert [model.run.warm_up for model in results.models.values()] == [800, 1600]
    assert list(results.table["cycle_time_mean"]) == pytest.approx([800, 1600])
    assert list(results.table["tasks"]) == [80, 60]  # one every 40 s of what is left
    assert results.unsettled == ()


def test_a_design_that_does_not_settle_is_counted_from_the_middle_and_named():
    """200 tasks at a time: none of the 100 that are done by the end was released after the start."""
    study = dw.Study(loop(), {"tasks.goods": [{"saturated": 19}, {"saturated": 200}]}, warm_up="auto").run()
    assert study.plan.warm_up == (800, 2000)
    assert study.results.unsettled == ("tasks.goods=saturated 200",)


def test_a_study_folder_keeps_the_warm_ups(tmp_path, monkeypatch):
    levels = {"tasks.goods": [{"saturated": 19}, {"saturated": 39}]}
    first = dw.Study(loop(), levels, warm_up="auto").run(out=tmp_path)
    assert json.loads((tmp_path / "study.json").read_text())["warm_up"] == [800, 1600]
    loaded = dw.Results.load(tmp_path)
    assert loaded.table["cycle_time_mean"].tolist() == first.table["cycle_time_mean"].tolist()

    def no_pilots(*_):
        raise AssertionError("pilot runs are there already")

    monkeypatch.setattr("desim_warehouse.study.study.settle_designs", no_pilots)
    again = dw.Study(loop(), levels, warm_up="auto", replications=2).run(out=tmp_path)
    assert again.plan.warm_up == (800, 1600)
    with pytest.raises(AssertionError, match="pilot runs"):  # of other designs they are not
        dw.Study(loop(fleet__size=2), levels, warm_up="auto").run(out=tmp_path)


@pytest.mark.long  # pilot runs are runs of a study, which `test_study` has with two workers every day
def test_the_number_of_workers_does_not_matter():
    levels = {"fleet.size": [1, 2]}
    model = loop(tasks__goods={"poisson": 60})
    one, two = (dw.Study(model, levels, warm_up="auto", replications=2).run(workers=workers) for workers in (1, 2))
    assert one.plan.warm_up == two.plan.warm_up
    told = ["fleet.size", "cycle_time_mean", "tasks"]
    assert one.table[told].equals(two.table[told])


def test_the_best_design_is_found_with_each_designs_own_warm_up():
    from desim_warehouse.questions.best import best

    study = dw.Study(loop(), {"tasks.goods": [{"saturated": 39}, {"saturated": 19}]}, warm_up="auto")
    choice = best(study, "cycle_time_mean", 10, search=dw.Search(first=3, cap=5))
    assert str(choice.point) == "tasks.goods=saturated 19"
    assert study.plan.warm_up == (1600, 800)


@pytest.mark.parametrize(
    ("changes", "more", "message"),
    [
        ({}, {"warm_up": 600}, r"warm_up: should be auto \(got 600\), or a time for all designs as set:"),
        ({}, {"warm_up": "never"}, r"warm_up: should be auto \(got 'never'\)"),
        ({}, {"warm_up": "auto", "factors": {"run.warm_up": [10, 20]}}, "run.warm_up is among the factors"),
        ({}, {"warm_up": "auto", "changes": {"run.warm_up": 10}}, "run.warm_up is among the set"),
        ({"tasks.goods": [0, 0], "run.length": None}, {"warm_up": "auto"}, "its work ends, so it has no steady state"),
    ],
)
def test_what_makes_no_sense_is_refused(changes, more, message):
    with pytest.raises(ModelError, match=message):
        dw.Study(dw.load(LOOP, changes), more.pop("factors", None), **more)


def test_a_model_whose_work_ends_has_no_warm_up():
    with pytest.raises(StudyError, match="its work ends"):
        settle(dw.load(LOOP, {"tasks.goods": [0, 0], "run.length": None}))


def test_pilot_runs_that_fail_are_said(tmp_path):
    """A robot that runs flat in every run: it is counted as its model says, and its runs are rows with the error."""
    flat = {"capacity": 30, "threshold": 0, "consumption": 1, "charge_rate": 1, "reserve": 0}
    model = loop(battery=flat, run__warm_up=100, accept=["BATTERY_TOO_SMALL"])
    study = dw.Study(model, warm_up="auto")
    with pytest.raises(dw.StudyError, match="no run finished: BatteryError"):
        study.run()
    assert study.plan.warm_up == (100,)
    assert any("no pilot run was finished" in note for note in study.notes)
    assert study.table["error"].notna().all()


def call(*arguments):
    return CliRunner().invoke(desim, [str(argument) for argument in arguments], catch_exceptions=False)


def test_what_if_shows_from_where_designs_are_counted(tmp_path):
    file = tmp_path / "loop.yaml"
    file.write_text(json.dumps(LOOP))
    vary = ["--vary", "tasks.goods={saturated: 19},{saturated: 200}", "--indicator", "cycle_time_mean", "--quiet"]
    output = call("what-if", file, *vary, "--warm-up", "auto").stdout
    assert "Counting began at " in output
    assert "goods: saturated 200: not settled by the middle of its runs" in output


def test_warm_up_draws_both_plots(tmp_path):
    file = tmp_path / "loop.yaml"
    file.write_text(json.dumps(LOOP))
    done = call("warm-up", file, "--observe", "cycle_time", "--replications", 2, "--window", 5, "--out", tmp_path)
    assert "run.warm_up: 800" in done.stdout
    assert {path.name for path in tmp_path.iterdir()} >= {"warm-up.png", "warm-up.svg", "welch.png", "welch.svg"}


def test_a_study_file_can_ask_for_it(tmp_path):
    file = tmp_path / "study.yaml"
    file.write_text(
        f"model: {ROOT / 'models' / 'tutorial.yaml'}\nwarm_up: auto\n"
        "set: {tasks.goods: {poisson: 100}, run.length: 3600}\nfactors: {fleet.size: [3, 4]}\n"
    )
    assert "Counting began at " in call("study", file, "--quiet").stdout


def test_what_opens_and_closes_by_the_clock_is_not_told_to_run_longer_alone(tmp_path):
    """Robots work in the second half of a run: it settles as little in a longer one."""
    over = {"calendars": {"late": {"every": 4000, "lasts": 1500, "first": 2500}}, "fleet.hours": "late"}
    (tmp_path / "loop.yaml").write_text(json.dumps(loop(**over).content()), encoding="utf-8")
    output = call("warm-up", tmp_path / "loop.yaml", "--replications", 1).output
    assert "not settled" in output
    assert "what changes by calendars never settles: let run.length and run.warm_up be whole periods" in output
