"""What comes on few days only is known from the model: breakdowns, outages and closures."""

import math

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.study import Study
from desim_warehouse.study.rare import beyond, chances, days_needed, expected, shows, unknown
from desim_warehouse.study.statistics.limits import COMMON_DAYS, RARE_DAYS, DaysNeeded
from tests.docs import pages
from tests.world.test_lifts import building

FAILING = {
    "fleet.robot.breakdowns": {"every": {"exponential": 36_000}, "repair": 600},
    "tasks.goods": {"poisson": 60},
    "run.length": 1200,
}


def failing(every):
    """Three robots for 1,200 s, each of which breaks down once in so many seconds."""
    return dw.load("models/tutorial.yaml", {**FAILING, "fleet.robot.breakdowns.every": {"exponential": every}})


def test_breakdowns_and_outages_are_counted_by_robots_and_chargers():
    """Three robots for 1,200 of 36,000 s: 0.1; chargers fail every 5,000 s and are repaired in 1,000 s: 3 x 0.2.

    The chance of any is 1 - exp(-0.1) and 1 - exp(-0.6).
    """
    outages = {
        "layout.bays.charging": {
            "along": "south",
            "places": 1,
            "chargers": 1,
            "outages": {"every": 5000, "repair": 1000},
        }
    }
    model = dw.load("models/tutorial.yaml", FAILING | outages)
    assert expected(model, 1200) == {"breakdowns": pytest.approx(0.1), "outages of chargers": pytest.approx(0.6)}
    probabilities = {
        "breakdowns": pytest.approx(0.0952, abs=1e-4),
        "outages of chargers": pytest.approx(0.4512, abs=1e-4),
    }
    assert chances(model, 1200) == probabilities


def test_outages_of_all_lifts_are_counted_together():
    """Two lifts that fail every 5,000 s and are repaired in 1,000 s, for 1,200 s: 2 x 0.2."""
    outages = {"every": {"exponential": 5000}, "repair": 1000}
    model = dw.load(building(2, "fastest"), {f"layout.lifts.lift{number}.outages": outages for number in range(2)})
    assert expected(model, 1200) == {"outages of lifts": pytest.approx(0.4)}


def test_what_is_rare_is_named_beside_few_runs_and_not_beside_many():
    model = failing(36_000)
    assert unknown(model, 10, 1200) == [
        "breakdowns come on one day in 11: intervals of times from 10 runs do not cover such days"
    ]
    assert unknown(model, 1, 1200) == ["breakdowns come on one day in 11: one run does not cover such days"]
    assert unknown(model, 20, 1200) == []
    assert unknown(failing(3600), 10, 1200) == []  # one a run


@pytest.mark.parametrize(
    ("every", "days"),
    [
        (36_000, COMMON_DAYS),  # one day in 10.5, which 30 days show
        (60_000, RARE_DAYS),  # one in 17
        (3600, COMMON_DAYS),  # two days in three
    ],
)
def test_a_fleet_is_named_after_more_days_where_something_is_rarer_than_one_day_in_ten(every, days):
    assert days_needed(failing(every)) == days


def test_what_is_rarer_still_is_not_covered_and_the_days_that_would_are_said():
    """3 x 1,200 / 180,000 = 0.02: one day in 50.5, which 150 days show."""
    model = failing(180_000)
    assert days_needed(model) == RARE_DAYS
    assert beyond(model, RARE_DAYS.least) == {"breakdowns": 150}
    assert days_needed(model, first=150) == DaysNeeded(150, 300)
    assert beyond(model, 150) == {}


def test_what_the_user_says_comes_first():
    assert days_needed(failing(36_000), cap=12) == DaysNeeded(12, 12)
    assert days_needed(dw.load("models/tutorial.yaml"), first=5, cap=100) == DaysNeeded(33, 100)


def test_where_a_run_has_no_length_breakdowns_may_be_rare():
    model = dw.load("models/tutorial.yaml", {"fleet.robot.breakdowns": FAILING["fleet.robot.breakdowns"]})
    assert math.isnan(chances(model, None)["breakdowns"])
    assert days_needed(model) == RARE_DAYS
    assert beyond(model, 59) == {"breakdowns": 0}


def test_runs_that_agree_show_what_is_measured_unless_something_rare_may_change_it():
    plain = dw.load("models/tutorial.yaml")
    assert [shows(plain, name) for name in ("cycle_time_mean", "on_time", "S")] == [True, False, False]
    assert not shows(failing(36_000), "cycle_time_mean")


def test_a_closure_that_never_comes_is_named():
    closed = {"calendars.night": {"between": [[5000, 6000]]}}
    closed["traffic.closures.aisle"] = {"members": [["A", "B"]], "hours": "night"}
    model = dw.load("models/tutorial.yaml", {"run.length": 1200, "tasks.goods": {"poisson": 60}, **closed})
    assert unknown(model, 10, 1200) == ["closures of aisle never fall into a run: their cost does not show here"]


def test_a_study_reports_that_its_runs_do_not_cover_rare_days(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    study = Study(dw.load(pages.ROOT / "models/tutorial.yaml", FAILING), {"fleet.size": [2, 3]}, replications=3)
    study.run(out=tmp_path / "out")
    status, out, _ = pages.run_desim("desim study out --quiet")
    assert status == 0
    assert "Breakdowns come on one day in 16: intervals of times from 3 runs do not cover such days." in out
