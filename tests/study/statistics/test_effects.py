"""Which of several changes gains most, and how much: by hand, then how often it is right."""

import math

import numpy as np
import pytest

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.effects import gains_steps
from desim_warehouse.study.statistics.procedure import follow


def days(gains, *, noise=1.0, common=10.0, seed=0):
    """Values of a base (0) and of changes: days differ much, but are the same for all."""
    rng = np.random.default_rng(seed)
    day, own = rng.normal(0, common, 1000), rng.normal(0, noise, (1000, len(gains) + 1))
    return lambda design, r: 100 + day[r] + own[r, design] + (gains[design - 1] if design else 0.0)


def test_the_change_that_gains_most_is_named_with_its_gain():
    ranking = follow(gains_steps([1, 1, 1], 1.0), days([14, 2, 0]))
    first, second, third = ranking.gains
    assert ranking.clear
    assert not ranking.none
    assert (first.change, {second.change, third.change}) == (1, {2, 3})
    assert first.low < 14 < first.high
    assert (second.beaten, third.beaten) == (True, True)
    # clear at the first look: five days of the base and of each
    assert (first.n, ranking.runs) == (5, 20)


def test_where_less_is_better_gains_are_falls():
    ranking = follow(gains_steps([1, 1], 1.0, maximise=False), days([-14, 2]))
    assert ranking.gains[0].change == 1
    assert ranking.gains[0].low < 14 < ranking.gains[0].high
    assert ranking.gains[1].mean < 0


def test_those_that_are_behind_drop_out():
    ranking = follow(gains_steps([1, 1, 1], 0.5, cap=80), days([5, 4.5, -3], noise=2))
    counts = {gain.change: gain.n for gain in ranking.gains}
    assert counts[3] < counts[1]


def test_nothing_gains_anything():
    ranking = follow(gains_steps([1, 1, 1], 3.0), days([0, 0, 0]))
    assert ranking.none
    assert not ranking.clear


def test_gains_are_ranked_for_an_equal_dose():
    """Ten for a second server, 5 for a ninth robot: of a tenth more the robots gain 4, the server 1."""
    ranking = follow(gains_steps([0.1, 0.8], 1.0), days([10, 5]))
    assert [gain.change for gain in ranking.gains] == [2, 1]
    assert ranking.clear
    assert ranking.gains[0].each.mean == pytest.approx(0.8 * ranking.gains[0].mean)
    assert ranking.gains[0].low < 5 < ranking.gains[0].high  # as a whole


def test_what_stands_beside_the_contest_is_looked_at_once_and_never_wins():
    ranking = follow(gains_steps([None, 1, 1], 1.0, cap=80), days([50, 5, 4.5], noise=2))
    gain = ranking.gains[-1]
    assert (gain.change, gain.n, gain.competes) == (1, 5, False)
    assert gain.low < 50 < gain.high
    assert ranking.gains[0].change == 2


def test_what_makes_no_difference_has_no_bounds_and_hides_nothing():
    def sample(design, r):
        return 100 + r % 7 + (2 if design == 2 else 0)

    ranking = follow(gains_steps([1, 1], 1.0), sample)
    first, same = ranking.gains
    assert ranking.clear
    assert (first.change, first.mean) == (2, 2)
    assert (same.change, same.same, same.mean, same.n) == (1, True, 0, 5)
    assert math.isnan(same.high)
    assert follow(gains_steps([1], 1.0), lambda _, r: r).none


def test_a_change_that_fails_in_a_run_is_out_and_the_rest_goes_on():
    values = days([9, 4])
    ranking = follow(
        gains_steps([1, 1], 1.0), lambda design, r: math.nan if (design, r) == (1, 3) else values(design, r)
    )
    assert [(gain.change, gain.failed, gain.n) for gain in ranking.gains] == [(2, 0, 5), (1, 1, 5)]
    assert ranking.clear
    assert ranking.failed == 0


def test_where_the_base_fails_nothing_else_is_asked():
    ranking = follow(gains_steps([1, 1], 1.0), lambda design, r: math.nan if not design and r < 2 else 5.0)
    assert (ranking.failed, ranking.base, ranking.gains, ranking.runs) == (2, 5.0, (), 15)


def test_exact_values_need_one_run():
    ranking = follow(gains_steps([1, 1], 1.0, deterministic=True), lambda design, _: [100, 105, 103][design])
    assert [(gain.change, gain.mean, gain.low, gain.high, gain.n) for gain in ranking.gains] == [
        (1, 5, 5, 5, 1),
        (2, 3, 3, 3, 1),
    ]
    assert ranking.clear


@pytest.mark.parametrize(("changes", "delta"), [(0, 1.0), (2, 0.0)])
def test_arguments_out_of_range_are_refused(changes, delta):
    with pytest.raises(StudyError, match="expected at least one, and a delta above 0"):
        follow(gains_steps([1.0] * changes, delta), days([1, 1]))


@pytest.mark.parametrize("trials", [60, pytest.param(400, marks=pytest.mark.long)])
def test_all_intervals_hold_at_once_as_often_as_they_say(trials):
    rng = np.random.default_rng(3)
    held = 0
    for trial in range(trials):
        gains = rng.choice([0, 1, 2, 5], 5)
        ranking = follow(gains_steps([1] * 5, 0.5), days(gains, noise=rng.uniform(0.5, 4), seed=trial))
        held += all(gain.low <= gains[gain.change - 1] <= gain.high for gain in ranking.gains)
    assert held >= 0.95 * trials - 3 * np.sqrt(trials * 0.05 * 0.95)
