"""Indicators of the user's own: the table has them, they are kept and resumed, and every way to simulate agrees."""

import concurrent.futures
import multiprocessing

import pandas as pd
import pytest

import desim_warehouse as dw
from tests.study.measuring import MODEL, calls, per_task, row_of


def wrong(run):
    return run.kpis["no such indicator"]


def study(function=per_task, **more):
    return dw.Study(MODEL, {"fleet.size": [1, 2]}, replications=3, indicators={"per_task": function}, **more)


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return plain(study().run().table)


def plain(table):
    return table.drop(columns="run_time")


def by_hand(seed):
    run = dw.simulate(MODEL.replace({"fleet.size": 2}), seed=seed)
    return run.robots["distance"].sum() / run.kpis["tasks"]


def test_it_is_a_column_like_the_others(table):
    row = table.iloc[4]
    assert row["fleet.size"] == 2
    assert row["per_task"] == by_hand(int(row["seed"]))
    assert {"T", "S", "throughput_per_hour"} <= set(table)
    made = study().run()
    assert set(made.summary(["per_task"])["indicator"]) == {"per_task"}
    assert "per_task" in str(made.compare("per_task"))
    assert made.main_effects("per_task").factors[0].swing > 0


def test_it_is_kept_in_the_folder_and_resumed(tmp_path, table):
    study().run(out=tmp_path)
    calls.clear()
    pd.testing.assert_frame_equal(plain(study().run(out=tmp_path).table), table)
    assert not calls
    opened = dw.Study.open(tmp_path)
    pd.testing.assert_frame_equal(plain(opened.run(out=tmp_path).table), table)
    assert not calls
    more = dw.Study(MODEL, {"fleet.size": [1, 2]}, replications=4, indicators={"per_task": per_task}).run(out=tmp_path)
    assert len(calls) == 2
    assert len(more.table) == 8


def test_a_changed_function_is_another_indicator(tmp_path):
    study().run(out=tmp_path)
    twice = study(lambda run: 2 * per_task(run)).run(out=tmp_path)
    assert twice.table["per_task"].iloc[4] == 2 * by_hand(int(twice.table["seed"].iloc[4]))


def test_a_folder_says_that_it_has_no_function(tmp_path):
    made = study().run(out=tmp_path)
    (tmp_path / "runs.jsonl").write_bytes(b"".join((tmp_path / "runs.jsonl").read_bytes().splitlines(True)[:3]))
    with pytest.raises(dw.StudyError, match="indicator per_task: its function is not in the folder"):
        dw.Study.open(tmp_path).run(out=tmp_path)
    assert len(made.run(out=tmp_path).table) == 6


def test_what_a_function_raises_is_told_with_its_line():
    line = wrong.__code__.co_firstlineno + 1
    with pytest.raises(dw.StudyError, match=rf"indicator per_task: raised .* in .*test_own_indicators.py, line {line}"):
        study(wrong).run()


@pytest.mark.parametrize("name", ["T", "seed", "on_time@11:30-13:00"])
def test_names_of_ours_are_refused(name):
    with pytest.raises(dw.StudyError, match="there is one of this name already"):
        dw.Study(MODEL, indicators={name: per_task})


def test_a_function_that_is_none_is_refused():
    with pytest.raises(dw.StudyError, match="'per_task', expected a function of a run"):
        dw.Study(MODEL, indicators={"mine": "per_task"})


@pytest.mark.slow
def test_worker_processes_give_the_same_table(table):
    pd.testing.assert_frame_equal(plain(study().run(workers=2).table), table)


@pytest.mark.slow
@pytest.mark.long
def test_so_do_processes_of_the_user(table):
    jobs = list(zip(table["fleet.size"], table["seed"].astype(int), strict=True))
    with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        rows = pd.concat(pool.map(row_of, *zip(*jobs, strict=True)), ignore_index=True)
    names = ["T", "S", "C", "throughput_per_hour", "distance"]
    pd.testing.assert_frame_equal(rows[names], table[names], check_dtype=False)
