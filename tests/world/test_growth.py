"""Nothing in a run grows much faster than what it is about: benchmarks/growth.py, each part held to its bound."""

import pytest

from benchmarks import growth


@pytest.mark.long
@pytest.mark.parametrize("part", growth.PARTS)
def test_a_unit_costs_about_the_same_at_every_size(part):
    times, exponent = growth.measured(part)
    assert exponent <= growth.PARTS[part].bound, f"{part}: {[f'{1e6 * time:.3g}' for time in times]} microseconds"


def test_the_exponent_is_that_of_the_time_per_unit():
    assert growth.exponent([10, 20, 40], [3.0, 3.0, 3.0]) == pytest.approx(0)
    assert growth.exponent([10, 20, 40], [3.0, 6.0, 12.0]) == pytest.approx(1)
