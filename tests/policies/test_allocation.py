"""Allocation by hand and by brute force."""

import math
import random
from itertools import permutations

import pytest

from desim_warehouse.policies.allocation import CostAware, EarliestDue, Hungarian, InOrder, Nearest, NearestAging
from tests.policies.situations import robot, situation, table, task, world_of

NEAR = [[5, 1, 9], [4, 2, 3]]  # robots at a and b, goods 10, 11, 12 at u, v, w


def answers(policy, *args, **more):
    return list(policy.assign(situation(*args, **more)))


def test_in_order_gives_the_first_tasks_to_the_lowest_numbers():
    assert answers(InOrder(), *world_of(NEAR)) == [(0, 10), (1, 11)]


def test_in_order_passes_over_a_robot_that_may_not_take_the_first_task():
    assert answers(InOrder(), *world_of(NEAR), forbidden={(0, 10)}) == [(1, 10)]


def test_nearest_takes_the_nearest_pair_first():
    assert answers(Nearest(), *world_of(NEAR)) == [(0, 11), (1, 12)]


def test_nearest_goes_by_the_time_in_the_direction_of_travel():
    # A one-way ring a > u > b > v > a: from b the good at u is close by as the crow flies, but almost a round away.
    robots, tasks = [robot(0, "b")], [task(10, "u"), task(11, "v")]
    assert answers(Nearest(), robots, tasks, {("b", "u"): 30, ("b", "v"): 10}) == [(0, 11)]


def test_nearest_breaks_ties_by_the_earlier_task_then_the_lower_robot():
    assert answers(Nearest(), *world_of([[1, 1], [1, 1]])) == [(0, 10), (1, 11)]
    assert answers(Nearest(), *world_of([[2, 1], [1, 2]])) == [(1, 10), (0, 11)]


def test_nearest_looks_at_the_first_candidates_only_but_at_one_for_each_robot():
    one = [robot(0, "a")]
    tasks = [task(10, "u"), task(11, "v"), task(12, "w")]
    assert answers(Nearest(candidates=2), one, tasks, table([[9, 8, 1]])) == [(0, 11)]
    assert len(answers(Nearest(candidates=1), *world_of(NEAR))) == 2


def naive(rows, forbidden):
    left = sorted(
        (cost, j, i) for i, row in enumerate(rows) for j, cost in enumerate(row) if (i, 10 + j) not in forbidden
    )
    pairs = []
    while left:
        _, j, i = left[0]
        pairs.append((i, 10 + j))
        left = [item for item in left if item[1] != j and item[2] != i]
    return pairs


@pytest.mark.parametrize("seed", range(30))
def test_nearest_is_greedy_on_the_whole_table(seed):
    rng = random.Random(seed)
    rows = [[rng.randint(1, 9) for _ in range(rng.choice([3, 6]))] for _ in range(1)]
    rows += [[rng.randint(1, 9) for _ in rows[0]] for _ in range(rng.randint(0, 5))]
    forbidden = {(rng.randrange(len(rows)), 10 + rng.randrange(len(rows[0]))) for _ in range(rng.choice([0, 4]))}
    assert answers(Nearest(), *world_of(rows), forbidden=forbidden) == naive(rows, forbidden)


def test_aging_lets_an_old_task_go_first():
    old, new = task(10, "u", release=0.0), task(11, "v", release=90.0)
    times = table([[20, 5]])
    assert answers(NearestAging(aging=0.2), [robot(0, "a")], [old, new], times, time=100) == [(0, 10)]  # 0 < 3
    assert answers(NearestAging(aging=0.1), [robot(0, "a")], [old, new], times, time=100) == [(0, 11)]  # 10 > 4


def test_earliest_due_goes_by_priority_then_due_time_then_list():
    tasks = [task(10, "u"), task(11, "v", due=50.0), task(12, "w", due=40.0), task(13, "x", due=90.0, priority=1)]
    robots = [robot(0, "a"), robot(1, "b"), robot(2, "c"), robot(3, "d")]
    times = table([[1, 1, 1, 9], [1, 1, 1, 5], [1, 1, 1, 7], [1, 1, 1, 8]])
    assert answers(EarliestDue(), robots, tasks, times) == [(1, 13), (0, 12), (2, 11), (3, 10)]


