"""With zones work ends, too, and no two robots are where one may be, or drive towards each other where none may."""

import pytest

import desim_warehouse as dw
from tests.auditor import audit
from tests.laws import random_models
from tests.laws.test_random_models import Found
from tests.laws.test_two_way import model
from tests.laws.two_way import KINDS
from tests.laws.zones import with_zones


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [*range(6), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(6, 300))])
def test_every_task_ends_on_two_way_lanes_with_zones(kind, seed):
    made, _ = with_zones(model(kind, seed), f"{kind}{seed}")
    run = dw.simulate(dw.load(made), seed)
    assert run.kpis["tasks"] == run.model.tasks.goods.random
    assert audit(run) == []


def zoned(number):
    made = random_models.model(number)
    return with_zones(made, number, dw.load(made).fleet.contact)[0]


@pytest.mark.parametrize("first", [0, *(pytest.param(first, marks=pytest.mark.long) for first in range(30, 1000, 30))])
def test_random_models_with_zones_are_as_sound_as_without(first):
    """Of all layouts, also one-way ones, where rings turn past and through zones of one robot."""
    found = Found.of(range(first, first + 30), zoned)
    assert found.unsound == []
    assert found.miscounted == []
    assert found.unaccounted == []


def test_there_are_zones_of_both_kinds_in_what_is_tried():
    kinds = [with_zones(model(kind, seed), f"{kind}{seed}")[1] for kind in KINDS for seed in range(6)]
    assert sum(one["one-robot"] for one in kinds) > 10
    assert sum(one["one-direction"] for one in kinds) > 10
