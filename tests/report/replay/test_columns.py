"""The replay's columns: what is packed is what is read, in few bytes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.replay.columns import LARGEST, pack, to_bytes, zigzag
from tests.report.replay.unpacked import from_bytes, unpack, unzigzag

numbers = st.lists(
    st.integers(-LARGEST, LARGEST) | st.integers(-3, 3) | st.sampled_from([63, 64, -64, -65, 8191, 8192])
)


@given(numbers)
def test_bytes_are_read_back(values):
    assert from_bytes(to_bytes(values)).tolist() == values


@given(numbers)
def test_zigzag_has_an_inverse_and_keeps_small_numbers_small(values):
    array = np.array(values, dtype=np.int64)
    folded = zigzag(array)
    assert unzigzag(folded).tolist() == values
    assert (folded >= 0).all()
    assert (folded <= 2 * np.abs(array)).all()


@given(st.dictionaries(st.text(min_size=1), numbers, max_size=5))
def test_columns_are_read_back(columns):
    index, text = pack(columns)
    assert {name: values.tolist() for name, values in unpack(index, text).items()} == columns
    assert [count for _, count, _ in index] == [len(values) for values in columns.values()]


def test_numbers_below_64_take_a_byte_each():
    assert len(to_bytes(list(range(-64, 64)))) == 128


def test_a_number_too_large_for_the_page_is_refused():
    with pytest.raises(OverflowError, match="32 bits"):
        to_bytes([LARGEST + 1])
