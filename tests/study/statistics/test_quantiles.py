"""Quantiles over replications: worked by hand, then coverage, then what is refused."""

import math
from statistics import NormalDist

import numpy as np
import pytest

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.intervals import quantile, replications_for_quantile


def test_the_median_of_six_lies_between_the_least_and_the_most():
    """All six lie above the median, or all below, with probability 2 / 64 = 3.1 %; so it is not five, nor the inner."""
    median = quantile([3.0, 1.0, 4.0, 9.0, 5.0, 2.0], 0.5)
    assert (median.value, median.low, median.high) == (3.5, 1.0, 9.0)
    five = quantile([3.0, 1.0, 4.0, 9.0, 5.0], 0.5)
    assert (five.value, five.low, five.high) == (4.0, None, None)


def test_ranks_of_a_median_by_the_binomial():
    """Of 30 values, fewer than 10 lie below the median with probability P(Bin(30, 1/2) <= 9) = 2.1 %: 10 to 21."""
    median = quantile(range(1, 31), 0.5)
    assert (median.low, median.high) == (10, 21)


def test_a_high_quantile_needs_many_replications():
    """0.95^71 = 2.6 %, 0.95^72 = 2.5 %: with 72 days the slowest bounds the 95 % quantile from above."""
    assert replications_for_quantile(0.95) == 72
    assert quantile(range(71), 0.95).high is None
    assert quantile(range(72), 0.95).high == 71
    assert (quantile(range(71), 0.95).value, quantile(range(71), 0.95).low) == (66.5, 62)
    assert replications_for_quantile(0.5) == 6


def test_a_deterministic_model_needs_one_replication():
    exact = quantile([7.0], 0.95, deterministic=True)
    assert (exact.value, exact.low, exact.high, exact.deterministic) == (7.0, None, None, True)


@pytest.mark.parametrize("share", [pytest.param(0.1, marks=pytest.mark.long), 0.5, 0.95])
def test_intervals_cover_at_least_as_often_as_they_say_whatever_the_values_follow(share):
    values = np.random.default_rng(31).lognormal(0.0, 1.0, (300, 100))
    truth = math.exp(NormalDist().inv_cdf(share))
    intervals = [quantile(row, share) for row in values]
    assert np.mean([one.low <= truth <= one.high for one in intervals]) >= 0.945


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: quantile([], 0.95), "no values"),
        (lambda: quantile([1.0, np.nan], 0.95), "position 1"),
        (lambda: quantile([1.0, 2.0], 95), "quantile 95: expected a share between 0 and 1"),
        (lambda: quantile([1.0, 2.0], 1.0), "quantile 1.0: expected a share between 0 and 1"),
        (lambda: quantile([1.0, 2.0], "0.5"), "quantile '0.5': expected a share between 0 and 1"),
        (lambda: quantile([1.0, 2.0], 0.5, 95), "did you mean 0.95"),
        (lambda: quantile([1.0, 2.0], 0.5, None), "confidence None: expected a number between 0 and 1"),
        (lambda: quantile([1.0, 2.0], 0.5, deterministic=True), "deterministic model gave values from 1 to 2"),
    ],
)
def test_what_tells_nothing_is_refused(call, message):
    with pytest.raises(StudyError, match=message):
        call()
