"""Main effects and first-order shares from a table of runs: worked by hand, then laws."""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import qmc

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.screening import first_order, main_effects


def grid(function, replications=1):
    """Fleet 2, 4, 6 by two policies, `replications` of each cell."""
    rows = [
        {"fleet.size": fleet, "allocation": policy, "T": function(fleet, policy, r)}
        for fleet in (2, 4, 6)
        for policy in ("fifo", "nearest")
        for r in range(replications)
    ]
    return pd.DataFrame(rows)


def additive(fleet, policy, r):
    return 10.0 * fleet + (8.0 if policy == "nearest" else 0.0)


FACTORS = ["fleet.size", "allocation"]


def test_main_effects_worked_by_hand():
    # T: 20 28 40 48 60 68, grand mean 44; fleets 24 44 64, policies 40 and 48
    result = main_effects(grid(additive), FACTORS, "T")
    assert result.grand_mean == 44.0
    fleet, policy = result.factors
    assert (fleet.factor, fleet.effects, fleet.swing) == ("fleet.size", {2: -20.0, 4: 0.0, 6: 20.0}, 40.0)
    assert (policy.factor, policy.effects, policy.swing) == ("allocation", {"fifo": -4.0, "nearest": 4.0}, 8.0)
    assert policy.runs == {"fifo": 3, "nearest": 3}


def test_the_largest_swing_comes_first_whatever_the_order_asked():
    assert [e.factor for e in main_effects(grid(additive), FACTORS[::-1], "T").factors] == FACTORS


def test_failed_runs_are_left_out_and_counted():
    table = grid(additive)
    table.loc[5, "T"] = math.nan
    result = main_effects(table, FACTORS, "T")
    assert result.left_out == 1
    assert result.grand_mean == pytest.approx((20 + 28 + 40 + 48 + 60) / 5)
    assert first_order(table, FACTORS, "T").left_out == 1


def test_a_continuous_factor_is_cut_into_bins_of_equally_many_runs():
    speeds = np.arange(100) / 100
    table = pd.DataFrame({"speed": speeds, "T": speeds})
    (effect,) = main_effects(table, ["speed"], "T").factors
    assert list(effect.runs.values()) == [20] * 5
    assert list(effect.effects.values()) == pytest.approx([-0.4, -0.2, 0.0, 0.2, 0.4])


def test_shares_on_a_full_grid_worked_by_hand_are_exact():
    # variance of fleets: (400 + 0 + 400)/3 = 800/3, of policies 16; together 848/3, no interaction
    result = first_order(grid(additive), FACTORS, "T")
    assert result.shares == pytest.approx({"fleet.size": 800 / 848, "allocation": 48 / 848})
    assert list(result.shares) == FACTORS
    assert result.rest == pytest.approx(0.0, abs=1e-12)
    assert not result.corrected


def test_pure_interaction_is_all_rest():
    table = grid(lambda fleet, policy, r: float((fleet - 4) * (1 if policy == "fifo" else -1)))
    result = first_order(table, FACTORS, "T")
    assert result.shares == pytest.approx({"fleet.size": 0.0, "allocation": 0.0}, abs=1e-12)
    assert result.rest == pytest.approx(1.0)


def test_replications_are_averaged_unless_told_otherwise():
    table = grid(lambda fleet, policy, r: additive(fleet, policy, r) + (50.0 if r else -50.0), replications=2)
    assert first_order(table, FACTORS, "T").rest == pytest.approx(0.0, abs=1e-12)
    # noise adds a variance of 2500 to 848/3
    noisy = first_order(table, FACTORS, "T", average=False)
    assert noisy.rest == pytest.approx(2500 / (2500 + 848 / 3))


def test_an_indicator_that_does_not_vary_has_no_shares():
    result = first_order(grid(lambda fleet, policy, r: 3.0), FACTORS, "T")
    assert all(math.isnan(share) for share in result.shares.values())


