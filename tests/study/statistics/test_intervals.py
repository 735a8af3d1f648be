"""A mean and its t interval: worked by hand, then laws, then what is refused."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.stats import binomtest

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.intervals import bounds, estimate
from desim_warehouse.study.statistics.judge import judged
from desim_warehouse.study.target import read_target

NUMBERS = st.lists(st.integers(-1000, 1000).map(float), min_size=2, max_size=30)


def test_three_replications_worked_by_hand():
    # mean 10, variance (4 + 0 + 4) / 2 = 4, t(2 df, 0.975) = 4.302653, half-width 4.302653 * 2 / sqrt(3)
    result = estimate([8, 10, 12])
    assert (result.n, result.mean, result.sd, result.median) == (3, 10.0, 2.0, 10.0)
    assert result.half_width == pytest.approx(4.968275, abs=1e-6)
    assert result.interval == pytest.approx((5.031725, 14.968275), abs=1e-6)
    assert result.relative_half_width == pytest.approx(0.4968275, abs=1e-7)
    assert not result.deterministic
    # linear interpolation: the 0.25 quantile of 3 values is half-way from the first to the second
    assert result.quantiles == pytest.approx({0.05: 8.2, 0.25: 9.0, 0.75: 11.0, 0.95: 11.8})


def test_the_example_of_the_textbook():
    # Law (2015), section 4.5: ten observations, 90 % interval 1.34 ± 0.24
    values = [1.20, 1.50, 1.68, 1.89, 0.95, 1.49, 1.58, 1.55, 0.50, 1.09]
    result = estimate(values, confidence=0.90)
    assert round(result.mean, 2) == 1.34
    low, high = result.interval
    assert round((high - low) / 2, 2) == 0.25  # as wide, but farther down: the value 0.50 is far from the others
    assert round(estimate(values[:9], 0.90).half_width, 2) == round(1.859548 * 0.423747 / 3, 2)  # t alone


def test_ten_values_worked_by_hand():
    # deviations -3 (6 times) and 4.5 (4 times): mean 3, sd sqrt(15), skewness (6 (-27) + 4 * 91.125) / 10 / 13.5^1.5
    # = 0.40825, a = 0.12910, t(9 df, 0.975) = 2.262157; 3/a (cbrt(1 + a (2.262157 - a/6)) - 1) = 2.0538,
    # with -2.262157: -2.5541; times sqrt(15 / 10) = 1.224745
    result = estimate([0.0] * 6 + [7.5] * 4)
    assert result.interval == pytest.approx((3 - 2.0538 * 1.224745, 3 + 2.5541 * 1.224745), abs=1e-3)
    assert result.half_width == pytest.approx(2.5541 * 1.224745, abs=1e-3)


def test_one_value_far_out_at_most_doubles_what_student_says():
    # mean 1, standard error 1: the cubic alone would reach 3.2 times as far as t
    result = estimate([0.0] * 9 + [10.0])
    assert result.interval[1] == pytest.approx(1 + 2 * 2.262157, abs=1e-5)


def test_a_rare_event_has_the_interval_of_a_proportion():
    # Clopper & Pearson (1934): 1 of 10, 95 %: 0.0025 to 0.4450
    assert estimate([0.0] * 9 + [1.0]).interval == pytest.approx((0.0025, 0.4450), abs=1e-4)
    test = binomtest(3, 17).proportion_ci(0.9)
    assert estimate([1.0] * 3 + [0.0] * 14, 0.9).interval == pytest.approx((test.low, test.high))
    # none of 10: 1 - 0.025^(1/10) = 0.3085
    assert estimate([0.0] * 10, within=(0, 1)).interval == pytest.approx((0.0, 0.3085), abs=1e-4)


def test_a_count_may_exceed_1_though_no_run_did():
    # Garwood (1936): 1 event in 3 runs, 95 %: 0.0253 / 3 to 5.5716 / 3
    one = estimate([0.0, 0.0, 1.0], within=(0, math.inf), counts=True)
    assert one.interval == pytest.approx((0.00844, 1.8572), abs=1e-4)


def test_a_count_of_0_in_all_runs_has_the_interval_of_a_poisson_mean():
    # Garwood (1936): no event in 3 runs, 95 %: 0 to -ln(0.025) / 3 = 3.6889 / 3; a share of days has 1 - 0.025^(1/3)
    assert estimate([0.0] * 3, within=(0, math.inf), counts=True).interval == pytest.approx((0, 1.2296), abs=1e-4)
    assert estimate([0.0] * 3, within=(0, 1)).interval == pytest.approx((0, 0.7076), abs=1e-4)
    # one event in each of 3 runs: Garwood's limits for 3 events, 0.6187 and 8.7673, over 3
    assert estimate([1.0] * 3, within=(0, math.inf), counts=True).interval == pytest.approx((0.2062, 2.9224), abs=1e-4)


SECONDS = {"s": 1.0, "h": 3600.0, "d": 86_400.0}


@pytest.mark.parametrize("unit", SECONDS)
@pytest.mark.parametrize(
    "seconds",
    [[0.0] * 5, [720.0] * 5, [0.0, 0.0, 3600.0], [0.0] * 4 + [86_400.0], [1.0, 0.0, 1.0]],
    ids=["never late", "always alike", "an hour once", "a day once", "a second twice"],
)
def test_a_time_has_the_same_interval_in_seconds_hours_and_days(unit, seconds):
    """Mean tardiness 0 in five runs was `0 s (0 to 0.52)` and `0 h (0 to 0.52)`, up to half an hour for one hall."""
    by, in_seconds = SECONDS[unit], estimate(seconds, within=(0, math.inf)).interval
    there = estimate([value / by for value in seconds], within=(0, math.inf)).interval
    assert (there is None) == (in_seconds is None) == (not any(seconds))
    assert in_seconds is None or [by * end for end in there] == pytest.approx(in_seconds)


@pytest.mark.parametrize("unit", SECONDS)
@pytest.mark.parametrize(("seconds", "verdict"), [(300, "meets"), (1, "meets"), (0, "undecided")])
def test_a_target_is_met_by_days_without_a_wait_in_every_unit(unit, seconds, verdict):
    """All 33 days without a wait, against at most 5 min, 1 s and 0: none of the days shows that a mean is 0."""
    target = read_target(f"cycle_time_mean <= {seconds / SECONDS[unit]!r}")
    judgement = judged(None, [0.0] * 33, target, 0.95, False, target.measure.within, least=33)
    assert (judgement.verdict, judgement.low, judgement.high, judgement.agrees) == (verdict, None, None, True)


@pytest.mark.parametrize("runs", [3, 5, 20])
@pytest.mark.parametrize("mean", [0.5, 1.2])
def test_intervals_of_small_counts_hold_the_mean_as_often_as_they_say(runs, mean):
    counts = np.random.default_rng(1).poisson(mean, (2000, runs)).astype(float)
    held = [low <= mean <= high for low, high in (bounds(row, 0.975, counts=True) for row in counts)]
    assert np.mean(held) > 0.94


def test_the_interval_of_a_share_stays_within_0_and_1():
    low, high = estimate([0.9, 0.99, 1.0], within=(0, 1)).interval
    assert 0 < low < 1
    assert high == 1.0


def test_equal_values_of_a_deterministic_model_have_no_interval():
    result = estimate([0.1 + 0.2, 0.3, 0.3], deterministic=True)  # equal but for rounding
    assert result.deterministic
    assert result.half_width is None
    assert result.interval is None
    assert result.sd == 0.0


def test_equal_values_so_far_are_neither_exact_nor_infinitely_precise():
    # ten runs of 5: up to 30.85 % of all runs may differ, and lie anywhere from 0 to 10
    result = estimate([5.0] * 10)
    assert (result.deterministic, result.sd) == (False, 0.0)
    assert result.interval == pytest.approx((5 - 1.5425, 5 + 1.5425), abs=1e-4)


def test_two_values_that_differ_by_rounding_have_no_spread():
    assert 0.1 + 0.2 != 0.3
    assert estimate([0.1 + 0.2, 0.3]).sd == 0.0


def test_a_small_spread_that_is_more_than_rounding_is_a_spread():
    result = estimate([1.0, 1.0 + 1e-9])
    assert not result.deterministic
    assert result.half_width > 0


def test_one_replication_has_no_interval_and_is_not_called_deterministic():
    result = estimate([7.0])
    assert (result.mean, result.half_width, result.sd, result.deterministic) == (7.0, None, None, False)


def test_one_replication_of_a_model_known_to_be_deterministic_is_exact():
    result = estimate([7.0], deterministic=True)
    assert (result.deterministic, result.half_width, result.sd) == (True, None, 0.0)


def test_a_deterministic_model_with_differing_values_is_a_contradiction():
    with pytest.raises(StudyError, match="deterministic model gave values from 1 to 2"):
        estimate([1.0, 2.0], deterministic=True)


def test_a_mean_of_zero_has_no_relative_precision():
    assert estimate([-1.0, 1.0]).relative_half_width == math.inf


def test_three_values_have_students_half_width():
    assert estimate([8, 10, 12]).half_width == pytest.approx(4.97, abs=0.005)


@pytest.mark.parametrize(
    ("values", "confidence", "message"),
    [
        ([], 0.95, "no values"),
        ([1.0, math.nan, math.inf], 0.95, "position 1, 2"),
        ([[1.0, 2.0]], 0.95, r"shape \(1, 2\)"),
        ([1.0, 2.0], 95, r"did you mean 0.95\?"),
        ([1.0, 2.0], 1.0, "between 0 and 1"),
    ],
)
def test_bad_input_is_refused_with_its_place(values, confidence, message):
    with pytest.raises(StudyError, match=message):
        estimate(values, confidence)


@given(NUMBERS, st.integers(-100, 100), st.sampled_from([0.5, 2.0, 4.0]))
def test_a_change_of_unit_changes_the_interval_alike(values, shift, scale):
    assume(min(values) < max(values))
    before = estimate(values)
    after = estimate([scale * v + shift for v in values])
    assert after.deterministic == before.deterministic
    assert after.mean == pytest.approx(scale * before.mean + shift, abs=1e-9)
    assert (after.half_width or 0.0) == pytest.approx(scale * (before.half_width or 0.0), rel=1e-9)


@given(NUMBERS)
def test_more_confidence_is_a_wider_interval(values):
    assume(any(values))  # else neither has an interval
    narrow, wide = estimate(values, 0.9), estimate(values, 0.99)
    assert narrow.half_width < wide.half_width


@given(NUMBERS)
def test_quantiles_rise_and_stay_within_the_values(values):
    q = list(estimate(values).quantiles.values())
    assert q == sorted(q)
    assert min(values) <= q[0]
    assert q[-1] <= max(values)
