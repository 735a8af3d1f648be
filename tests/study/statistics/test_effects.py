"""Which of several changes gains most, and how much: by hand, then how often it is right."""

import numpy as np
import pytest

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics import follow, gains_steps


def days(gains, *, noise=1.0, common=10.0, seed=0):
    """Values of a base (0) and of changes: days differ much, but are the same for all."""
    rng = np.random.default_rng(seed)
    day, own = rng.normal(0, common, 1000), rng.normal(0, noise, (1000, len(gains) + 1))
    return lambda design, r: 100 + day[r] + own[r, design] + (gains[design - 1] if design else 0.0)


def test_the_change_that_gains_most_is_named_with_its_gain():
    found = follow(gains_steps(3, 1.0), days([14, 2, 0]))
    first, second, third = found.gains
    assert found.clear
    assert not found.none
    assert (first.change, {second.change, third.change}) == (1, {2, 3})
    assert first.low < 14 < first.high
    assert first.low > second.high
    # clear at the first look: ten days of the base and of each
    assert (first.n, found.runs) == (10, 40)


def test_where_less_is_better_gains_are_falls():
    found = follow(gains_steps(2, 1.0, maximise=False), days([-14, 2]))
    assert found.gains[0].change == 1
    assert found.gains[0].low < 14 < found.gains[0].high
    assert found.gains[1].mean < 0


def test_those_that_are_behind_drop_out():
    found = follow(gains_steps(3, 0.5, cap=80), days([5, 4.5, -3], noise=2))
    counts = {gain.change: gain.n for gain in found.gains}
    assert counts[3] == 10 < counts[1]


def test_nothing_gains_anything():
    found = follow(gains_steps(3, 3.0), days([0, 0, 0]))
    assert found.none
    assert not found.clear


def test_exact_values_need_one_run():
    found = follow(gains_steps(2, 1.0, deterministic=True), lambda design, _: [100, 105, 103][design])
    assert [(gain.change, gain.mean, gain.low, gain.high, gain.n) for gain in found.gains] == [
        (1, 5, 5, 5, 1),
        (2, 3, 3, 3, 1),
    ]
    assert found.clear


@pytest.mark.parametrize(("changes", "delta"), [(0, 1.0), (2, 0.0)])
def test_arguments_out_of_range_are_refused(changes, delta):
    with pytest.raises(StudyError, match="expected at least one, and a delta above 0"):
        follow(gains_steps(changes, delta), days([1, 1]))


def test_all_intervals_hold_at_once_as_often_as_they_say():
    rng = np.random.default_rng(3)
    held = 0
    for trial in range(400):
        gains = rng.choice([0, 1, 2, 5], 5)
        found = follow(gains_steps(5, 0.5), days(gains, noise=rng.uniform(0.5, 4), seed=trial))
        held += all(gain.low <= gains[gain.change - 1] <= gain.high for gain in found.gains)
    assert held >= 380 - 3 * np.sqrt(400 * 0.05 * 0.95)
