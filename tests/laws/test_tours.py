"""Laws that hold with tours, too: in random models by number, 150 of them every day, and 30 with two-way lanes.

`python -m tests.laws.test_tours 17` looks at one alone.
"""

import sys

import pytest

import desim_warehouse as dw
from tests.laws import test_two_way
from tests.laws.random_models import model
from tests.laws.test_random_models import Found, chunks
from tests.laws.tours import with_tours
from tests.laws.two_way import KINDS

DAILY, LONG = 60, 2000


def toured(number):
    return with_tours(model(number), number)


@pytest.mark.parametrize("numbers", [range(DAILY), *chunks(0, LONG, pytest.mark.long)])
def test_work_ends_and_all_is_counted(numbers):
    """Nothing impossible happens, indicators are those of the log, accounts add up, and Little's law holds."""
    assert Found.of(numbers, toured) == Found()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("first", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(8, 400, 8))])
def test_work_ends_on_two_way_lanes(kind, first):
    seeds = range(first, first + 8)
    assert Found.of(seeds, lambda seed: with_tours(test_two_way.model(kind, seed), seed)).unsound == []


def test_models_are_of_every_kind():
    """Tours of every size, by every policy, stops on the way, and stations with one slot: else the laws say little."""
    drawn = [dw.load(toured(number)) for number in range(DAILY)]
    assert {one.policies.batching.name for one in drawn} == {"fixed-size", "time-window", "by-order", "single"}
    assert {one.fleet.robot.capacity for one in drawn} == {2, 3, 4}
    flows = [flow for one in drawn for flow in one.tasks.flows.values()]
    assert sum(bool(flow.via) for flow in flows) > DAILY / 5
    assert sum(one.battery is not None for one in drawn) > DAILY / 3


if __name__ == "__main__":
    print(Found.of([int(sys.argv[1])], toured))  # noqa: T201 - a tool to be read
