"""The laws of random models hold where robots gather speed and brake, and drive at another speed with a load, too."""

from __future__ import annotations

import sys

import pytest

import desim_warehouse as dw
from tests.auditor import audit
from tests.laws import test_two_way
from tests.laws.moving import moving
from tests.laws.random_models import model
from tests.laws.test_random_models import Found
from tests.laws.two_way import KINDS
from tests.laws.wider import wider

DAILY, LONG, CHUNK = 80, 3000, 40


def make(number):
    plain = model(number)
    return moving(wider(plain, number) if number % 2 else plain, number)


@pytest.mark.parametrize(
    "first",
    [
        *range(0, DAILY, CHUNK),
        *(pytest.param(first, marks=pytest.mark.long) for first in range(DAILY, LONG, CHUNK)),
    ],
)
def test_work_ends_and_all_is_counted(first):
    seen = Found()
    for number in range(first, first + CHUNK):
        seen.look_at(number, make)
    assert seen == Found()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [*range(5), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(5, 400))])
def test_every_task_ends_on_two_way_lanes(kind, seed):
    mapping = moving(test_two_way.model(kind, seed), seed)
    run = dw.simulate(dw.load(wider(mapping, f"{kind} {seed}") if seed % 2 else mapping), seed)
    assert run.kpis["backlog"] == 0
    assert audit(run) == []


def test_rings_turn_and_robots_wait_in_these_models():
    """Else the laws say little."""
    runs = [dw.simulate(dw.load(make(number)), number) for number in range(CHUNK)]
    assert sum(run.kpis["rotations"] > 0 for run in runs) >= 3
    assert sum(run.S > 0 for run in runs) > CHUNK / 3


if __name__ == "__main__":
    alone = Found()
    alone.look_at(int(sys.argv[1]), make)
    print(*alone.unsound, *alone.miscounted, *alone.unaccounted, sep="\n")  # noqa: T201 - a tool to be read
