"""Main effects from a table of runs: worked by hand, then laws."""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.screening import main_effects


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


def test_a_continuous_factor_is_cut_into_bins_of_equally_many_runs():
    speeds = np.arange(100) / 100
    table = pd.DataFrame({"speed": speeds, "T": speeds})
    (effect,) = main_effects(table, ["speed"], "T").factors
    assert list(effect.runs.values()) == [20] * 5
    assert list(effect.effects.values()) == pytest.approx([-0.4, -0.2, 0.0, 0.2, 0.4])


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
        main_effects(table, FACTORS, "T")


@given(st.lists(st.tuples(st.integers(0, 3), st.sampled_from("ab"), st.integers(-99, 99)), min_size=1, max_size=40))
def test_effects_weighted_by_their_runs_cancel(rows):
    table = pd.DataFrame(rows, columns=["x", "z", "T"])
    for effect in main_effects(table, ["x", "z"], "T").factors:
        assert sum(effect.runs.values()) == len(rows)
        assert sum(effect.effects[level] * effect.runs[level] for level in effect.runs) == pytest.approx(0, abs=1e-8)
