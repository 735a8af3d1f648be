"""The answer of a study: question, sentences and rows; its page needs nothing from outside."""

import dataclasses
import math
import re
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.answer.text import printed
from desim_warehouse.cli import desim
from desim_warehouse.outcome.indicators import is_count
from desim_warehouse.questions import compare_words
from desim_warehouse.questions.study import Study
from desim_warehouse.report.example import example
from desim_warehouse.report.write import report
from desim_warehouse.study.statistics.intervals import estimate
from tests.lasting import LASTING
from tests.report.test_answer import is_everywhere
from tests.report.test_report import Page, needs_nothing_from_outside
from tests.world.test_flows import RING

pytestmark = pytest.mark.usefixtures("brief_probes")

STUDIES = sorted((Path(__file__).parents[2] / "studies").glob("*.yaml"))
DAILY = {"charging", "paper"}
EACH = [pytest.param(path, id=path.stem, marks=[] if path.stem in DAILY else [pytest.mark.long]) for path in STUDIES]


@pytest.fixture(scope="module")
def answer(study_folder):
    return dw.Results.load(study_folder).answer


@pytest.fixture(scope="module")
def page(study_folder):
    return needs_nothing_from_outside(report(study_folder).read_text(encoding="utf-8"))


def test_rows_are_those_of_the_table(answer, study_folder):
    table = pd.read_parquet(study_folder / "results.parquet")
    assert len(answer.options) == 6
    assert answer.measures == {
        "T": "task time", "S": "waits for another robot", "throughput_per_hour": "throughput",
        "waiting": "time waited in traffic",
    }  # fmt: skip
    for option in answer.options:
        runs = table[table["fleet.size"] == option.set["fleet.size"]]
        by = {rows["T"].mean(): rows for _, rows in runs.groupby("tasks.goods")}
        rows = by[min(by, key=lambda mean: abs(mean - option.number.mean))]
        how = {"deterministic": bool(rows["deterministic"].all()), "within": (0.0, math.inf)}
        for one in option.numbers:
            expected = estimate(rows[one.of].tolist(), **how, counts=is_count(one.of))
            assert (one.mean, one.low, one.high) == pytest.approx((expected.mean, *(expected.interval or (None, None))))


def test_hostile_names_are_shown_as_text(answer, page):
    assert page.text.count("<script>alert(1)</script> & “quotes” مستودع $x$") >= 1
    rows = page.tables["options"]
    assert any('<script>alert("1")</script>' in row[0] for row in rows)
    assert any("$\\frac{مستودع}$ 'x' & <b>" in row[0] for row in rows)
    assert is_everywhere(answer)


def test_versions_seed_and_digest_are_there(page, study_folder):
    method = dict(page.tables["method"])
    assert method["seed"] == "5"
    assert dw.Results.load(study_folder).base.digest() == method["model"]
    assert {"desim-warehouse", "python", "simpy"} <= method.keys()


def small(path):
    """A study of a few runs: at most two levels of each factor, two replications, no long runs."""
    plan = Study.read(path).plan
    baseline = plan.baseline or {}
    factors = []
    for factor in plan.factors:
        kept = [level for level in factor.levels if level.label == baseline.get(factor.key)]
        kept += [level for level in factor.levels if level not in kept][: 2 - len(kept)]
        factors.append(dataclasses.replace(factor, levels=tuple(kept)))
    base = plan.base
    if base.run.length is not None:
        short = min(base.run.length, 3600 / base.units.seconds)
        base = base.replace({"run.length": short, "run.warm_up": min(base.run.warm_up, short / 4)})
    return Study.of(dataclasses.replace(plan, base=base, factors=tuple(factors), replications=2))


@pytest.mark.parametrize("path", EACH)
def test_every_study_has_an_answer(path, tmp_path):
    study = small(path).run(out=tmp_path)
    assert is_everywhere(study.results.answer)
    source = report(tmp_path).read_text(encoding="utf-8")
    needs_nothing_from_outside(source)
    assert source.count("<figure") <= 4  # the answer, the median and the worst day, and the floor
    assert "<img" not in source


