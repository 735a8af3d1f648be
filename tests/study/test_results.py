"""Results of a study: the same from the study and from its folder."""

import dataclasses
import json
import shutil
from pathlib import Path

import pandas as pd
import pytest

import desim_warehouse as dw

from .conftest import MULTIBOTS

FOLDER = Path(__file__).parents[1] / "kept" / "0.3.0" / "plan" / "today"
LIFELONG = {"tasks.goods": {"saturated": 12}, "run.length": 2000}


@pytest.fixture
def folder(tmp_path):
    return shutil.copytree(FOLDER, tmp_path / "old")


def test_a_folder_without_its_journal_is_read_from_its_table(folder):
    (folder / "runs.jsonl").unlink()
    results, whole = dw.Results.load(folder), dw.Results.load(FOLDER)
    assert results.table.equals(whole.table)
    assert results.summary().equals(whole.summary())
    assert results.indicators == whole.indicators


def test_a_table_of_another_study_is_refused(folder):
    (folder / "runs.jsonl").unlink()
    table = pd.read_parquet(folder / "results.parquet")
    table.rename(columns={"fleet.size": "robots"}).to_parquet(folder / "results.parquet")
    with pytest.raises(dw.StudyError, match=r"results\.parquet: not the table of this study \('fleet.size' is missing"):
        dw.Results.load(folder)


def test_equal_points_of_paired_lists_keep_their_runs(tmp_path):
    """A drawn design of whole numbers has points twice; a table alone does not say which row is whose."""
    factors = {"fleet.size": [1, 2, 1, 2, 2], "tasks.load_time": [9, 10, 10, 10, 10]}
    changes = {"tasks.goods": [1, 2]}
    made = dw.Study(MULTIBOTS, factors, design="paired", changes=changes, indicators=["T"]).run(out=tmp_path)
    assert len(made.results.designs) < len(made.points)
    (tmp_path / "runs.jsonl").unlink()
    opened = dw.Results.load(tmp_path)
    assert [row.point.number for row in opened.rows] == [row.point.number for row in made.rows]
    assert opened.table["T"].tolist() == made.table["T"].tolist()


def test_a_folder_of_a_design_that_0_3_sampled_opens_with_its_points(tmp_path):
    factors = {"fleet.size": [2, 1, 2], "tasks.load_time": [9.25, 9.5, 9.25]}
    changes = {"tasks.goods": [1, 2]}
    made = dw.Study(MULTIBOTS, factors, design="paired", changes=changes, indicators=["T"]).run(out=tmp_path)
    path = tmp_path / "study.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    levels = [
        {"label": size, "changes": {"fleet.size": size}, "at": ["factors", "fleet.size", size]} for size in (1, 2)
    ]
    between = {"low": 9, "high": 10, "whole": False}
    content["design"] = {"rule": "latin-hypercube", "size": 3}
    content["factors"] = [{"key": "fleet.size", "levels": levels}, {"key": "tasks.load_time", "between": between}]
    path.write_text(json.dumps(content), encoding="utf-8")
    opened = dw.Results.load(tmp_path)
    assert [point.labels for point in opened.points] == [point.labels for point in made.points]
    assert opened.table["T"].tolist() == made.table["T"].tolist()


def test_results_are_frozen_and_stay_when_the_study_runs_on():
    study = dw.Study(MULTIBOTS, {"fleet.size": [1, 2]}, changes={"tasks.goods": {"random": 3}}).run()
    before = study.results
    with pytest.raises(dataclasses.FrozenInstanceError):
        before.rows = ()
    study.plan = dataclasses.replace(study.plan, replications=2)
    study.run()
    assert (len(before.rows), len(study.results.rows)) == (2, 4)


def test_a_design_that_was_not_finished_is_left_out_or_named():
    study = dw.Study(MULTIBOTS, {"fleet.size": [1, 2, 3]}, changes={"tasks.goods": {"random": 3}}, replications=2)
    whole = study.run().results
    part = dataclasses.replace(whole, rows=tuple(row for row in whole.rows if row.point.number != 1))
    assert [one.design for one in part.compare_finished("T").differences] == ["fleet.size=3"]
    with pytest.raises(dw.StudyError, match=r"'fleet\.size=2' has no finished replication in common"):
        part.compare("T")


def test_lifelong_models_show_what_differs_between_them():
    study = dw.Study(MULTIBOTS, {"fleet.size": [1, 2]}, changes=LIFELONG)
    first = ["throughput_per_hour", "cycle_time_p95", "backlog", "share_waiting"]
    assert study.run().results.usual(4) == first  # nothing is due
    due = {**LIFELONG, "tasks.goods": {"saturated": 12, "due_within": 500}}
    assert dw.Study(MULTIBOTS, {}, changes=due).run().results.usual(5) == [*first[:2], "on_time", *first[2:]]
    ends = dw.Study(MULTIBOTS, {}, changes={"tasks.goods": [1]}).run()
    assert ends.results.usual(3) == ["T", "S", "C"]


def test_quantiles_over_days_have_intervals():
    """72 days: the slowest bounds the time that 95 % of all days stay below."""
    study = dw.Study(MULTIBOTS, {"fleet.size": [5, 6]}, changes={"tasks.goods": {"random": 3}}, replications=72)
    results = study.run().results
    quantiles = results.quantiles("T", 0.95)
    for number, one in quantiles.items():
        days = sorted(row.value("T") for row in results.by_point[number])
        assert one.high == days[-1]
        assert one.low <= one.value <= one.high
        assert one.n == 72
    assert results.quantiles("T", 0.5)[0].value == results.estimates("T")[0].median


def test_a_quantile_of_a_deterministic_study_is_exact():
    quantile = dw.Study(MULTIBOTS, {"fleet.size": [2]}).run().results.quantiles("T", 0.95)[0]
    assert quantile.deterministic
    assert (quantile.low, quantile.high) == (None, None)
