"""With everything on at once work ends, nothing impossible happens, and all is counted.

Tours, opening hours and buffers, breakdowns, outages and delays, closures, slow zones and people, robots that gather
speed, kinds that charge apart: one-way and two-way. `python -m tests.laws.test_everything 17` looks at one model alone.
"""

import sys

import pytest

import desim_warehouse as dw
from tests.laws import test_two_way
from tests.laws.breakdowns import with_breakdowns
from tests.laws.closures import with_closures
from tests.laws.hours import with_hours
from tests.laws.kinds import with_kinds
from tests.laws.moving import moving
from tests.laws.random_models import model
from tests.laws.test_random_models import Found, chunks
from tests.laws.tours import with_tours
from tests.laws.two_way import KINDS

DAILY, LONG = 40, 3000
WENT_WRONG = (287, 572, 701)
"""Robots cleared off a lane on which people are, recalled as they were let in, in a ring that looked ahead."""


def with_everything(mapping, number):
    mapping = with_tours(with_kinds(mapping, number), number)
    mapping = with_closures(mapping, number, dw.load(mapping).fleet.contact)
    return with_breakdowns(moving(with_hours(mapping, number), number), number)


def make(number):
    return with_everything(model(number), number)


@pytest.mark.parametrize("numbers", [range(DAILY), WENT_WRONG, *chunks(0, LONG, pytest.mark.long)])
def test_work_ends_and_all_is_counted(numbers):
    assert Found.of(numbers, make) == Found()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("first", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(6, 300, 6))])
def test_work_ends_on_two_way_lanes(kind, first):
    found = Found.of(range(first, first + 6), lambda seed: with_everything(test_two_way.model(kind, seed), seed))
    assert found == Found()


if __name__ == "__main__":
    print(Found.of([int(sys.argv[1])], make))  # noqa: T201 - a tool to be read