@pytest.mark.parametrize("seed", range(40))
def test_earliest_due_goes_through_all_urgent_tasks_however_many_are_open(seed):
    """The most urgent come first, a few at a time: the rest is looked at only while robots are free."""
    rng = random.Random(seed)
    robots = [robot(number, f"r{number}") for number in range(rng.randint(1, 4))]
    tasks = [
        task(10 + number, f"t{number}", due=rng.choice((None, float(rng.randint(1, 9)))), priority=rng.randint(0, 1))
        for number in range(rng.choice((3, 8, 9, 40)))
    ]
    rows = [[rng.randint(1, 9) for _ in tasks] for _ in robots]
    times = {(one.node, other.edge[0]): rows[one.number][other.number - 10] for one in robots for other in tasks}
    share = rng.choice((0.02, 0.05, 0.1, 1))
    permitted = {(one.number, other.number) for one in robots for other in tasks if rng.random() < share}
    forbidden = {(one.number, other.number) for one in robots for other in tasks} - permitted
    expected, free = [], {one.number for one in robots}
    for one in sorted(tasks, key=lambda one: (-one.priority, math.inf if one.due is None else one.due)):
        able = [number for number in sorted(free) if (number, one.number) in permitted]
        if able:
            nearest = min(able, key=lambda number, one=one: rows[number][one.number - 10])
            free.remove(nearest)
            expected.append((nearest, one.number))
    assert answers(EarliestDue(), robots, tasks, times, forbidden=forbidden) == expected


def cheapest(rows, forbidden):
    """Most pairs, then least cost, over all assignments."""
    robots, tasks = range(len(rows)), range(len(rows[0]))
    best = (0, 0.0)
    for chosen in permutations([*tasks, *[None] * len(rows)], len(rows)):
        pairs = [(i, j) for i, j in zip(robots, chosen, strict=True) if j is not None and (i, 10 + j) not in forbidden]
        best = min(best, (-len(pairs), sum(rows[i][j] for i, j in pairs)))
    return best


@pytest.mark.parametrize("policy", [Hungarian(), CostAware(distance=0, time=1, collisions=0)])
@pytest.mark.parametrize("seed", range(12))
def test_the_assignment_is_the_best_of_all(policy, seed):
    rng = random.Random(seed)
    rows = [[rng.randint(1, 30) for _ in range(rng.choice([2, 4]))]]
    rows += [[rng.randint(1, 30) for _ in rows[0]] for _ in range(rng.randint(0, 3))]
    forbidden = {(rng.randrange(len(rows)), 10 + rng.randrange(len(rows[0]))) for _ in range(rng.choice([0, 3]))}
    pairs = answers(policy, *world_of(rows), forbidden=forbidden)
    assert not set(pairs) & forbidden
    assert (-len(pairs), sum(rows[i][j - 10] for i, j in pairs)) == cheapest(rows, forbidden)


def test_hungarian_beats_nearest_where_the_nearest_pair_costs_the_other_robot_dearly():
    rows = [[1, 2], [2, 50]]
    assert answers(Nearest(), *world_of(rows)) == [(0, 10), (1, 11)]  # 1 + 50
    assert sorted(answers(Hungarian(), *world_of(rows))) == [(0, 11), (1, 10)]  # 2 + 2


def test_cost_aware_weighs_distance_waiting_and_collisions():
    # To u: 10 long, 10 to drive, 3 of waiting and 0.5 collisions to be expected. To v: 12 long and free.
    world = [robot(0, "a")], [task(10, "u"), task(11, "v")], table([[10, 12]])
    seen = {"waits": {("a", "u"): 3.0, ("a", "v"): 0.0}, "collisions": {("a", "u"): 0.5, ("a", "v"): 0.0}}
    assert answers(CostAware(1, 1, 1), *world, **seen) == [(0, 10)]  # 10 + 13 + 0.5 < 24
    assert answers(CostAware(1, 1, 2), *world, **seen) == [(0, 10)]  # 24 = 24: the earlier task
    assert answers(CostAware(1, 1, 4), *world, **seen) == [(0, 11)]  # 25 > 24
    assert answers(CostAware(1, 2, 0), *world, **seen) == [(0, 10)]  # 36 = 36
    assert answers(CostAware(0, 2, 0), *world, **seen) == [(0, 11)]  # 26 > 24


def test_cost_aware_takes_its_weights_from_the_model_unless_told():
    world = [robot(0, "a")], [task(10, "u"), task(11, "v")], table([[10, 12]])
    seen = {"waits": {("a", "u"): 5.0, ("a", "v"): 0.0}, "collisions": {("a", "u"): 0.1, ("a", "v"): 0.0}}
    assert answers(CostAware(), *world, **seen) == [(0, 11)]  # all weights are 1: 10 + 15 + 0.1 > 24
    assert answers(CostAware(time=0), *world, **seen) == [(0, 10)]


@pytest.mark.parametrize("policy", [InOrder(), Nearest(), NearestAging(), EarliestDue(), Hungarian(), CostAware()])
def test_nobody_who_may_not_is_given_anything(policy):
    forbidden = {(i, 10 + j) for i in range(2) for j in range(3)}
    assert answers(policy, *world_of(NEAR), forbidden=forbidden) == []


@pytest.mark.parametrize("policy", [Nearest, NearestAging, EarliestDue, Hungarian, CostAware])
@pytest.mark.parametrize("candidates", [0, -1, 1.5])
def test_candidates_must_be_a_number_of_tasks(policy, candidates):
    with pytest.raises(ValueError, match="candidates"):
        policy(candidates=candidates)
