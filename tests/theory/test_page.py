"""docs/dev/validation.md says what the cases give; rows of the fast cases are made anew in test_cases.py."""

import re

import pytest

from docs import make_validation
from docs.make_validation import PAGE, PICTURES, ROBOTS
from tests.reference import rawsimo
from tests.reference.stops import Unmatched
from tests.theory.cases import CASES, Found

TEXT = PAGE.read_text(encoding="utf-8")
LONG = pytest.mark.long


def test_every_quantity_of_every_case_has_its_row():
    for case in CASES:
        for quantity in case.quantities:
            assert f"| {case.title} | {quantity.name} | {quantity.theory:.5g} | " in TEXT
    assert TEXT.count(" | agrees (") == sum(len(case.quantities) for case in CASES)


def test_everything_agrees():
    assert "DIFFERS" not in TEXT


def test_a_row_that_is_off_would_say_so():
    case = CASES[0]
    theory = case.quantities[0].theory
    off = Found(case, case.quantities[0], [1.02 * theory, 1.021 * theory, 1.019 * theory])
    assert (off.contains, off.near) == (False, True)
    assert "DIFFERS" in make_validation.row(off)
    wide = Found(case, case.quantities[0], [0.9 * theory, theory, 1.1 * theory])
    assert (wide.contains, wide.near) == (True, False)
    assert "DIFFERS" in make_validation.row(wide)


@pytest.mark.parametrize("robots", [pytest.param(n, marks=[] if n == 1 else [LONG]) for n in ROBOTS])
def test_the_event_model_beside_the_stepped_reference(robots):
    beside = make_validation.beside(robots)
    assert beside.agrees
    assert "| " + " | ".join(beside.row) + " |" in TEXT


@LONG
def test_the_papers_cells_stand_on_the_page():
    assert make_validation.paper().rstrip() in TEXT


@pytest.mark.long  # tests/world/test_pods.py has its rules in small every day
def test_lines_an_hour_of_pods_are_those_of_rawsimo():
    assert make_validation.pods().rstrip() in TEXT
    most, nearest = re.search(r"difference is ([\d.]+) % for most lines and ([\d.]+) % for the nearest", TEXT).groups()
    bounds = [within for *_, within in rawsimo.RULES.values()]
    assert [float(most) <= 100 * bounds[0], float(nearest) <= 100 * bounds[1]] == [True, True]
    here, there = re.search(r"at (\d+) robots here and at (\d+) there", TEXT).groups()
    assert here == there


def test_the_figures_show_every_row():
    """Drawn from made-up values: what stands where, not what came out."""
    every = [(case, one) for case in CASES for one in case.quantities]
    outcomes = [Found(case, one, [one.theory, 1.01 * one.theory][: case.runs]) for case, one in every]
    besides = [make_validation.Beside(n, (0.99, 1.0, 1.01), 1, 1, 3, 3, Unmatched(0, 0, 0, 0)) for n in ROBOTS]
    (axes,) = make_validation.intervals(outcomes, besides).axes
    names = [label.get_text() for label in axes.get_yticklabels()]
    assert len(names) == sum(case.runs > 1 for case, _ in every) + len(besides)
    assert names[-1] == f"{CASES[0].title}: {CASES[0].quantities[0].name}"
    assert names[0] == "stepped reference, robots: 12, T"
    closed, rings = make_validation.curves(outcomes).axes
    assert [line.get_label() for line in closed.lines] == ["closed line D/D/1, theory", "simulated"]
    assert list(closed.lines[0].get_xdata()) == [2, 4, 5, 8]
    assert list(closed.lines[0].get_ydata()) == [180, 360, 360, 360]
    assert len(rings.lines) == 4
    assert (PICTURES / "validation.png").exists()
