"""Verdicts: what is wrong with a run or a design, in words."""

import json
import math

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.outcome.verdicts import RULES, judge
from desim_warehouse.questions.run import words as run_words
from tests.lasting import LASTING
from tests.theory.models import robots_that_serve

TUTORIAL = dw.load("models/tutorial.yaml", {"tasks.goods": {"poisson": 150}, "run": {"length": 36_000}})
BUSY = {"tasks.goods": {"poisson": 900}, "run": {"length": 3600}, **LASTING}


def codes(kpis, model=TUTORIAL):
    return [verdict.code for verdict in judge(kpis, model)]


# Backlog

QUEUES = [(1, 2, 1000), *(pytest.param(robots, 8, 2000, marks=pytest.mark.long) for robots in (1, 5))]
"""Robots, seeds and tasks."""


@pytest.mark.parametrize(("robots", "seeds", "tasks"), QUEUES)
def test_a_stable_queue_keeps_up_in_every_run(robots, seeds, tasks):
    """M/D/c at 80 % load."""
    model = dw.load(robots_that_serve(0.8, 1000.0, robots, tasks))
    assert [dw.simulate(model, seed).verdicts for seed in range(seeds)] == [[]] * seeds


@pytest.mark.parametrize(("robots", "seeds", "tasks"), QUEUES)
def test_an_overloaded_queue_cannot_keep_up_in_any_run(robots, seeds, tasks):
    """At 120 % load a sixth of what arrives is left: of 4.32 tasks an hour and robot 0.72."""
    model = dw.load(robots_that_serve(1.2, 1000.0, robots, tasks))
    for seed in range(seeds):
        run = dw.simulate(model, seed)
        assert [verdict.code for verdict in run.verdicts] == ["CANNOT_KEEP_UP"]
        assert run.verdicts[0].size == pytest.approx(0.72 * robots, rel=0.5)


def test_the_backlog_must_grow_by_three_standard_errors_of_the_arrivals():
    """400 tasks in 10 hours: 3 * 20 = 60 of them, 6 an hour."""
    kpis = {"T": 36_000, "tasks": 339, "backlog_growth_per_hour": 6.1}
    assert [verdict.text for verdict in judge(kpis, TUTORIAL)] == ["cannot keep up: open tasks grow by 6.1 an hour"]
    assert codes({**kpis, "tasks": 341, "backlog_growth_per_hour": 5.9}) == []


def test_tasks_that_robots_have_in_hand_are_no_backlog_that_grows():
    kpis = {"T": 3600, "tasks": 1, "backlog_growth_per_hour": 12}
    assert codes(kpis, TUTORIAL.replace({"run.length": 3600})) == ["CANNOT_KEEP_UP"]
    assert codes(kpis, TUTORIAL.replace({"run.length": 3600, "fleet.size": 12})) == []


def test_work_that_is_given_is_not_judged_by_its_backlog():
    assert codes({"T": 36_000, "backlog_growth_per_hour": 100}, TUTORIAL.replace({"tasks.goods": {"random": 9}})) == []


# Batteries


def test_batteries_that_fall_though_the_chargers_give_enough_are_no_verdict():
    """Robots that start full and have not had to charge yet."""
    kpis = {"T": 36_000, "energy_drift_per_hour": -0.05, "charger_utilisation": 0.1, "energy": 100}
    assert codes(kpis) == []
    assert codes({**kpis, "energy": 1e6}) == ["BATTERIES_FALL"]
    assert codes({**kpis, "charger_utilisation": 0.96}) == ["BATTERIES_FALL"]
    assert codes({**kpis, "charger_utilisation": 0.96, "energy_drift_per_hour": -0.009}) == []
    assert judge({**kpis, "energy": 1e6}, TUTORIAL)[0].text == "batteries fall by 5 % an hour: not sustainable"


def test_work_that_ends_may_use_up_the_batteries():
    kpis = {"T": 36_000, "energy_drift_per_hour": -0.05, "charger_utilisation": 1.0, "energy": 1e6}
    assert codes(kpis, TUTORIAL.replace({"tasks.goods": {"random": 9}})) == []


# Traffic


def test_a_fleet_that_waits_half_of_its_time_is_jammed():
    assert [verdict.text for verdict in judge({"share_waiting": 0.83}, TUTORIAL)] == [
        "jammed: robots wait in traffic 83 % of the time"
    ]
    assert codes({"share_waiting": 0.49}) == []