def test_the_cheapest_option_that_meets_the_target_is_the_answer_and_its_replay_is_beside_the_page(tmp_path):
    base = example().replace({**LASTING, "prices": {"hours": 4000, "robot": 9000, "charger": 800, "currency": "EUR"}})
    study = Study(base, {"fleet.size": [1, 3, 4]}, replications=8, target="on_time >= 70 %").run(out=tmp_path / "study")
    answer = study.results.answer
    assert answer.question == "Which of 1 to 4 robots give at least 70 % on time?"
    first = answer.answer[0]
    assert first.startswith("3 robots are the cheapest option shown to give at least 70 % on time: ")
    assert first.endswith(", 27,800 EUR a year.")
    assert answer.answer[2] == "8 days cover only days as rare as one in two: rely on it after 33."
    assert [(one.name, one.standing) for one in answer.options] == [
        ("1 robot", "not met"), ("3 robots", "met"), ("4 robots", "met"),
    ]  # fmt: skip
    assert answer.answer[1] == "Of 3 options, 2 meet the target and 1 misses it."
    assert answer.about.model["fleet"]["size"] == 3
    assert [one.what for one in answer.tiles] == [
        "done on time",
        "throughput",
        "cycle time, 95 % quantile",
        "cost a year",
    ]
    path = report(tmp_path / "study", tmp_path / "boss.html", replay=True)
    source = path.read_text(encoding="utf-8")
    assert 'href="boss-replay.html"' in source
    day = answer.about.day
    assert day.startswith("the median of 8 days, ")
    assert f"One run, {day}, simulated again with everything logged." in source
    tables = re.findall(r"<summary>([^<]*)</summary>(?:(?!</details>).)*</details>", source, re.DOTALL)
    of_one_run = source.count(f"Of one run, {day}; means over all runs differ.")
    assert of_one_run == len({"Where the time goes", "Stations and chargers", "What robots waited for"} & set(tables))
    assert "desimReplay" in (tmp_path / "boss-replay.html").read_text(encoding="utf-8")
    assert "Which factor matters" not in source  # there is one


def test_times_beside_a_target_have_its_unit():
    """A robot drives 45 s to the good, 15 s with it and 20 s home, and loads and unloads for 10 s: 90 s of 60."""
    model = dw.load(RING, {"tasks.goods": [0], "tasks.unload_at": ["pack"]})
    results = Study(model, {"fleet.size": [1]}, target="T <= 60 s").run(workers=1).results
    assert results.answer.options[0].text == "90 s"


def test_one_run_of_a_share_tells_nothing_of_a_target():
    results = Study(example().replace(LASTING), {"fleet.size": [1, 3]}, target="on_time >= 60 %").run().results
    assert [one.standing for one in results.answer.options] == ["open", "open"]
    assert is_everywhere(results.answer)


def test_an_answer_for_each_demand_names_a_fleet_for_it():
    factors = {"tasks.demand": [1, 2.2], "fleet.size": [1, 3, 4]}
    base = example().replace({**LASTING, "run.length": 1800, "run.warm_up": 300})
    results = Study(base, factors, replications=8, target="on_time >= 75 %").run().results
    answer = results.answer
    assert answer.answer[0].startswith("Demand 1: 3 robots are the first option shown to give at least 75 % on time: ")
    assert answer.answer[1].startswith("Demand 2.2: 4 robots are the only option shown to give at least 75 % on time: ")
    assert answer.about.model["fleet"]["size"] == 4
    verdicts = [one.verdict for one in results.judged.values()]
    assert [verdicts.count(name) for name in ("meets", "fails", "undecided")] == [3, 2, 1]
    assert answer.answer[2] == (
        "Of 6 options, 3 meet the target, 1 misses it, 1 needs more runs and 1 cannot keep up. "
        "About 104 runs would probably decide that option."
    )
    terminal = printed(answer, 80)
    assert "\n\nDemand 1\n" in terminal
    assert "\n\nDemand 2.2\n" in terminal


def test_a_study_of_one_design_says_what_it_achieves():
    flow = {"from": "dock", "to": "pack", "arrivals": {"poisson": 20}, "due_within": 100}
    model = dw.load(RING, {"tasks.flows": {"work": flow}, "run.length": 7200})
    study = dw.Study(model, {}, replications=3, indicators=["throughput_per_hour", "T"])
    answer = study.run(workers=1).results.answer
    assert answer.question == "What does the model achieve in throughput and task time?"
    assert re.fullmatch(r"Throughput: \S+ tasks/h \(\S+ to \S+\)\.", answer.answer[0])
    assert answer.answer[1].startswith("Task time: 2.0 h (")
    assert answer.figure is None
    aimed = dw.Study(model, {}, replications=3, target="on_time >= 1 %").run(workers=1).results.answer
    assert aimed.question == "Does the model give at least 1 % on time?"
    assert re.fullmatch(r"The model as it is is the only option .+\.", aimed.answer[0])