def test_shares_of_scattered_points_are_near_the_truth():
    # y = 3a + b, uniform: variances 9 to 1, so shares 0.9 and 0.1; c does nothing
    rng = np.random.default_rng(3)
    a, b, c = rng.random((3, 600))
    result = first_order(pd.DataFrame({"a": a, "b": b, "c": c, "T": 3 * a + b}), ["c", "b", "a"], "T")
    assert result.corrected
    assert next(iter(result.shares)) == "a"
    assert result.shares == pytest.approx({"a": 0.9, "b": 0.1, "c": 0.0}, abs=0.05)


def test_a_small_design_ranks_waves_right_on_average_and_says_where_it_cannot_tell():
    # Ishigami & Homma (1990): first order .3139 .4424 0; five wide bins made b, two waves long, less than a
    rng = np.random.default_rng(7)
    truth = {"a": 0.3139, "b": 0.4424, "c": 0.0}
    found, covered = [], 0
    for _ in range(20):
        u = math.pi * (2 * qmc.LatinHypercube(3, rng=rng).random(100) - 1)
        y = np.sin(u[:, 0]) * (1 + 0.1 * u[:, 2] ** 4) + 7 * np.sin(u[:, 1]) ** 2
        result = first_order(pd.DataFrame({"a": u[:, 0], "b": u[:, 1], "c": u[:, 2], "T": y}), list("abc"), "T")
        found.append(result.shares)
        covered += sum(low <= truth[name] <= high for name, (low, high) in result.intervals.items())
        assert result.shares["a"] < result.shares["b"] or "which of a and b" in result.warning
    means = {name: np.mean([shares[name] for shares in found]) for name in "ab"}
    assert means == pytest.approx({"a": 0.3139, "b": 0.4424}, abs=0.06)
    assert covered / 60 >= 0.9


def test_the_correction_for_chance_worked_by_hand():
    # means 2, 6, in all 3.6; total 6.76 + 2.56 + .36 + 1.96 + 11.56 = 23.2, inside 2 + 2 = 4, between 19.2;
    # two levels of five runs: chance explains 1 * 4 / (5 - 2) of it
    table = pd.DataFrame({"x": list("aaabb"), "T": [1.0, 2.0, 3.0, 5.0, 7.0]})
    result = first_order(table, ["x"], "T", average=False)
    assert result.corrected
    assert result.shares["x"] == pytest.approx((19.2 - 4 / 3) / 23.2)
    assert result.rest == pytest.approx(1 - (19.2 - 4 / 3) / 23.2)


def test_chance_is_subtracted_from_factors_that_do_nothing():
    # 40 runs in 10 levels of a factor without effect: chance alone would explain 9/39 = 23 %
    rng = np.random.default_rng(5)
    shares = []
    for _ in range(40):
        table = pd.DataFrame({"x": rng.permutation(np.arange(40) % 10), "y": np.arange(40), "T": rng.normal(size=40)})
        shares.append(first_order(table, ["x", "y"], "T").shares["x"])
    assert np.mean(shares) < 0.12


@pytest.mark.parametrize(
    ("factors", "indicator", "message"),
    [
        (["fleet"], "T", r"\['fleet'\].*fleet.size, allocation, T"),
        (["fleet.size"], "S", r"\['S'\]"),
        ([], "T", "no factors: nothing was varied"),
    ],
)
def test_unknown_columns_are_answered_by_the_known_ones(factors, indicator, message):
    with pytest.raises(StudyError, match=message):
        main_effects(grid(additive), factors, indicator)


def test_a_table_of_failed_runs_is_refused():
    table = grid(lambda fleet, policy, r: math.nan)
    with pytest.raises(StudyError, match="no row has a value"):
        first_order(table, FACTORS, "T")


@given(st.lists(st.tuples(st.integers(0, 3), st.sampled_from("ab"), st.integers(-99, 99)), min_size=1, max_size=40))
def test_effects_weighted_by_their_runs_cancel_and_shares_are_shares(rows):
    table = pd.DataFrame(rows, columns=["x", "z", "T"])
    for effect in main_effects(table, ["x", "z"], "T").factors:
        assert sum(effect.runs.values()) == len(rows)
        assert sum(effect.effects[level] * effect.runs[level] for level in effect.runs) == pytest.approx(0, abs=1e-8)
    for share in first_order(table, ["x", "z"], "T").shares.values():
        assert math.isnan(share) or -1e-9 <= share <= 1 + 1e-9