# Warm-up


def test_a_run_that_is_over_before_its_warm_up_says_so():
    """The warm-up is then part of what is counted, as the indicators say."""
    model = dw.load("models/tutorial.yaml", {"tasks.goods": {"random": 3}, "run.warm_up": 9000})
    run, whole = dw.simulate(model), dw.simulate(model.replace({"run.warm_up": 0}))
    assert [verdict.code for verdict in run.verdicts] == ["ENDS_IN_WARM_UP"]
    assert run.kpis == whole.kpis
    assert whole.verdicts == []
    assert "the indicators count the whole run" in " ".join(run_words.sentences(run))


def test_a_run_that_lasts_longer_than_its_warm_up_says_nothing():
    kpis = {"T": 100.0, "share_waiting": 0.0}
    assert codes(kpis, TUTORIAL.replace({"tasks.goods": {"random": 9}, "run.warm_up": 100})) == []
    assert codes(kpis, TUTORIAL.replace({"tasks.goods": {"random": 9}, "run.warm_up": 101})) == ["ENDS_IN_WARM_UP"]


def test_indicators_that_cannot_be_had_are_no_verdict():
    names = ("T", "tasks", "backlog_growth_per_hour", "energy_drift_per_hour", "charger_utilisation", "share_waiting")
    assert codes(dict.fromkeys(names, math.nan)) == []
    assert codes({}) == []


# Where they are said


def run_desim(*words):
    return CliRunner().invoke(desim, list(words), catch_exceptions=False).output


SETS = ["--set", "tasks.goods={poisson: 900}", "--set", "run={length: 3600}"]
SETS += [word for key, value in LASTING.items() for word in ("--set", f"{key}={value}")]


def test_a_run_says_its_verdicts_once():
    verdict = dw.simulate(dw.load("models/tutorial.yaml", BUSY)).verdicts[0]
    assert verdict.code == "CANNOT_KEEP_UP"
    assert run_desim("run", "models/tutorial.yaml", *SETS).count(verdict.text.removeprefix("cannot")) == 1
    printed = json.loads(run_desim("run", "models/tutorial.yaml", *SETS, "--json"))
    assert printed["verdicts"] == [{"code": verdict.code, "text": verdict.text}]
    assert json.loads(run_desim("run", "models/tutorial.yaml", "--json"))["verdicts"] == []


def test_the_report_of_a_run_begins_with_them():
    run = dw.simulate(dw.load("models/tutorial.yaml", BUSY))
    text = run.verdicts[0].text
    assert f"{text[0].upper()}{text[1:]}." in run_words.sentences(run)


def test_a_study_says_of_each_design_that_it_cannot_keep_up(tmp_path):
    words = ("--vary", "tasks.goods.poisson=60,900,1200", "--replications", "2", "--out", str(tmp_path), "--quiet")
    printed = run_desim("what-if", "models/tutorial.yaml", *SETS, *words)
    assert printed.count("cannot keep up") == 3  # in two rows, and where the note says why their times are blank
    study = dw.Results.load(tmp_path)
    codes = [[one.code for one in verdicts] for verdicts in study.verdicts.values()]
    assert codes == [[], ["CANNOT_KEEP_UP"], ["CANNOT_KEEP_UP"]]
    assert [one.standing for one in study.answer.options] == ["known", "overloaded", "overloaded"]


def test_procedures_say_what_is_wrong_with_the_designs_that_were_run():
    runs = ("--first", "2", "--cap", "2", "--quiet")
    asked = (
        "best",
        "models/tutorial.yaml",
        *SETS,
        "--vary",
        "fleet.size=1,2",
        "--indicator",
        "waiting",
        "--delta",
        "1",
    )
    lines = [line for line in run_desim(*asked, *runs).splitlines() if line.startswith("Cannot keep up")]
    assert [line.partition("(")[2] for line in lines] == ["1 robot; 2 of 2 options)."]
    asked = ("size", "models/tutorial.yaml", *SETS, "--range", "1..4", "--target", "throughput_per_hour >= 100")
    rows = [line for line in run_desim(*asked, *runs).splitlines() if line.rstrip(" 0123456789").endswith("keep up")]
    assert rows
    assert all("loads an hour delivered" in row or "open tasks grow by" in row for row in rows)


def test_every_code_has_a_mark_of_its_own():
    assert len({rule.mark for rule in RULES.values()}) == len(RULES)
