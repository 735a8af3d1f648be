"""The rule against an exhaustive search of all states, on small networks."""

import math

import pytest

from tests.laws.brute_force import Watched, all_come_home
from tests.laws.two_way import KINDS, Slots


def watched(kind, seed, robots, most=5):
    """Return the guard of a run with few robots, with its answers."""
    slots = Slots(kind, seed, trips=6, recalls=False, patience=math.inf, robots=robots)
    slots.guard.__class__ = Watched
    slots.guard.watch(most)
    assert not slots.run().stalled
    return slots.guard


def verdicts(states, most):
    """Return the numbers of live and of dead states among some states, without those that are too large to search."""
    live = [all_come_home(state) for state in states[:: max(len(states) // most, 1)]]
    return live.count(True), live.count(False)


SEEDS = [*range(3), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(3, 150))]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", SEEDS)
def test_a_robot_that_is_granted_a_step_can_still_come_home(kind, seed):
    guard = watched(kind, seed, robots=2 + seed % 4)
    live, dead = verdicts(guard.safe, 25)
    assert dead == 0
    assert live > 0
    assert guard.compared > 0


def refused(kind, seeds):
    """Return the numbers of live and of dead states that are refused in some runs."""
    counts = [verdicts(watched(kind, seed, robots=3 + seed % 5, most=6).unsafe, 12) for seed in seeds]
    return tuple(map(sum, zip(*counts, strict=True)))


@pytest.mark.parametrize("seeds", [range(20), pytest.param(range(20, 700), marks=pytest.mark.long)])
def test_on_trees_only_dead_states_are_refused(seeds):
    """So the rule refuses no step there that it could grant."""
    live, dead = refused("tree", seeds)
    assert live == 0
    assert dead > len(seeds)


@pytest.mark.parametrize("seeds", [range(20), pytest.param(range(20, 700), marks=pytest.mark.long)])
def test_on_two_way_grids_nearly_all_refused_states_are_dead(seeds):
    """A few states are live, as a robot in the way can drive on a little and out of the way: 20 of 4,442."""
    live, dead = refused("grid", seeds)
    assert live < 0.05 * dead
    assert dead > len(seeds)


@pytest.mark.parametrize("kind", ["bridges", "ring"])
@pytest.mark.parametrize("seeds", [range(20), pytest.param(range(20, 700), marks=pytest.mark.long)])
def test_beside_one_way_lanes_few_steps_are_refused_needlessly(kind, seeds):
    """Robots make way for others there: 40 of 3,799 refusals are needless with bridges, 48 of 220 on rings."""
    live, dead = refused(kind, seeds)
    assert live <= {"bridges": 0.05, "ring": 0.5}[kind] * dead
    assert dead > 0


DEAR = {(0, "bridges"), (0, "tree")}
"""Plans of many robots, with many grants; those of seed 1 are small."""
PLANS = [
    pytest.param(seed, kind, marks=[pytest.mark.long] if seed > 1 or (seed, kind) in DEAR else [])
    for seed in range(60)
    for kind in KINDS
]


@pytest.mark.parametrize(("seed", "kind"), PLANS)
def test_the_plan_takes_all_robots_home_after_every_grant_and_change(kind, seed):
    """Plans of up to 50 robots, with recalls, are carried out move by move, without a search."""
    slots = Slots(kind, seed)
    slots.guard.__class__ = Watched
    slots.guard.watch(most=0)
    assert not slots.run().stalled
    assert slots.guard.compared > 0
