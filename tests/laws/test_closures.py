"""With closures, slow zones and people work ends, too, and nobody enters what is closed.

`python -m tests.laws.test_closures 17` looks at one random model alone.
"""

import sys

import pytest

import desim_warehouse as dw
from tests.auditor import audit
from tests.laws import random_models, test_two_way
from tests.laws.closures import with_closures
from tests.laws.test_random_models import Found, chunks
from tests.laws.test_zones import zoned
from tests.laws.two_way import KINDS

DAILY, LONG = 50, 3000


def closed(number):
    made = random_models.model(number)
    return with_closures(made, number, dw.load(made).fleet.contact)


@pytest.mark.parametrize("numbers", [range(DAILY), *chunks(0, LONG, pytest.mark.long)])
def test_work_ends_and_all_is_counted(numbers):
    """Nothing impossible happens, indicators are those of the log, accounts add up, and Little's law holds."""
    assert Found.of(numbers, closed) == Found()


def test_a_robot_may_turn_off_that_waited_for_a_robot_and_then_for_an_opening():
    """Of the models after the daily ones the first in which one does."""
    assert Found.of([260], closed) == Found()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("first", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(8, 400, 8))])
def test_work_ends_on_two_way_lanes(kind, first):
    for seed in range(first, first + 8):
        run = dw.simulate(dw.load(with_closures(test_two_way.model(kind, seed), f"{kind} {seed}")), seed)
        assert run.kpis["tasks"] == run.model.tasks.goods.random, seed
        assert audit(run) == [], seed


@pytest.mark.parametrize("first", [0, *(pytest.param(first, marks=pytest.mark.long) for first in range(30, 1000, 30))])
def test_zones_and_closures_go_together(first):
    def both(number):
        made = zoned(number)
        return with_closures(made, number, dw.load(made).fleet.contact)

    assert Found.of(range(first, first + 30), both) == Found()


def test_models_are_of_every_kind():
    """Robots do wait for edges and people, meet them, and are slow: else the laws say little."""
    runs = [dw.simulate(dw.load(closed(number)), number) for number in range(40)]
    for name in ("waiting_closed", "waiting_person", "encounters_per_hour", "shared_time"):
        assert sum(run.kpis.get(name, 0) > 0 for run in runs) > 8, name
    assert sum(bool(run.model.traffic.slow) for run in runs) > 15


if __name__ == "__main__":
    print(Found.of([int(sys.argv[1])], closed))  # noqa: T201 - a tool to be read
