"""Does a day refute a model? Right models hardly ever, wrong ones soon."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ReportError
from desim_warehouse.fleet_log import read_logs
from desim_warehouse.fleet_log.measures import MEASURES, measured, parts_of
from desim_warehouse.fleet_log.ranks import ranked
from desim_warehouse.fleet_log.runs import from_run
from desim_warehouse.fleet_log.validate import validate


def test_a_right_model_is_refuted_at_the_level_however_skewed_its_figures():
    rng = np.random.default_rng(0)
    refuted = 0
    for _ in range(600):
        days = rng.lognormal(0, 1, (2, 40, 6))
        ranks = ranked(days[:, 0], days[:, 1:])
        refuted += ranks.p_value <= 0.05
        assert ranks.bound > 1.9
    assert 0.025 <= refuted / 600 <= 0.07


def test_an_error_in_all_days_is_seen_though_no_day_shows_it():
    rng = np.random.default_rng(1)
    days = rng.normal(0, 1, (16, 60, 8))
    days[:, 0, 3] += 1.5
    ranks = ranked(days[:, 0], days[:, 1:])
    assert ranks.p_value <= 0.05
    assert ranks.off[3] > ranks.bound
    assert np.abs(np.delete(ranks.off, 3)).max() < ranks.bound + 1


@pytest.fixture(scope="module")
def days(a_plant):
    """The real day of a plant, and its true model with a shorter day."""
    model = dw.load(a_plant.sheet, a_plant.truth | {"run.length": 400})
    return model, from_run(dw.simulate(model, 77))


def test_the_right_model_is_not_refuted(days):
    model, day = days
    right = validate(model, [day], runs=39)
    assert not right.refuted
    assert right.unlike == ()
    assert right.lines()[0].startswith("not refuted (1 day, 39 simulated")
    for error in (0, -0.1, math.nan, "10 %"):
        with pytest.raises(ReportError, match="expected a share above 0"):
            right.days_for("travel", error)
    assert "to notice a 10 % error, with a chance of 80 %, takes " in right.lines()[-1]


def test_measures_of_a_run_are_its_indicators(days):
    model, day = days
    figures = measured(model, day, parts_of(model, day)).figures
    assert set(figures) == set(MEASURES)
    run = dw.simulate(model, 77)
    for ours, theirs in (("share_loading", "share_loading"), ("share_charging", "share_charging")):
        assert figures[ours] == pytest.approx(run.kpis[theirs], abs=0.005)
    assert sum(figures[name] for name in MEASURES if name.startswith("share_")) == pytest.approx(1)


def test_too_few_runs_and_orders_are_refused(a_plant):
    with pytest.raises(ReportError, match="runs 20: expected from 39, as fewer can refute nothing, to 100,000"):
        validate(a_plant.sheet, [a_plant.log], runs=20)
    with pytest.raises(ReportError, match="2 files of orders for 1 logs"):
        validate(a_plant.sheet, [a_plant.log], orders=["a", "b"])


def test_one_log_and_one_file_of_orders_need_no_list(a_plant, tmp_path):
    """Two trips of half a minute: the log is read whole, not letter by letter."""
    trips = tmp_path / "trips.csv"
    trips.write_text("robot,pick,drop,start,end\nR1,A,G,0,30\nR1,A,G,60,90\n")
    for logs in (str(trips), trips, dw.read_log(trips)):
        [log] = read_logs(logs)
        assert (log.name, log.length) == (str(trips), 90)
    with pytest.raises(ReportError, match="1 files of orders for 2 logs"):
        validate(a_plant.sheet, [trips, trips], orders="orders.csv")


def told(sheet, log, *options):
    """What the command says of a sheet and a log."""
    result = CliRunner().invoke(desim, ["validate", str(sheet), "--against", str(log), "--runs", "39", *options])
    assert result.exit_code == 0, result.output
    return result.output


@pytest.mark.parametrize(
    "with_page",
    [False, pytest.param(True, marks=pytest.mark.long)],  # has four pictures; that of trips has one
    ids=["said", "with a page"],
)
def test_the_command_says_that_a_sheet_is_refuted(a_plant, tmp_path, with_page):
    lines = [line for line in a_plant.log.read_text(encoding="utf-8").splitlines() if re.search(r"T06:0[0-5]", line)]
    (tmp_path / "short.jsonl").write_text("\n".join(lines))  # six minutes
    page = tmp_path / "page.html"
    shown = ("--page", str(page)) if with_page else ()
    output = told(a_plant.sheet, tmp_path / "short.jsonl", "--set", "fleet.robot.speed=9", *shown)
    first, *then = output.splitlines()
    assert first.startswith("refuted by")
    assert "time driving with a load" in first
    assert any(line.startswith("look at time driving with a load: speed with a load") for line in then)
    assert "OUTSIDE" in output
    if with_page:
        assert then[-1].endswith("page.html: open it in a browser")
        assert "Look at time driving with a load: speed with a load" in page.read_text(encoding="utf-8")


def test_the_command_writes_a_page_of_trips(a_plant, tmp_path):
    trips = [f"R1,A,G,{60 * n},{60 * n + 20}" for n in range(5)]
    (tmp_path / "trips.csv").write_text("\n".join(["robot,pick,drop,start,end", *trips]))
    page = tmp_path / "page.html"
    output = told(a_plant.sheet, tmp_path / "trips.csv", "--page", str(page))
    first, *_, last = output.splitlines()
    assert last.endswith("page.html: open it in a browser")
    assert f"{first[0].upper()}{first[1:]}." in page.read_text(encoding="utf-8").replace("\u00a0", " ")


def test_a_fleet_of_another_size_is_said_before_any_time_is_blamed(days):
    """Of a log with fewer robots every share of time differs: the load time of the model is not to be looked at."""
    model, day = days
    robots = model.fleet.size
    validation = validate(model.replace({"fleet.size": robots + 1}), [day], runs=39)
    assert validation.unlike == (f"{day.name} has {robots} robots, the model {robots + 1} (fleet.size)",)
    wrong = (
        replace(validation, measures=replace(validation.measures, p_value=0.01))
        if not validation.refuted
        else validation
    )
    assert wrong.lines()[1] == f"first of all: {validation.unlike[0]}"
    assert not any("look at" in line for line in wrong.lines())
