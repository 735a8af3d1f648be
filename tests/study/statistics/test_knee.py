"""The knee of a throughput curve, worked by hand, then laws, then what is refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.errors import StudyError
from desim_warehouse.study.statistics.knee import knee, smallest_within


def test_five_fleets_worked_by_hand():
    # size from 0 to 1: 0 .25 .5 .75 1; output: 0 .5 .875 1 1; above the chord: 0 .25 .375 .25 0.
    # The highest is .375 at 3, and it exceeds one mean step of .25
    result = knee([1, 2, 3, 4, 5], [10, 18, 24, 26, 26])
    assert (result.at, result.output, result.prominence) == (3.0, 24.0, 0.375)
    assert (result.maximum_at, result.maximum) == (4.0, 26.0)


def test_a_corner_is_the_knee():
    sizes = list(range(1, 21))
    assert knee(sizes, [min(s, 7) * 30.0 for s in sizes]).at == 7


def test_sizes_need_not_be_evenly_spaced():
    # size .0 .1 .2 .6 1; output 0 .5 .9 1 1: above 0 .4 .7 .4 0
    result = knee([0, 1, 2, 6, 10], [0, 5, 9, 10, 10])
    assert (result.at, result.prominence) == (2.0, pytest.approx(0.7))


def test_congestion_beyond_the_maximum_does_not_move_the_knee():
    rising = [10, 18, 24, 26, 26, 26]
    jammed = [10, 18, 24, 26, 19, 8]
    sizes = range(1, 7)
    assert knee(sizes, rising).at == knee(sizes, jammed).at == 3
    assert knee(sizes, jammed).maximum_at == 4


@pytest.mark.parametrize("outputs", [[10, 20, 30, 40, 50], [5, 5, 5, 5, 5], [9, 7, 5, 4, 4], [0, 1, 4, 9, 16]])
def test_lines_falls_and_curves_that_steepen_have_no_knee(outputs):
    result = knee([1, 2, 3, 4, 5], outputs)
    assert (result.at, result.output) == (None, None)
    assert result.maximum == max(outputs)


def test_a_stricter_sensitivity_asks_for_a_sharper_knee():
    sizes, outputs = [1, 2, 3, 4, 5], [10, 18, 24, 26, 26]
    assert knee(sizes, outputs, sensitivity=1.4).at == 3  # 1.4 * 0.25 < 0.375
    assert knee(sizes, outputs, sensitivity=1.6).at is None  # 1.6 * 0.25 > 0.375


def test_smallest_within_five_per_cent_of_the_maximum():
    # 95 % of 200 is 190: reached by 191 at 6, missed by 189 at 5
    sizes, outputs = [4, 5, 6, 7, 8], [150, 189, 191, 200, 180]
    assert smallest_within(sizes, outputs) == 6
    assert smallest_within(sizes, outputs, share=0.0) == 7
    assert smallest_within(sizes, outputs, share=0.25) == 4


def test_nothing_achieved_anywhere_is_achieved_by_the_first():
    assert smallest_within([1, 2], [0.0, 0.0]) == 1


@pytest.mark.parametrize(
    ("sizes", "outputs", "message"),
    [
        ([1, 2, 3], [1, 2], "3 sizes with 2 outputs"),
        ([1, 2], [1, 2], "at least 3"),
        ([1, 3, 2], [1, 2, 3], "rising order"),
        ([1, 2, 2], [1, 2, 3], "rising order"),
        ([1, 2, 3], [1, float("nan"), 3], "outputs: not a finite number at position 1"),
    ],
)
def test_curves_that_cannot_be_read_are_refused(sizes, outputs, message):
    with pytest.raises(StudyError, match=message):
        knee(sizes, outputs)


def test_shares_out_of_range_and_negative_outputs_are_refused():
    with pytest.raises(StudyError, match="share 5"):
        smallest_within([1, 2], [1, 2], share=5)
    with pytest.raises(StudyError, match="output -1"):
        smallest_within([1, 2], [-1, 2])


CURVES = st.lists(st.integers(0, 1000), min_size=3, max_size=30)


@given(CURVES, st.sampled_from([0.5, 2.0, 8.0]), st.integers(0, 64))
def test_units_do_not_move_the_knee(outputs, scale, shift):
    sizes = range(1, len(outputs) + 1)
    before = knee(sizes, outputs)
    after = knee([s * scale for s in sizes], [o * scale + shift for o in outputs])
    assert after.prominence == pytest.approx(before.prominence, abs=1e-12)
    assert after.maximum_at == scale * before.maximum_at
    assert (after.at is None) == (before.at is None)


@given(CURVES, st.sampled_from([0.0, 0.05, 0.5]))
def test_the_smallest_within_is_within_and_nothing_smaller_is(outputs, share):
    at = int(smallest_within(range(len(outputs)), outputs, share))
    floor = (1 - share) * max(outputs)
    assert outputs[at] >= floor
    assert all(output < floor for output in outputs[:at])
