"""On two-way lanes robots all come home: networks of every shape, robots that are recalled, routes that change."""

import pytest

import desim_warehouse as dw
from desim_warehouse.world.traffic.home_plan import HomePlan
from tests.laws.two_way import KINDS, Slots

DAILY = 7
"""Networks of each kind that are looked at every day."""


def all_come_home(kind, seeds):
    for seed in seeds:
        slots = Slots(kind, seed).run()
        assert not slots.stalled, seed
        assert slots.problems == [], seed


@pytest.mark.parametrize("kind", KINDS)
def test_robots_on_two_way_lanes_all_come_home(kind):
    """Networks with 2 to 50 robots; what happened is held against the log, too."""
    all_come_home(kind, range(DAILY))


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("first", range(DAILY, 1290, 25))
def test_robots_on_five_thousand_networks_all_come_home(kind, first):
    all_come_home(kind, range(first, first + 25))


@pytest.mark.parametrize(("kind", "seed"), [("ring", 6), ("bridges", 28)])
def test_the_claim_that_the_plan_begins_with_must_be_looked_at_again(kind, seed, monkeypatch):
    """Those whose moves come first by the plan may have been refused for robots that have not moved since."""
    monkeypatch.setattr(HomePlan, "first", lambda _: None)
    assert Slots(kind, seed).run().stalled


@pytest.mark.parametrize("kind", KINDS)
def test_without_the_rule_they_are_stuck(kind):
    """So the law says something: of fleets of five and more nearly all end face to face (146 of 160)."""
    runs = [Slots(kind, seed, rule="stop", recalls=False, trips=40) for seed in range(40)]
    runs = [run for run in runs if len(run.robots) >= 5]
    stuck = 0
    for run in runs:
        try:
            stuck += run.run().stalled
        except dw.SimulationError:
            stuck += 1
    assert stuck >= 0.7 * len(runs)
