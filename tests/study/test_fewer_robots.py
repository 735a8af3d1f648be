"""Targets for which fewer robots are better: distance, and shares of idle time."""

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.plan import plan_fleet
from tests.world.test_flows import RING

SEARCH = dw.Search(first=4, cap=24, cache=False, progress=False)
FLOW = {"from": "storage", "to": ["pack"], "due_within": 150, "arrivals": {"poisson": 30}}


@pytest.fixture(scope="module")
def ring():
    """The ring of `test_flows` with an order every two minutes: a robot that comes back drives 80 for each."""
    return dw.load({**RING, "tasks": {**RING["tasks"], "flows": {"out": FLOW}}, "run": {"length": 1800}})


def test_the_fewest_robots_drive_the_least_time_idle(ring):
    """With one robot it is idle for a third of the time, with four robots each for some 80 %."""
    sizes = plan_fleet(ring, "share_idle <= 50 %", robots="1..4", strategies={}, search=SEARCH)
    assert sizes.today.best.robots == 1
    assert sizes.feasible
    assert (sizes.today.below, sizes.today.fewer, sizes.today.against) == ((), True, False)
    assert "never does worse" not in str(sizes.answer)


def test_a_target_that_the_fewest_miss_is_missed_by_all(ring):
    sizes = plan_fleet(ring, "distance <= 100", robots="1..4", strategies={}, search=SEARCH)
    assert sizes.today.best is None
    assert [one.robots for one in sizes.today.below] == [1, 4]
    assert sizes.answer.answer[0].startswith("Today (30 an hour): no fleet is enough. 1 robot: ")


def test_size_knows_it_too(ring):
    study = dw.Study(ring, {"fleet.size": [1, 2, 3, 4]})
    sizing = dw.size(study, "share_idle <= 50 %", search=SEARCH)
    assert (sizing.smallest, [one.value for one in sizing.decisions]) == (1, [1])
