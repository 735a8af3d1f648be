"""All robots on two-way lanes come home: on networks of every shape, with recalls and changes of routes."""

import pytest

import desim_warehouse as dw
from desim_warehouse.world.traffic.home_plan import HomePlan
from tests.laws.two_way import KINDS, Slots

DAILY = 7
"""Number of networks of each kind that are tested every day."""
DEAR = ("ring", 2)
"""One of 45 robots, left to the long run."""


def all_come_home(kind, seeds):
    for seed in seeds:
        slots = Slots(kind, seed).run()
        assert not slots.stalled, seed
        assert slots.problems == [], seed


@pytest.mark.parametrize("kind", KINDS)
def test_robots_on_two_way_lanes_all_come_home(kind):
    """On networks with 2 to 50 robots; the log is audited too."""
    all_come_home(kind, [seed for seed in range(DAILY) if (kind, seed) != DEAR])


@pytest.mark.long
def test_robots_on_a_crowded_ring_all_come_home():
    kind, seed = DEAR
    all_come_home(kind, [seed])


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("first", range(DAILY, 1290, 25))
def test_robots_on_five_thousand_networks_all_come_home(kind, first):
    all_come_home(kind, range(first, first + 25))


@pytest.mark.parametrize(("kind", "seed"), [("ring", 6), pytest.param("bridges", 28, marks=pytest.mark.long)])
def test_the_first_claim_of_the_plan_must_be_considered_again(kind, seed, monkeypatch):
    """The robot with the first move of the plan may have been refused because of robots that have not moved since."""
    monkeypatch.setattr(HomePlan, "first", lambda _: None)
    assert Slots(kind, seed).run().stalled


@pytest.mark.parametrize("count", [16, pytest.param(40, marks=pytest.mark.long)])
@pytest.mark.parametrize("kind", KINDS)
def test_without_the_rule_most_fleets_are_stuck(kind, count):
    """So the law is not trivial: of fleets of five or more robots, nearly all end face to face (146 of 160)."""
    runs = [Slots(kind, seed, rule="stop", recalls=False, trips=40) for seed in range(count)]
    runs = [run for run in runs if len(run.robots) >= 5]
    stuck = 0
    for run in runs:
        try:
            stuck += run.run().stalled
        except dw.SimulationError:
            stuck += 1
    assert stuck >= 0.7 * len(runs)
