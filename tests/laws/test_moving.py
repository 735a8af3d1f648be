"""The laws of random models hold where robots gather speed and brake, and drive at another speed with a load, too.

`python -m tests.laws.test_moving 17` looks at one random model alone.
"""

from __future__ import annotations

import sys

import pytest

import desim_warehouse as dw
from tests.auditor import audit
from tests.laws import test_two_way
from tests.laws.closures import with_closures
from tests.laws.moving import moving
from tests.laws.random_models import model
from tests.laws.test_random_models import Found, chunks
from tests.laws.two_way import KINDS
from tests.laws.wider import wider

DAILY, LONG = 40, 3000
WENT_WRONG = (1213, 2234)
"""Runs that ended while a ring gathered speed: how far its robots had come was wrong."""
ON_ONE_LANE = (("bridges", 19), ("bridges", 286), ("ring", 316))
"""Of robots that started on one lane the one behind had the smaller number."""


def make(number):
    """Every third model is wider, every third has closures, slow zones and people."""
    plain = model(number)
    if number % 3 == 1:
        return moving(wider(plain, number), number)
    if number % 3 == 2:
        return moving(with_closures(plain, number, dw.load(plain).fleet.contact), number)
    return moving(plain, number)


@pytest.mark.parametrize("numbers", [range(DAILY), WENT_WRONG, *chunks(0, LONG, pytest.mark.long)])
def test_work_ends_and_all_is_counted(numbers):
    assert Found.of(numbers, make) == Found()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [*range(6), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(6, 400))])
def test_every_task_ends_on_two_way_lanes(kind, seed):
    every_task_ends(kind, seed)


@pytest.mark.parametrize(("kind", "seed"), ON_ONE_LANE)
def test_every_task_ends_where_robots_start_on_one_lane_in_any_order(kind, seed):
    every_task_ends(kind, seed)


def every_task_ends(kind, seed):
    mapping = moving(test_two_way.model(kind, seed), seed)
    if seed % 3 == 1:
        mapping = wider(mapping, f"{kind} {seed}")
    elif seed % 3 == 2:
        mapping = with_closures(mapping, f"{kind} {seed}")
    run = dw.simulate(dw.load(mapping), seed)
    assert run.kpis["backlog"] == 0
    assert audit(run) == []


def test_rings_turn_and_robots_wait_in_these_models():
    """Else the laws say little."""
    runs = [dw.simulate(dw.load(make(number)), number) for number in range(40)]
    assert sum(run.kpis["rotations"] > 0 for run in runs) >= 3
    assert sum(run.S > 0 for run in runs) > 13


if __name__ == "__main__":
    print(Found.of([int(sys.argv[1])], make))  # noqa: T201 - a tool to be read