def test_questions_and_answers_are_sentences():
    flow = {"from": "dock", "to": "pack", "arrivals": {"poisson": 20}, "due_within": 60}
    model = dw.load(RING, {"tasks.flows": {"work": flow}, "run.length": 3600})
    one = dw.Study(model, {"traffic.node_time": [0, 1]}, indicators=["tasks"]).run(workers=1).results.answer
    assert one.question == "What does node time change in tasks delivered?"
    two = dw.Study(model, {"fleet.size": [1, 2]}, indicators=["tasks"]).run(workers=1).results.answer
    assert two.question == "What do 1 to 2 robots change in tasks delivered?"
    factors = {"fleet.size": [1, 2], "policies.allocation": ["nearest", "in-order"]}
    none = dw.Study(model, factors, replications=3, target="on_time >= 90 %").run(workers=1).results.answer
    assert none.question == "Which of 1 to 2 robots, with which dispatching, give at least 90 % on time?"
    assert none.answer[0].startswith("No option is shown to give at least 90 % on time. Best so far: ")
    assert (none.about, none.tiles) == (None, ())


def test_failed_runs_are_listed(study_folder, tmp_path):
    for file in ("study.json", "results.parquet"):
        (tmp_path / file).write_bytes((study_folder / file).read_bytes())
    table = pd.read_parquet(tmp_path / "results.parquet")
    table.loc[0, "error"] = "ran <flat>"
    table.loc[0, ["T", "S", "throughput_per_hour", "waiting"]] = float("nan")
    table.to_parquet(tmp_path / "results.parquet")
    page = Page(report(tmp_path).read_text(encoding="utf-8"))
    assert page.tables["runs-that-failed"][1][-1] == "ran <flat>"


def test_differences_are_those_of_the_study_and_the_largest_is_said_first(study_folder):
    study = Study.open(study_folder)
    comparison = study.compare("T")
    answer = compare_words.answer(study.results, {"T": comparison})
    assert is_everywhere(answer)
    for option, row in zip(answer.options, comparison.differences, strict=True):
        assert (option.number.low, option.number.high) == (row.estimate.interval or (None, None))
        assert option.p == row.p_adjusted
        assert option.standing == ("differs" if row.differs else "alike")
    told = [row for row in comparison.differences if row.differs]
    most = max(told, key=lambda row: abs(row.estimate.mean))
    [line] = answer.answer
    which = "less" if most.estimate.mean < 0 else "more"
    assert re.match(
        rf"Task time: \S+ steps \(\S+ to \S+\) {which} with {re.escape(option_of(answer, most))} than", line
    )


def option_of(answer, row):
    return next(one.name for one in answer.options if one.number.mean == row.estimate.mean)


def test_options_whose_runs_are_equal_are_compared_once():
    factors = {"fleet.size": [1, 3], "policies.allocation": ["nearest", "hungarian"]}
    results = dw.Study(example().replace(LASTING), factors, replications=3).run().results
    assert len(results.same) == 2
    answer = compare_words.answer(results, {"throughput_per_hour": results.compare("throughput_per_hour")})
    assert is_everywhere(answer)
    assert [(one.full_name, one.standing == "same") for one in answer.options] == [
        ("1 robot, dispatching: hungarian", True),
        ("3 robots, dispatching: nearest (same results: hungarian)", False),
    ]


def test_noise_is_no_difference(model):
    study = Study(model, {"battery.capacity": [100.0, 100.5]}, changes={"tasks.goods": {"random": 4}}, replications=3)
    results = study.run().results
    answer = compare_words.answer(results, {"T": results.compare("T")})
    assert answer.answer == ("No difference in task time is evident.",)


def test_compare_prints_one_json_object(study_folder):
    output = CliRunner().invoke(desim, ["compare", str(study_folder), "--json"], catch_exceptions=False).output
    assert '"kind": "compare"' in output
