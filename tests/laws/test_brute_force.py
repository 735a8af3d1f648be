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


SEEDS = [*range(6), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(6, 150))]


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


@pytest.mark.parametrize("seeds", [range(100), pytest.param(range(100, 700), marks=pytest.mark.long)])
def test_on_trees_what_is_refused_is_dead(seeds):
    """So nothing is refused there that could have been granted."""
    live, dead = refused("tree", seeds)
    assert live == 0
    assert dead > len(seeds)


@pytest.mark.parametrize("seeds", [range(100), pytest.param(range(100, 700), marks=pytest.mark.long)])
def test_on_two_way_grids_nearly_all_that_is_refused_is_dead(seeds):
    """Few states are live only as a robot in the way goes on a little and is out of it then: 20 of 4,442."""
    live, dead = refused("grid", seeds)
    assert live < 0.05 * dead
    assert dead > len(seeds)


def test_on_one_way_rings_more_is_refused_than_must_be():
    """The price of one rule for all: whoever drives round a ring is in the way of all on it."""
    live, dead = refused("ring", range(20))
    assert live > dead
