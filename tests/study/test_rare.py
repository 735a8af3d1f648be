"""What a study of few runs hardly sees is named, by the model: breakdowns, outages and closures."""

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.study import Study
from desim_warehouse.study.rare import expected, warnings
from tests.docs import pages

FAILING = {
    "fleet.robot.breakdowns": {"every": {"exponential": 36_000}, "repair": 600},
    "tasks.goods": {"poisson": 60},
    "run.length": 1200,
}


def test_breakdowns_and_outages_are_counted_by_robots_and_chargers():
    """Three robots for 1,200 of 36,000 s: 0.1; chargers fail every 5,000 s and are repaired in 1,000 s: 3 x 0.2."""
    outages = {
        "layout.bays.charging": {
            "along": "south",
            "places": 1,
            "chargers": 1,
            "outages": {"every": 5000, "repair": 1000},
        }
    }
    model = dw.load("models/tutorial.yaml", FAILING | outages)
    found = expected(model, 1200)
    assert found == {"breakdowns": pytest.approx(0.1), "outages of chargers": pytest.approx(0.6)}


def test_what_is_rare_is_named_beside_few_runs_and_not_beside_many():
    model = dw.load("models/tutorial.yaml", FAILING)
    (line,) = warnings(model, 10, 1200)
    assert line.startswith("breakdowns are rare (0.1 to be expected in a run, 1 in 10 runs): intervals of few runs")
    assert warnings(model, 100, 1200) == []
    often = model.replace({"fleet.robot.breakdowns.every": {"exponential": 3600}})  # one a run
    assert warnings(often, 10, 1200) == []


def test_a_closure_that_never_comes_is_named():
    closed = {"calendars.night": {"between": [[5000, 6000]]}}
    closed["traffic.closures.aisle"] = {"members": [["A", "B"]], "hours": "night"}
    model = dw.load("models/tutorial.yaml", {"run.length": 1200, "tasks.goods": {"poisson": 60}, **closed})
    assert warnings(model, 10, 1200) == ["closures of aisle never fall into a run: nothing here says what they cost"]


def test_what_if_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    study = Study(dw.load(pages.ROOT / "models/tutorial.yaml", FAILING), {"fleet.size": [2, 3]}, replications=3)
    study.run(out=tmp_path / "out")
    status, out, _ = pages.run_desim("desim study out --quiet")
    assert status == 0
    assert "breakdowns are rare (0.067 to be expected in a run, 0.2 in 3 runs)" in out
