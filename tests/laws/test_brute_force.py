"""The rule against every state that there is, on networks small enough to search them all."""

import math

import pytest

from tests.laws.brute_force import Watched, all_come_home
from tests.laws.two_way import KINDS, Slots


def watched(kind, seed, robots, most=5):
    """The rule's answers in a run with few robots."""
    slots = Slots(kind, seed, trips=6, recalls=False, patience=math.inf, robots=robots)
    slots.guard.__class__ = Watched
    slots.guard.watch(most)
    assert not slots.run().stalled
    return slots.guard


def verdicts(states, most):
    """How many of some states are live, and how many dead; those too large to tell are left out."""
    found = [all_come_home(state) for state in states[:: max(len(states) // most, 1)]]
    return found.count(True), found.count(False)


SEEDS = [*range(3), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(3, 150))]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", SEEDS)
def test_who_gets_a_step_can_still_come_home(kind, seed):
    guard = watched(kind, seed, robots=2 + seed % 4)
    live, dead = verdicts(guard.safe, 25)
    assert dead == 0
    assert live > 0
    assert guard.compared > 0


def refused(kind, seeds):
    """How many of the states that are refused in some runs are live, and how many dead."""
    found = [verdicts(watched(kind, seed, robots=3 + seed % 5, most=6).unsafe, 12) for seed in seeds]
    return tuple(map(sum, zip(*found, strict=True)))


@pytest.mark.parametrize("seeds", [range(50), pytest.param(range(50, 700), marks=pytest.mark.long)])
def test_on_trees_what_is_refused_is_dead(seeds):
    """So nothing is refused there that could have been granted."""
    live, dead = refused("tree", seeds)
    assert live == 0
    assert dead > len(seeds)


@pytest.mark.parametrize("seeds", [range(50), pytest.param(range(50, 700), marks=pytest.mark.long)])
def test_on_two_way_grids_nearly_all_that_is_refused_is_dead(seeds):
    """Few states are live only as a robot in the way goes on a little and is out of it then: 20 of 4,442."""
    live, dead = refused("grid", seeds)
    assert live < 0.05 * dead
    assert dead > len(seeds)


@pytest.mark.parametrize("kind", ["bridges", "ring"])
@pytest.mark.parametrize("seeds", [range(60), pytest.param(range(60, 700), marks=pytest.mark.long)])
def test_beside_one_way_lanes_little_is_refused_needlessly(kind, seeds):
    """Robots make way for others there. Of 700 runs 40 of 3,799 refusals with bridges, 48 of 220 on rings."""
    live, dead = refused(kind, seeds)
    assert live <= {"bridges": 0.05, "ring": 0.5}[kind] * dead
    assert dead > 0


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [*range(2), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(2, 60))])
def test_the_plan_that_is_kept_takes_all_home_after_every_grant_and_change(kind, seed):
    """Of up to 50 robots, with recalls; no state is searched here, each plan is carried out from scratch."""
    slots = Slots(kind, seed)
    slots.guard.__class__ = Watched
    slots.guard.watch(most=0)
    assert not slots.run().stalled
    assert slots.guard.compared > 0
