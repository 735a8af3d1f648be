"""Designs against a baseline: worked by hand, then laws, then what is refused."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.comparison import compare, holm, paired
from desim_warehouse.study.statistics.intervals import estimate

P_VALUES = st.lists(st.floats(0, 1), min_size=1, max_size=12)


def test_paired_difference_worked_by_hand():
    # differences 2, 1, 3: mean 2, sd 1, half-width t(2 df, 0.975) / sqrt(3) = 4.302653 / 1.732051
    result = paired([12, 111, 1013], [10, 110, 1010])
    assert (result.mean, result.sd) == (2.0, 1.0)
    assert result.half_width == pytest.approx(2.484138, abs=1e-6)


def test_pairing_removes_what_both_share():
    base = [10, 110, 1010]
    ours = [12, 111, 1013]
    assert paired(ours, base).half_width < 0.01 * estimate(ours).half_width


def test_a_constant_difference_is_exact_in_spite_of_rounding():
    base = [0.1, 0.7, 1e6 / 3]
    result = paired([v + 0.3 for v in base], base, deterministic=True)
    assert result.deterministic
    assert result.mean == pytest.approx(0.3)


def test_differences_that_agree_so_far_are_not_exact():
    # six differences of 5: up to 1 - 0.025^(1/6) = 45.9 % of runs may differ, and be as far on the other side of 0
    base = [10.0, 11, 12, 10, 11, 12]
    (six,) = compare({"now": base, "more": [v + 5 for v in base]}, "now").differences
    assert six.estimate.interval == pytest.approx((5 - 4.593, 5 + 4.593), abs=1e-3)
    # as a sign test: all six on one side by chance in 2 of 64 cases
    assert (six.p_value, six.differs) == (pytest.approx(2 / 64), True)
    (five,) = compare({"now": base[:5], "more": [v + 5 for v in base[:5]]}, "now").differences
    assert (five.p_value, five.differs) == (pytest.approx(2 / 32), False)


def test_a_run_that_differs_may_do_so_by_as_much_as_the_designs_vary():
    # no difference in ten runs of 100 to 200: 30.8 % may differ by 100
    base = [100.0, 200] * 5
    assert paired(base, base).interval == pytest.approx((-30.85, 30.85), abs=0.01)


def test_the_p_value_is_that_of_the_interval_that_just_holds_zero():
    skewed = [0.0, 0, 0, 0, 1, 1, 2, 3, 5, 9]
    (difference,) = compare({"now": [0.0] * 10, "more": skewed}, "now").differences
    low, _ = paired(skewed, [0.0] * 10, 1 - difference.p_value).interval
    assert low == pytest.approx(0.0, abs=1e-9)


def test_two_designs_by_bonferroni_worked_by_hand():
    # two differences: each interval at 97.5 %, t(2 df, 0.9875) = 6.205347, half-width for sd 1: 3.582658.
    # For 2 df the two-sided p-value is 1 - t / sqrt(2 + t²): t = 2 sqrt(3) gives 1 - sqrt(12/14) = 0.074180
    table = {"now": [10, 10, 10], "more": [12, 11, 13], "less": [9, 10, 8]}
    result = compare(table, "now")
    more, less = result.differences
    assert (more.design, more.estimate.mean) == ("more", 2.0)
    assert (less.design, less.estimate.mean) == ("less", -1.0)
    assert more.estimate.half_width == pytest.approx(3.582658, abs=1e-6)
    assert more.p_value == pytest.approx(1 - math.sqrt(12 / 14))
    assert more.p_adjusted == pytest.approx(2 * (1 - math.sqrt(12 / 14)))
    # t = sqrt(3): 1 - sqrt(3/5) = 0.225
    assert less.p_adjusted == pytest.approx(2 * (1 - math.sqrt(3 / 5)))
    assert (more.differs, less.differs) == (False, False)
    assert "Bonferroni" in result.statement
    assert "97.5 %" in result.statement


def test_holms_p_values_are_as_worked_by_hand():
    # sorted .005 .01 .03 .04 times 4 3 2 1 = .02 .03 .06 .04; the last may not be below the one before: .06
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])


def test_hypotheses_without_a_p_value_still_count_in_the_family():
    assert holm([0.01, 0.02], family=4) == pytest.approx([0.04, 0.06])
    table = {"now": [0, 0, 0], "one run": [5], "near": [2, 3, 4]}
    unknown, near = compare(table, "now", method="holm").differences
    assert (unknown.differs, unknown.p_adjusted) == (None, None)
    assert near.p_adjusted == pytest.approx(2 * near.p_value)


def test_holm_tells_what_bonferroni_cannot():
    # p of t = 30 sqrt(3) is 0.00037, of t = 3 sqrt(3) it is 1 - sqrt(27/29) = 0.0351: above half of 5 %
    table = {"now": [0, 0, 0], "far": [29, 30, 31], "near": [2, 3, 4]}
    assert [d.differs for d in compare(table, "now").differences] == [True, False]
    result = compare(table, "now", method="holm")
    assert [d.differs for d in result.differences] == [True, True]
    assert result.differences[1].p_adjusted == pytest.approx(1 - math.sqrt(27 / 29))
    assert "Holm" in result.statement


def test_failed_and_missing_replications_are_left_out_in_pairs_and_counted():
    table = {"now": [10, math.nan, 30, 40], "more": [12, 20, 33]}
    (difference,) = compare(table, "now").differences
    assert (difference.estimate.n, difference.estimate.mean, difference.missing) == (2, 2.5, 2)


def test_deterministic_designs_are_compared_as_exact_numbers():
    table = {"now": [5.0, 5.0], "same": [5.0, 5.0], "better": [6.0, 6.0]}
    same, better = compare(table, "now", deterministic=True).differences
    assert (same.p_value, same.differs, better.p_value, better.differs) == (None, False, None, True)
    assert better.estimate.deterministic


def test_one_replication_tells_nothing_unless_the_model_is_deterministic():
    table = {"now": [5.0], "better": [6.0]}
    (unknown,) = compare(table, "now").differences
    assert (unknown.differs, unknown.p_value, unknown.estimate.half_width) == (None, None, None)
    (exact,) = compare(table, "now", deterministic=True).differences
    assert exact.differs is True


@pytest.mark.parametrize(
    ("table", "baseline", "method", "message"),
    [
        ({"a": [1, 2], "b": [1, 2]}, "c", "holm", "expected one of 'a', 'b'"),
        ({"a": [1, 2], "b": [1, 2]}, "a", "tukey", "bonferroni or holm"),
        ({"a": [1, 2]}, "a", "holm", "nothing to compare"),
        ({"a": [1, math.nan], "b": [math.nan, 1]}, "a", "holm", "'b' has no finished replication in common"),
    ],
)
def test_comparisons_that_cannot_be_made_are_refused(table, baseline, method, message):
    with pytest.raises(StudyError, match=message):
        compare(table, baseline, method)


def test_deterministic_designs_whose_differences_differ_are_a_contradiction():
    with pytest.raises(StudyError, match="gave differences from 0 to 1"):
        paired([1, 2], [1, 1], deterministic=True)


def test_unequal_numbers_of_replications_cannot_be_paired():
    with pytest.raises(StudyError, match="3 replications against 2"):
        paired([1, 2, 3], [1, 2])


@given(P_VALUES)
def test_holm_lies_between_the_raw_p_values_and_bonferroni(p_values):
    for raw, adjusted in zip(p_values, holm(p_values), strict=True):
        assert raw <= adjusted <= min(1.0, len(p_values) * raw)


@given(P_VALUES)
def test_holm_keeps_the_order_of_the_p_values(p_values):
    pairs = sorted(zip(p_values, holm(p_values), strict=True))
    assert [adjusted for _, adjusted in pairs] == sorted(adjusted for _, adjusted in pairs)


@given(st.lists(st.tuples(st.integers(-99, 99), st.integers(-99, 99)), min_size=2, max_size=15))
def test_the_difference_seen_from_the_other_side_is_its_negative(pairs):
    ours, base = zip(*pairs, strict=True)
    there, back = paired(ours, base), paired(base, ours)
    assert there.mean == pytest.approx(-back.mean)
    assert there.half_width == back.half_width


@pytest.mark.parametrize("confidence", [0.0, 1.0, 95.0])
def test_a_confidence_that_is_none_is_refused(confidence):
    with pytest.raises(StudyError, match="confidence"):
        compare({"now": [1.0, 2.0, 4.0], "more": [2.0, 3.0, 3.0]}, "now", confidence=confidence)
