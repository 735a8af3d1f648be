"""The laws of random models hold where goods lie at nodes and tasks have destinations of their own, too."""

from __future__ import annotations

import sys

import pytest

import desim_warehouse as dw
from tests.auditor import audit
from tests.laws import test_two_way
from tests.laws.random_models import model
from tests.laws.test_random_models import Found
from tests.laws.two_way import KINDS
from tests.laws.wider import wider

DAILY, LONG, CHUNK = 40, 2000, 40


def make(number):
    return wider(model(number), number)


@pytest.mark.parametrize(
    "first", [0, *(pytest.param(first, marks=pytest.mark.long) for first in range(CHUNK, LONG, CHUNK))]
)
def test_work_ends_and_all_is_counted(first):
    assert Found.of(range(first, first + CHUNK), make) == Found()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [*range(5), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(5, 400))])
def test_every_task_ends_on_two_way_lanes(kind, seed):
    mapping = wider(test_two_way.model(kind, seed), f"{kind} {seed}")
    run = dw.simulate(dw.load(mapping), seed)
    assert run.kpis["backlog"] == 0
    assert audit(run) == []


if __name__ == "__main__":
    print(Found.of([int(sys.argv[1])], make))  # noqa: T201 - a tool to be read
