"""How many replications: predicted from a pilot, and as a rule that goes on until it is met."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.intervals import estimate
from desim_warehouse.study.statistics.precision import PrecisionRule, replications_needed, replications_to_run


def test_replications_needed_worked_by_hand():
    # mean 10, sd 2, wanted half-width 1: t(16) * 2 / sqrt(17) = 2.1199 * 0.48507 = 1.0283, not enough;
    # t(17) * 2 / sqrt(18) = 2.1098 * 0.47140 = 0.9946, enough
    assert replications_needed([8, 10, 12], relative=0.10) == 18
    assert replications_needed([-8, -10, -12], relative=0.10) == 18


def test_a_pilot_that_is_precise_enough_needs_no_more():
    assert replications_needed([8, 10, 12], relative=0.50) == 3


def test_none_where_the_cap_or_a_zero_mean_forbids():
    assert replications_needed([8, 10, 12], relative=0.10, cap=17) is None
    assert replications_needed([-1.0, 1.0], relative=0.10) is None
    assert replications_needed([5.0], relative=0.10) is None


def test_values_that_agree_tell_nothing_about_the_number_needed():
    assert replications_needed([5.0, 5.0], relative=0.01) is None


def test_the_first_batch_is_the_minimum():
    rule = PrecisionRule(0.10, minimum=4, cap=20)
    assert replications_to_run([], rule) == 4
    assert replications_to_run([9.0], rule) == 3


def test_the_next_batch_is_the_shortfall_but_at_most_doubles():
    # 18 are predicted (above): 15 more, but 3 replications are at most doubled
    rule = PrecisionRule(0.10, minimum=3, cap=100)
    assert replications_to_run([8, 10, 12], rule) == 3
    # nine values, sd sqrt(24/8) = 1.732: t(13) * 1.732 / sqrt(14) = 1.0001, t(14) * 1.732 / sqrt(15) = 0.959
    assert replications_to_run([8, 10, 12] * 3, rule) == 15 - 9


def test_the_cap_ends_it_unreached():
    assert replications_to_run([8, 10, 12], PrecisionRule(0.10, minimum=2, cap=3)) == 0
    assert replications_to_run([-1, 1], PrecisionRule(0.1, minimum=2, cap=2)) == 0


def test_a_deterministic_model_is_done_at_the_minimum():
    assert replications_to_run([5.0, 5.0], PrecisionRule(0.01, minimum=2), deterministic=True) == 0


def test_values_that_agree_are_precise_to_5_per_cent_after_72():
    # 1 - 0.025^(1/72) = 0.0499: so many runs may differ, by as much as the mean
    rule = PrecisionRule(0.05, minimum=2)
    assert replications_to_run([5.0, 5.0], rule) == 2
    assert replications_to_run([5.0] * 71, rule) > 0
    assert replications_to_run([5.0] * 72, rule) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"relative": 5}, "share between 0 and 1"),
        ({"relative": 0.05, "minimum": 1}, "minimum <= cap"),
        ({"relative": 0.05, "minimum": 20, "cap": 10}, "minimum <= cap"),
        ({"relative": 0.05, "confidence": 95}, "did you mean 0.95"),
    ],
)
def test_rules_that_make_no_sense_are_refused(arguments, message):
    with pytest.raises(StudyError, match=message):
        PrecisionRule(**arguments)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.02, 0.05, 0.2]), st.integers(2, 12))
def test_following_the_rule_ends_within_the_cap_and_keeps_its_promise(seed, relative, minimum):
    values = np.random.default_rng(seed).normal(10.0, 2.0, 150)
    rule = PrecisionRule(relative, minimum=minimum, cap=150)
    n = 0
    while more := replications_to_run(values[:n], rule):
        n += more
    assert minimum <= n <= 150
    assert estimate(values[:n]).half_width <= relative * abs(values[:n].mean()) or n == 150
