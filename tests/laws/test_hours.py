"""Work ends and all is counted with hours of stations, robots and flows, buffers and tours, one-way and two-way.

`python -m tests.laws.test_hours 17` looks at one alone.
"""

import sys

import pytest

import desim_warehouse as dw
from tests.laws import test_two_way
from tests.laws.hours import with_hours
from tests.laws.random_models import model
from tests.laws.test_random_models import Found, chunks
from tests.laws.tours import with_tours
from tests.laws.two_way import KINDS

DAILY, LONG = 40, 3000


def timed(number):
    """A random model with hours; every other one with tours."""
    made = model(number)
    return with_hours(with_tours(made, number) if number % 2 else made, number)


@pytest.mark.parametrize("numbers", [range(DAILY), *chunks(0, LONG, pytest.mark.long)])
def test_work_ends_and_all_is_counted(numbers):
    """Nothing begins outside its hours, indicators are those of the log, accounts add up, and Little's law holds."""
    assert Found.of(numbers, timed) == Found()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("first", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(8, 400, 8))])
def test_work_ends_on_two_way_lanes(kind, first):
    def make(seed):
        made = test_two_way.model(kind, seed)
        return with_hours(with_tours(made, seed) if seed % 2 else made, f"{kind} {seed}")

    assert Found.of(range(first, first + 8), make).unsound == []


def test_models_are_of_every_kind():
    """Hours of all sorts, pauses, buffers that are full: else the laws say little."""
    drawn = [dw.load(timed(number)) for number in range(DAILY)]
    stations = [station for one in drawn for station in one.layout.stations.values()]
    assert sum(station.hours is not None for station in stations) > DAILY / 3
    assert sum(station.at_close == "pause" for station in stations) > DAILY / 6
    assert sum(station.buffer is not None for station in stations) > DAILY / 6
    assert sum(one.fleet.has_hours for one in drawn) > DAILY / 3
    assert sum(flow.hours is not None for one in drawn for flow in one.tasks.flows.values()) > 5
    assert sum(one.battery is not None for one in drawn) > DAILY / 3


if __name__ == "__main__":
    print(Found.of([int(sys.argv[1])], timed))  # noqa: T201 - a tool to be read
