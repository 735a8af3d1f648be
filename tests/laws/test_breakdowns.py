"""Whatever breaks down is repaired: so work ends, nothing impossible happens, and all time is accounted for.

`python -m tests.laws.test_breakdowns 17` looks at one random model alone.
"""

import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

import desim_warehouse as dw
from tests.accounting import faults
from tests.auditor import audit
from tests.laws import test_two_way
from tests.laws.breakdowns import with_breakdowns
from tests.laws.random_models import model
from tests.laws.test_liveness import relaxed, simulated
from tests.laws.test_random_models import Found, chunks
from tests.laws.tours import with_tours
from tests.laws.two_way import KINDS
from tests.laws.wider import wider
from tests.laws.worlds import models
from tests.laws.zones import with_zones

DAILY, LONG = 60, 2000


def failing(number):
    return with_breakdowns(model(number), number)


@pytest.mark.parametrize("numbers", [range(DAILY), *chunks(0, LONG, pytest.mark.long)])
def test_work_ends_and_all_is_counted(numbers):
    """Nothing impossible happens, indicators are those of the log, accounts add up, and Little's law holds."""
    assert Found.of(numbers, failing) == Found()


def zoned(mapping, number):
    return with_zones(mapping, number, dw.load(mapping).fleet.contact)[0]


@pytest.mark.parametrize("more", [with_tours, wider, zoned])
@pytest.mark.parametrize("first", [0, *(pytest.param(first, marks=pytest.mark.long) for first in range(20, 1000, 20))])
def test_with_all_that_other_models_have(more, first):
    found = Found.of(range(first, first + 20), lambda seed: with_breakdowns(more(model(seed), seed), seed))
    assert found == Found()


@given(models(), st.integers(0, 9))
@relaxed
def test_every_task_ends_on_one_way_floors_of_every_shape(mapping, seed):
    model = dw.load(with_breakdowns(mapping, seed))
    run = simulated(model, seed)
    assert run.kpis["tasks"] == len(model.tasks.goods)
    assert audit(run) == []
    assert faults(run) == []


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [*range(10), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(10, 400))])
def test_every_task_ends_on_two_way_lanes(kind, seed):
    made = with_breakdowns(test_two_way.model(kind, seed), f"{kind} {seed}")
    if seed % 2:
        made, _ = with_zones(made, f"{kind}{seed}")
    run = dw.simulate(dw.load(made), seed)
    assert run.kpis["tasks"] == run.model.tasks.goods.random
    assert audit(run) == []


def test_models_are_of_every_kind():
    """Breakdowns, delays and outages are drawn, and happen: else the laws say little."""
    drawn = [dw.load(failing(number)) for number in range(DAILY)]
    assert sum(one.fleet.breaks_down for one in drawn) > 0.7 * DAILY
    assert sum(one.fleet.robot.delays is not None for one in drawn) > 0.3 * DAILY
    assert sum(any(bay.outages for bay in one.layout.bays.values()) for one in drawn if one.battery) > 0.2 * DAILY
    runs = [dw.simulate(one, number) for number, one in enumerate(drawn[:20])]
    assert sum(run.kpis.get("breakdowns", 0) for run in runs) > 100


if __name__ == "__main__":
    print(Found.of([int(sys.argv[1])], failing))  # noqa: T201 - a tool to be read
