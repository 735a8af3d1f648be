"""Folders written by version 0.1.0 are read: the run and the study that it saved are kept beside this test."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest

import desim_warehouse as dw
from desim_warehouse.report import run_parts
from desim_warehouse.report.export import tables
from desim_warehouse.report.study_parts import read as read_study

RUN, STUDY = (Path(__file__).with_name(f"{kind}_by_0_1_0") for kind in ("saved", "study"))


def test_a_run_has_the_indicators_and_tables_that_were_saved_with_it():
    run = dw.load_run(RUN)
    assert json.loads((RUN / "run.json").read_text())["version"] == "0.1.0"
    saved = json.loads((RUN / "kpis.json").read_text())
    saved["cost"] -= run.model.cost.time * run.model.run.warm_up  # it counts the counted time since
    assert {name: run.kpis[name] for name in saved} == saved
    assert run.kpis["energy_lowest"] == pytest.approx(1 - 256 / 1000)  # the log does not tell the levels at the end
    pd.testing.assert_frame_equal(run.log, pd.read_parquet(RUN / "log.parquet"), check_dtype=False)
    for name in ("robots", "edges", "nodes"):
        pd.testing.assert_frame_equal(getattr(run, name), pd.read_csv(RUN / f"{name}.csv", index_col=0))


def test_a_run_is_read_as_it_was_by_everything_that_shows_it():
    """The second robot waits for the first at the bay, while that takes its good, and before the station."""
    run = dw.load_run(RUN)
    waits = [(wait.start, wait.end, wait.robot, wait.other) for wait in run.waits.itertuples()]
    assert waits == [(0, 1, 1, 0), (10, 13, 1, 0), (66, pytest.approx(66 + 2.366, abs=1e-3), 1, 0)]
    had = [(one.robot, one.task, one.start, one.ended) for one in run.history.assignments]
    assert had == [(0, 0, 0, "delivered"), (1, 1, 0, "delivered"), (0, 2, 68, "delivered")]
    assert run.history.energy_at_end == [pytest.approx(1000 - 256), 1000]
    assert set(tables(run)) == {"kpis", "log", "states", "waits", "robots", "edges", "nodes"}
    assert "3 tasks delivered in 246 s after a warm-up of 10 s" in run_parts.short(run).source
    assert "ring: replay" in run.replay().html


def test_a_study_is_reported_with_the_runs_that_were_saved_with_it():
    study = read_study(STUDY)
    saved = pd.read_parquet(STUDY / "results.parquet")
    pd.testing.assert_frame_equal(study.table.drop(columns="deterministic"), saved)
    assert saved["T"].tolist() == [384.0, 256.0]
    found = study.compare_finished("T")
    assert found is not None
    assert found.differences[0].estimate.mean == pytest.approx(-128)
