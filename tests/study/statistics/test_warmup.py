"""Where the warm-up ends by MSER-5 and by Welch's plot: worked by hand, then laws, then what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.warmup import mser, welch

SERIES = st.lists(st.integers(-50, 50), min_size=30, max_size=120)


def batches_of_five(*means):
    """Observations whose batch means are `means`: two below, two above, one on each."""
    return [mean + offset for mean in means for offset in (-2, -1, 0, 1, 2)]


def test_eight_batches_worked_by_hand():
    # batch means 10 5 1 -1 1 -1 1 -1; after d of them, sum of squares minus sum² / left, over left²:
    # d=0: (131 - 225/8) / 64 = 1.607422      d=1: (31 - 25/7) / 49 = 0.559767   d=2: (6 - 0) / 36 = 1/6
    # d=3: (5 - 1/5) / 25 = 0.192             d=4: 4/16 = 0.25                   d=5: (3 - 1/3) / 9 = 0.296296
    # d=6: 2/4 = 0.5                          d=7: 0, an artefact of a single batch and never chosen
    result = mser(batches_of_five(10, 5, 1, -1, 1, -1, 1, -1))
    assert result.statistic == pytest.approx([1.607422, 0.559767, 1 / 6, 0.192, 0.25, 0.296296, 0.5, 0], abs=1e-6)
    assert (result.truncate, result.valid) == (10, True)
    assert result.means == pytest.approx([10, 5, 1, -1, 1, -1, 1, -1])
    assert result.positions.tolist() == [0, 5, 10, 15, 20, 25, 30, 35]


def test_a_cut_at_exactly_half_is_valid_and_leaves_five_batches():
    # 10 batches, the last five 1 -1 1 -1 1: (5 - 1/5) / 25 = 0.192; with one 10 more at least 100/36
    result = mser(batches_of_five(10, 9, 10, 9, 10, 1, -1, 1, -1, 1))
    assert (result.truncate, result.valid) == (25, True)
    # one batch of the start more, and it is behind the half
    assert not mser(batches_of_five(10, 9, 10, 9, 10, 9, 1, -1, 1, -1, 1)).valid


def test_a_series_without_a_trend_keeps_everything():
    result = mser([1.0, -1.0] * 50)
    assert (result.truncate, result.valid) == (0, True)


def test_a_constant_series_keeps_everything_in_spite_of_rounding():
    result = mser([0.1] * 97)
    assert result.truncate == 0
    assert result.statistic.max() < 1e-30


def test_a_run_that_has_not_settled_is_said_to_be_too_short():
    result = mser(np.arange(100.0))
    assert not result.valid
    assert "run longer" in result.note


def test_observations_behind_the_last_full_batch_are_not_used():
    series = batches_of_five(10, 5, 1, -1, 1, -1, 1, -1)
    assert mser([*series, 1e9]).statistic.tolist() == mser(series).statistic.tolist()


def test_replications_are_averaged_first():
    series = np.array(batches_of_five(10, 5, 1, -1, 1, -1, 1, -1), dtype=float)
    noise = np.where(np.arange(series.size) % 3, 7.0, -4.0)
    result = mser([series + noise, series - noise])
    assert result.truncate == 10
    assert result.statistic == pytest.approx(mser(series).statistic)


def test_an_exponential_start_is_cut_near_its_end():
    # a start of 20 exp(-i/20) in unit noise: below the noise from i = 60, below 1 % of it from i = 152
    rng = np.random.default_rng(11)
    i = np.arange(1000)
    result = mser(20 * np.exp(-i / 20) + rng.normal(size=1000))
    assert result.valid
    assert 40 <= result.truncate <= 160


@pytest.mark.parametrize(
    ("values", "batch", "message"),
    [
        ([1.0] * 29, 5, "29 observations: expected at least 6 batches of 5"),
        ([1.0] * 40 + [np.nan], 5, "position 40"),
        ([], 5, "no values"),
    ],
)
def test_series_that_tell_nothing_are_refused(values, batch, message):
    with pytest.raises(StudyError, match=message):
        mser(values, batch)


@given(SERIES)
def test_the_one_pass_sums_equal_the_definition(values):
    result = mser(values)
    y = np.array(values[: len(values) // 5 * 5], dtype=float).reshape(-1, 5).mean(axis=1)
    expected = [((y[d:] - y[d:].mean()) ** 2).sum() / (y.size - d) ** 2 for d in range(y.size)]
    assert result.statistic == pytest.approx(expected, abs=1e-9)
    assert result.truncate % 5 == 0
    assert result.truncate <= len(values) - 25
    assert result.valid == (2 * (result.truncate // 5) <= y.size)


@given(SERIES, st.integers(-20, 20), st.sampled_from([0.25, 2.0, 1024.0]))
def test_the_unit_of_the_indicator_does_not_move_the_cut(values, shift, scale):
    before = mser(values)
    after = mser([scale * (v + shift) for v in values])
    # the cuts may differ only where two are equally good
    assert after.statistic / scale**2 == pytest.approx(before.statistic, abs=1e-9)
    assert before.statistic[after.truncate // 5] == pytest.approx(before.statistic[before.truncate // 5], abs=1e-9)


# Welch's plot


def test_a_moving_average_worked_by_hand():
    """w = 2: the first is itself, the second the mean of three, then of five; the last two have too few behind them."""
    assert welch([10, 4, 1, 3, 2, 0, 4, 1], 2) == pytest.approx([10, 15 / 3, 20 / 5, 10 / 5, 10 / 5, 10 / 5])


def test_replications_are_averaged_before_they_are_smoothed():
    series = np.array([10.0, 4, 1, 3, 2, 0, 4, 1])
    noise = np.where(np.arange(8) % 3, 7.0, -4.0)
    assert welch([series + noise, series - noise], 2) == pytest.approx(welch(series, 2))


@given(SERIES, st.integers(1, 7))
def test_the_running_sums_equal_the_definition(values, w):
    """Law (2015), section 9.5.1."""
    m = len(values)
    expected = [np.mean(values[i - min(i, w) : i + min(i, w) + 1]) for i in range(m - w)]
    assert welch(values, w) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("batch", [0, -5, 2.5, "five", None, True])
def test_a_batch_is_a_number_of_observations(batch):
    with pytest.raises(StudyError, match=f"batch {batch!r}: expected a whole number of observations above 0"):
        mser([1.0] * 40, batch)


@pytest.mark.parametrize("window", [0, 11, 2.5, "a", True])
def test_windows_that_smooth_nothing_or_everything_are_refused(window):
    with pytest.raises(StudyError, match=f"window {window!r}: expected at least 1 and at most a quarter of the 40"):
        welch([1.0] * 40, window)
