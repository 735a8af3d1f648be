"""Sobol indices: the design's points, functions with known indices, and what is refused."""

import math

import numpy as np
import pytest

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.screening import Between, saltelli_design, saltelli_indices

UNIT = {name: Between(0.0, 1.0) for name in "abc"}


def sobol(function, factors, n):
    """The indices of a function of one design point."""
    design = saltelli_design(factors, n)
    return saltelli_indices(design, [function(point) for point in design.points])


def test_the_points_are_a_b_and_a_with_one_factor_from_b():
    design = saltelli_design(UNIT, n=8, seed=1)
    assert len(design.points) == 8 * (3 + 2)
    a, b = design.points[:8], design.points[8:16]
    for i, name in enumerate("abc"):
        mixed = design.points[16 + 8 * i : 24 + 8 * i]
        assert mixed == tuple({**p, name: q[name]} for p, q in zip(a, b, strict=True))


def test_the_same_seed_gives_the_same_points_and_another_gives_others():
    assert saltelli_design(UNIT, 8, seed=1) == saltelli_design(UNIT, 8, seed=1)
    assert saltelli_design(UNIT, 8, seed=1) != saltelli_design(UNIT, 8, seed=2)


def test_levels_and_whole_numbers_are_drawn_equally_often():
    factors = {"fleet.size": Between(1, 4, integer=True), "allocation": ["fifo", "nearest"]}
    points = saltelli_design(factors, n=64).points[:64]
    # a Sobol sequence of 64 points has exactly 16 in each quarter and 32 in each half
    assert [sum(p["fleet.size"] == size for p in points) for size in (1, 2, 3, 4)] == [16] * 4
    assert sum(p["allocation"] == "fifo" for p in points) == 32
    assert all(isinstance(p["fleet.size"], int) for p in points)


def test_an_additive_function_has_the_shares_of_its_coefficients():
    # variances 9 : 4 : 1, no interactions: first = total = 9/14, 4/14, 1/14
    result = sobol(lambda p: 3 * p["a"] + 2 * p["b"] + p["c"], UNIT, n=512)
    expected = {"a": 9 / 14, "b": 4 / 14, "c": 1 / 14}
    assert result.first == pytest.approx(expected, abs=0.02)
    assert result.total == pytest.approx(expected, abs=0.02)
    assert result.variance == pytest.approx(14 / 12, rel=0.05)


def test_the_ishigami_function_has_its_known_indices():
    # Ishigami & Homma (1990) with 7 and 0.1: first .3139 .4424 0, total .5576 .4424 .2437
    def ishigami(p):
        return math.sin(p["a"]) * (1 + 0.1 * p["c"] ** 4) + 7 * math.sin(p["b"]) ** 2

    result = sobol(ishigami, {name: Between(-math.pi, math.pi) for name in "abc"}, n=2048)
    assert result.first == pytest.approx({"a": 0.3139, "b": 0.4424, "c": 0.0}, abs=0.03)
    assert result.total == pytest.approx({"a": 0.5576, "b": 0.4424, "c": 0.2437}, abs=0.03)
    for name, truth in {"a": 0.5576, "b": 0.4424, "c": 0.2437}.items():
        low, high = result.total_interval[name]
        assert low <= truth <= high
        assert high - low < 0.15


def test_pure_interaction_shows_in_the_totals_only():
    # (a - 1/2)(b - 1/2): nothing alone, everything together, nothing from c
    result = sobol(lambda p: (p["a"] - 0.5) * (p["b"] - 0.5), UNIT, n=1024)
    assert result.first == pytest.approx({"a": 0.0, "b": 0.0, "c": 0.0}, abs=0.05)
    assert result.total == pytest.approx({"a": 1.0, "b": 1.0, "c": 0.0}, abs=0.05)


def test_the_intervals_are_the_same_for_the_same_seed():
    design = saltelli_design(UNIT, 16)
    values = np.random.default_rng(0).normal(size=80)
    assert saltelli_indices(design, values, seed=4) == saltelli_indices(design, values, seed=4)
    assert saltelli_indices(design, values, seed=4) != saltelli_indices(design, values, seed=5)


def test_an_indicator_that_does_not_vary_has_no_shares():
    result = sobol(lambda p: 0.1, UNIT, n=16)
    assert result.variance == 0.0
    assert all(math.isnan(v) for v in (*result.first.values(), *result.total.values()))


@pytest.mark.parametrize(
    ("factors", "n", "message"),
    [
        ({"a": Between(0, 1)}, 8, "1 factors"),
        (UNIT, 12, "12: expected a power of 2"),
        (UNIT, 0, "power of 2"),
        ({"a": Between(0, 1), "b": []}, 8, "'b' has no levels"),
    ],
)
def test_designs_that_cannot_be_made_are_refused(factors, n, message):
    with pytest.raises(StudyError, match=message):
        saltelli_design(factors, n)


@pytest.mark.parametrize("arguments", [(1, 1), (2, 1), (0, math.inf), (0.5, 2, True)])
def test_ranges_that_are_none_are_refused(arguments):
    with pytest.raises(StudyError, match="low < high"):
        Between(*arguments)


def test_missing_and_failed_values_are_refused():
    design = saltelli_design(UNIT, 8)
    with pytest.raises(StudyError, match=r"39 values, expected .* 40"):
        saltelli_indices(design, [1.0] * 39)
    with pytest.raises(StudyError, match="position 7"):
        saltelli_indices(design, [1.0] * 7 + [math.nan] + [1.0] * 32)
