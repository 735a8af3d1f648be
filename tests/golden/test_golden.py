"""Logs are what they were: see tests/golden/make.py for the recipe."""

import csv

import pytest

from tests.golden.make import CASES, HERE, RECIPE, run, table

NUMBERS = (0, 6, 7)  # time, value, until


@pytest.mark.parametrize("case", CASES)
def test_a_log_is_the_golden_one(case):
    text = (HERE / f"{case}.csv").read_text(encoding="utf-8")
    assert text.startswith(RECIPE)
    _, *golden = csv.reader(text.splitlines()[1:])
    now = table(run(case))
    for number, (row, kept) in enumerate(zip(now, golden, strict=False)):
        words = [field for i, field in enumerate(row) if i not in NUMBERS]
        assert words == [field for i, field in enumerate(kept) if i not in NUMBERS], f"row {number}"
        for i in NUMBERS:
            assert bool(row[i]) == bool(kept[i]), f"row {number}"
            assert float(row[i] or 0) == pytest.approx(float(kept[i] or 0), rel=1e-9, abs=1e-9), f"row {number}"
    assert len(now) == len(golden)


def test_there_is_something_golden():
    outcome = run("multibots")
    assert outcome.S >= 1
    assert outcome.kpis["tasks"] == 10
    assert {"collision", "parked", "delivered"} <= {row[1] for row in outcome.record.rows}
