"""Logs are what they were: see tests/golden/make.py for the recipe."""

import csv
import json

import pytest

from desim_warehouse.outcome.log import LogRow
from tests.golden.make import CASES, HERE, INDICATORS, RECIPE, indicators, run, shipped, table

NUMBERS = (0, 6, 7)  # time, value, until


@pytest.mark.parametrize("case", CASES)
def test_a_log_is_the_golden_one(case):
    text = (HERE / f"{case}.csv").read_text(encoding="utf-8")
    assert text.startswith(RECIPE)
    columns, *golden = csv.reader(text.splitlines()[1:])
    assert columns == list(LogRow._fields[: len(columns)])
    now = [row[: len(columns)] for row in table(run(case))]  # columns that came later are not golden yet
    for number, (row, kept) in enumerate(zip(now, golden, strict=False)):
        words = [field for i, field in enumerate(row) if i not in NUMBERS]
        assert words == [field for i, field in enumerate(kept) if i not in NUMBERS], f"row {number}"
        for i in NUMBERS:
            assert bool(row[i]) == bool(kept[i]), f"row {number}"
            assert float(row[i] or 0) == pytest.approx(float(kept[i] or 0), rel=1e-9, abs=1e-9), f"row {number}"
    assert len(now) == len(golden)


def quick_or_slow(name):
    marks = {"large": [pytest.mark.long], "my_own_day": [pytest.mark.slow]}
    return pytest.param(name, marks=marks.get(name, []))


@pytest.mark.parametrize("name", [*map(quick_or_slow, shipped())])
def test_the_indicators_of_a_shipped_model_are_the_golden_ones(name):
    assert indicators(name) == json.loads(INDICATORS.read_text(encoding="utf-8"))[name]


HAPPENS = {
    "multibots": {"collision", "parked", "delivered"},
    "tutorial": {"collision", "queueing", "docked"},
    "two_way_zones": {"collision", "docked", "parked"},
    "closures_people": {"edge_closed", "edge_opened", "waiting_person", "person_in", "person_out"},
    "closures_one_way": {"edge_closed", "edge_opened", "waiting_closed", "delivered"},
    "closures_two_way": {"edge_closed", "edge_opened", "waiting_closed", "delivered"},
    "flows": {"worked", "closed", "on_break", "recharged", "docked"},
    "acceleration_breakdowns": {"broken", "collision", "drive"},
    "imported": {"delivered", "parked"},
}


@pytest.mark.parametrize("case", CASES)
def test_what_a_case_is_golden_for_happens_in_it(case):
    outcome = run(case)
    assert outcome.kpis["tasks"] >= 3
    assert {row[1] for row in outcome.record.rows} >= HAPPENS[case]
