"""What one long run of a warehouse says, with intervals."""

import json
import math

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import ReportError, StudyError
from desim_warehouse.study.long_run import INDICATORS, long_run
from desim_warehouse.study.statistics import batch_means, quantile_in_run

from .conftest import ROOT
from .test_warm_up import LOOP, call

TUTORIAL = ROOT / "models" / "tutorial.yaml"
DAY = {
    "tasks.goods": {"poisson": 150, "due_within": 90},
    "run": {"length": 43_200, "warm_up": 600},
    "log": "tasks",
}


@pytest.fixture(scope="module")
def day():
    return dw.simulate(dw.load(TUTORIAL, DAY), 0)


def test_values_are_the_indicators_of_the_run(day):
    found = long_run(day)
    assert tuple(found) == INDICATORS
    for name, one in found.items():
        assert one.value == pytest.approx(day.kpis[name]), name
        assert one.interval[0] <= one.value <= one.interval[1], name


def test_tasks_are_observed_in_the_order_of_their_delivery(day):
    times = [task.cycle_time for task in day.history.delivered if task.delivered >= 600]
    found = long_run(day)
    assert found["cycle_time_mean"] == batch_means(times, within=(0.0, math.inf))
    assert found["cycle_time_p95"] == quantile_in_run(times, 0.95)


def test_a_flow_has_its_own_tasks():
    model = {**LOOP, "tasks": {"load_time": 0, "unload_time": 0}, "run": {"length": 40_000}}
    model["tasks"]["flows"] = {
        "fast": {"from": "storage", "to": ["A"], "arrivals": {"poisson": 20}},
        "slow": {"from": "storage", "to": ["A"], "arrivals": {"poisson": 40}},
    }
    run = dw.simulate(dw.load(model), 0)
    found = long_run(run, ["cycle_time_mean:fast", "throughput_per_hour:slow"])
    assert [one.value for one in found.values()] == pytest.approx([run.kpis[name] for name in found])
    assert found["cycle_time_mean:fast"].observations == run.kpis["tasks:fast"]


@pytest.mark.parametrize(
    ("changes", "names", "message"),
    [
        ({}, ["waiting"], "'waiting': not one that batches of a run tell, expected one of throughput_per_hour, cycle"),
        ({}, ["no_such"], "there is none"),
        ({}, ["on_time"], "'on_time': not one that batches"),
        ({"run.length": 2000}, None, "observations, expected at least 100; run longer"),
        ({"tasks.goods": [0, 0], "run.length": None}, None, "its work ends"),
    ],
)
def test_what_a_run_cannot_tell_is_refused(changes, names, message):
    run = dw.simulate(dw.load(LOOP, {"run.length": 6000, **changes}))
    with pytest.raises(StudyError, match=message):
        long_run(run, names)


def test_a_saved_run_says_the_same_as_its_model(tmp_path):
    settings = [f"--set={key}={json.dumps(value)}" for key, value in DAY.items()]
    assert call("run", TUTORIAL, *settings, "--out", tmp_path / "run").exit_code == 0
    of_model = call("long-run", TUTORIAL, *settings, "--json")
    of_run = call("long-run", tmp_path / "run", "--json")
    assert json.loads(of_model.stdout) == json.loads(of_run.stdout)
    told = json.loads(of_run.stdout)["cycle_time_mean"]
    assert told["low"] < told["value"] < told["high"]
    with pytest.raises(ReportError, match="a run that is over: --set is for models"):
        call("long-run", tmp_path / "run", "--set", "fleet.size=2")


def test_a_run_that_is_too_short_says_so():
    short = [f"--set={key}={json.dumps(value)}" for key, value in {**DAY, "run.length": 14_400}.items()]
    said = call("long-run", TUTORIAL, *short, "--indicator", "cycle_time_mean", "--indicator", "cycle_time_p95").stdout
    assert "batches depend on each other" in said
    assert "?" in said
