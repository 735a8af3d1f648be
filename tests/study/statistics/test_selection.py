"""The best of several designs by KN: constants and a race worked by hand, then laws, then what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.selection import kn_constants, kn_steps
from tests.study.statistics.searches import kn


def race(differences, **options):
    """Two designs that differ by `differences` in turn; 2α = 0.1 and n0 = 3 make h² = 18."""
    table = [differences, [0.0] * len(differences)]
    return kn(lambda design, r: table[design][r], 2, delta=2.0, n0=3, **options)


def test_the_constants_by_their_formula():
    # 2α/(k-1) = 0.1, exponent -2/(3-1) = -1: η = (10 - 1) / 2 = 4.5, h² = 2 * 4.5 * 2 = 18
    assert kn_constants(2, 0.95, 3) == pytest.approx((4.5, 18.0))
    # 2α/(k-1) = 0.1/10 = 0.01, exponent -2/(5-1) = -1/2: η = (10 - 1) / 2 = 4.5, h² = 9 * 4 = 36
    assert kn_constants(11, 0.95, 5) == pytest.approx((4.5, 36.0))


def test_a_clear_lead_ends_the_race_after_the_first_stage():
    # differences 1 2 3: S² = 1, h² S² / δ² = 4.5; W(3) = 2/(2*3) * (4.5 - 3) = 0.5 < mean 2
    result = race([1, 2, 3])
    assert (result.best, result.survivors, result.samples) == (0, (0,), (3, 3))
    assert result.eliminated_at == (None, 3)
    assert result.means == (2.0, 0.0)
    assert result.guaranteed


def test_a_close_race_goes_on_until_the_band_has_closed():
    # differences -1 0 1: S² = 1, limit 4.5. r = 3: mean 0, W = 0.5;
    # r = 4: mean 0.4/4 = 0.1 < W = 2/8 * 0.5 = 0.125;
    # r = 5 = floor(4.5) + 1: W = 0, mean (0.4 - 0.9)/5 = -0.1, so the first design drops out
    result = race([-1, 0, 1, 0.4, -0.9])
    assert (result.best, result.samples, result.eliminated_at) == (1, (5, 5), (5, None))
    assert result.guaranteed


def test_the_band_is_as_wide_as_the_formula_says():
    # as above, but the fourth difference 0.6 makes the mean 0.15 > 0.125: over at r = 4
    result = race([-1, 0, 1, 0.6])
    assert (result.best, result.samples, result.eliminated_at) == (0, (4, 4), (None, 4))


def test_a_design_that_drops_out_keeps_the_mean_it_was_judged_by():
    # the third is 96 and more behind at r = 3 and has made its last run; the others go on to r = 4 as above.
    # Three designs make 2α/(k-1) = 0.05, η = 9.5, h² = 38: S² = 1, limit 9.5, W(4) = 2/8 * 5.5 = 1.375 < 1.5
    table = [[-1, 0, 1, 6], [0, 0, 0, 0], [-100, -100, -100]]
    result = kn(lambda design, r: table[design][r], 3, delta=2.0, n0=3)
    assert result.eliminated_at == (None, 4, 3)
    assert result.samples == (4, 4, 3)
    assert result.means == (1.5, 0.0, -100.0)


def test_the_smallest_mean_can_be_the_best():
    assert race([1, 2, 3], maximise=False).best == 1


def test_the_cap_ends_the_race_without_a_guarantee():
    result = race([-1, 0, 1, 0.4], cap=4)
    assert (result.best, result.survivors, result.guaranteed) == (0, (0, 1), False)


def test_deterministic_designs_are_compared_as_numbers_and_equals_by_number():
    result = kn(lambda design, r: [0.1, 0.3, 0.3][design], 3, delta=0.15, deterministic=True)
    assert (result.best, result.survivors, result.samples) == (1, (1, 2), (10, 10, 10))
    assert result.within == (2,)
    assert result.deterministic
    assert result.guaranteed


def test_differences_that_agree_so_far_get_the_variance_of_a_share_that_may_differ():
    # three equal differences: 1 - 0.05^(1/3) = 63 % of runs may differ, by 1: S² = 0.63 instead of 0, and with
    # delta 0.5 the limit is 18 * 0.63 / 0.25 = 45.5: over at 46
    result = kn(lambda design, r: 0.0, 2, delta=0.5, n0=3)
    assert (result.samples, result.survivors, result.deterministic) == ((46, 46), (0, 1), False)
    # 46 runs without a difference leave 6.3 % that may differ by 1, less than delta
    assert result.within == (1,)


def test_designs_are_near_the_best_only_if_the_bound_of_their_difference_is():
    # worse by 0.1 and 10 on average, sd 1.05: t(9 df, 0.975) = 2.262 times 1.054 / sqrt(10) = 0.754
    noise = [1.0, -1.0] * 5
    table = [[5.0] * 10, [4.9 + z for z in noise], [-5.0 + z for z in noise]]
    result = kn(lambda design, r: table[design][r], 3, delta=0.9, cap=10)
    assert (result.best, result.within) == (0, (1,))
    assert kn(lambda design, r: table[design][r], 3, delta=0.8, cap=10).within == ()


def test_the_steps_ask_for_the_first_stage_at_once():
    steps = kn_steps(2, delta=2.0, n0=3)
    assert next(steps) == [(0, 0), (1, 0), (0, 1), (1, 1), (0, 2), (1, 2)]
    # values in that order: the first design 0 each time, the second -1 0 1: too close to call
    assert steps.send([0, -1, 0, 0, 0, 1]) == [(0, 3), (1, 3)]


def test_a_race_ends_before_it_exceeds_its_runs():
    """Three designs, the last clearly worse: 9 runs, then 2 at a time for the other two, which cannot be told apart."""
    table = [[0.0, 1.0, 2.0] * 20, [1.0, 2.0, 0.0] * 20, [-90.0, -91.0, -92.0] * 20]
    for most, each in ((9, 3), (10, 3), (11, 4), (15, 6), (16, 6)):
        selection = kn(lambda design, r: table[design][r], 3, delta=0.5, n0=3, most=most, ahead=2)
        assert selection.samples == (each, each, 3)
        assert not selection.guaranteed


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"k": 1, "delta": 1.0}, "among 1 designs"),
        ({"k": 2, "delta": 1.0, "n0": 1}, "from 1 replications"),
        ({"k": 2, "delta": 0.0}, "indifference zone 0.0"),
        ({"k": 2, "delta": math.nan}, "indifference zone nan"),
        ({"k": 4, "delta": 1.0, "confidence": 0.25}, "more than 1/4"),
        ({"k": 2, "delta": 1.0, "cap": 9}, "at least n0 = 10"),
        ({"k": 2, "delta": 1.0, "ahead": 0}, "ahead >= 1"),
        ({"k": 3, "delta": 1.0, "most": 29}, "29 runs: too few for 3 designs, expected at least 30, 10 for each"),
    ],
)
def test_arguments_out_of_range_are_refused(arguments, message):
    with pytest.raises(StudyError, match=message):
        kn(lambda design, r: 0.0, **arguments)


def test_a_run_without_a_value_is_named():
    with pytest.raises(StudyError, match="design 1, replication 4: nan"):
        kn(lambda design, r: math.nan if (design, r) == (1, 4) else 1.0, 3, delta=1.0)


def test_steps_that_are_sent_too_few_values_complain():
    steps = kn_steps(2, delta=1.0, n0=3)
    next(steps)
    with pytest.raises(StudyError, match="asked for 6 runs, got 5"):
        steps.send([0.0] * 5)


TABLES = st.integers(0, 2**32 - 1).map(
    lambda seed: np.random.default_rng(seed).integers(0, 40, size=(4, 60)).astype(float)
)


@given(TABLES)
def test_looking_for_the_smallest_is_looking_for_the_largest_negative(table):
    up = kn(lambda d, r: table[d, r], 4, delta=5.0, cap=60)
    down = kn(lambda d, r: -table[d, r], 4, delta=5.0, cap=60, maximise=False)
    assert (up.best, up.eliminated_at, up.samples) == (down.best, down.eliminated_at, down.samples)


@given(TABLES, st.integers(2, 30))
def test_running_ahead_changes_the_work_but_not_the_choice(table, ahead):
    one = kn(lambda d, r: table[d, r], 4, delta=5.0, cap=60)
    many = kn(lambda d, r: table[d, r], 4, delta=5.0, cap=60, ahead=ahead)
    assert (one.best, one.eliminated_at, one.means) == (many.best, many.eliminated_at, many.means)
    assert all(a <= b <= 60 for a, b in zip(one.samples, many.samples, strict=True))


@given(TABLES, TABLES)
def test_what_a_replication_adds_to_every_design_alike_does_not_matter(table, common):
    plain = kn(lambda d, r: table[d, r], 4, delta=5.0, cap=60)
    shifted = kn(lambda d, r: table[d, r] + 64 * common[0, r], 4, delta=5.0, cap=60)
    assert plain.eliminated_at == shifted.eliminated_at
    assert plain.best == shifted.best


@given(TABLES)
def test_the_best_is_one_of_those_that_were_not_eliminated(table):
    result = kn(lambda d, r: table[d, r], 4, delta=5.0, cap=60)
    assert result.best in result.survivors
    assert {i for i, at in enumerate(result.eliminated_at) if at is None} == set(result.survivors)


def test_two_designs_that_are_equal_run_by_run_are_told_as_soon_as_one_day_in_ten_would_show():
    """Values vary, and are equal in each run: 33 of each, not a thousand."""
    values = np.random.default_rng(1).normal(50, 8, 1000)
    selection = kn(lambda _, replication: values[replication], 2, 0.5)
    assert (selection.best, selection.within, selection.equal, selection.samples) == (0, (1,), (1,), (33, 33))
    assert selection.guaranteed


def test_a_design_that_differs_on_a_late_day_is_not_taken_for_equal():
    values = np.random.default_rng(1).normal(50, 8, 1000)
    selection = kn(lambda design, replication: values[replication] - 40 * (design and replication == 20), 2, 0.5)
    assert selection.equal == ()
    assert selection.samples[0] > 33
