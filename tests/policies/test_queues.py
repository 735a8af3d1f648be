"""Queues by insertion against exhaustive search on up to six tasks."""

import functools
import operator
import random
import statistics
from itertools import permutations, product

import pytest

from desim_warehouse.policies.queues import Auction, QueuePlan, Regret
from tests.policies.situations import robot, situation, task

PLACES = "uvwxyz"


def instance(seed, robots, tasks):
    """Robots and goods at random places of a square with one station; times are distances."""
    rng = random.Random(seed)
    at = {name: (rng.uniform(0, 100), rng.uniform(0, 100)) for name in "abc"[:robots] + PLACES[:tasks] + "S"}
    at |= {name + "'": at[name] for name in PLACES[:tasks]}

    def far(one, other):
        return abs(at[one][0] - at[other][0]) + abs(at[one][1] - at[other][1])

    times = {(one, other): far(one, other) for one in at for other in at}
    return situation([robot(i, "abc"[i]) for i in range(robots)], [task(i, PLACES[i]) for i in range(tasks)], times)


def length(given, start, queue):
    time, here = 0.0, start
    for number in queue:
        place = PLACES[number]
        time += given.travel.time(here, place) + given.travel.time(place, "S") + 3
        here = "S"
    return time


def best(given, objective):
    """The least makespan or total over all ways to deal the tasks out and to order them."""
    robots, tasks = len(given.robots), len(given.tasks)
    least = float("inf")
    for owners in product(range(robots), repeat=tasks):
        lengths = []
        for i in range(robots):
            mine = [j for j in range(tasks) if owners[j] == i]
            lengths.append(min(length(given, "abc"[i], order) for order in permutations(mine)))
        least = min(least, objective(lengths))
    return least


def planned(policy, given):
    plan = QueuePlan(given, given.robots, list(given.tasks), 6, policy.objective)
    while (choice := policy.choose(plan.bids)) is not None:
        plan.insert(*choice)
    queues = [[item.number for item in plan.queue(i)] for i in range(len(given.robots))]
    assert sorted(functools.reduce(operator.iadd, queues, [])) == list(range(len(given.tasks)))
    lengths = [length(given, "abc"[i], queue) for i, queue in enumerate(queues)]
    assert lengths == pytest.approx([plan.length(i, plan.queues[i]) for i in range(len(queues))])
    return lengths


@pytest.mark.parametrize("policy", [Regret, Auction])
@pytest.mark.parametrize(("objective", "measure", "limit"), [("total", sum, 0.02), ("makespan", max, 0.2)])
def test_plans_are_close_to_the_best_of_all(policy, objective, measure, limit, record_property):
    gaps = []
    for seed in range(25):
        given = instance(seed, 2 + seed % 2, 4 + seed % 2)
        least = best(given, measure)
        gaps.append(measure(planned(policy(objective=objective), given)) / least - 1)
        assert gaps[-1] > -1e-9
    record_property("mean gap to the optimum", statistics.fmean(gaps))
    assert statistics.fmean(gaps) < limit


def test_one_robot_with_six_tasks_plans_the_best_order_but_for_the_first_task():
    given = instance(1, 1, 6)
    for policy in (Regret(objective="total"), Auction(objective="total")):
        assert planned(policy, given)[0] == pytest.approx(best(given, sum))


def test_regret_serves_first_who_would_lose_most():
    # Robot a is near both goods, robot b is near u only: v has the larger regret and goes to a, u to b.
    times = {("a", "u"): 1, ("a", "v"): 2, ("b", "u"): 2, ("b", "v"): 90}
    times |= {("u'", "S"): 5, ("v'", "S"): 5, ("S", "u"): 5, ("S", "v"): 5}
    given = situation([robot(0, "a"), robot(1, "b")], [task(0, "u"), task(1, "v")], times)
    assert sorted(Regret(depth=1).assign(given)) == [(0, 1), (1, 0)]
    assert sorted(Auction(depth=1).assign(given)) == [(0, 0), (1, 1)]


def test_a_task_waits_for_a_busy_robot_that_will_soon_be_near_it():
    times = {("a", "u"): 100, ("b", "u"): 1, ("u'", "S"): 5, ("S", "u"): 5}
    busy = robot(1, "b", free=False, free_in=10.0)
    given = situation([robot(0, "a")], [task(0, "u")], times, busy=[busy])
    assert list(Auction().assign(given)) == []
    later = robot(1, "b", free=False, free_in=100.0)
    assert list(Auction().assign(situation([robot(0, "a")], [task(0, "u")], times, busy=[later]))) == [(0, 0)]


def test_whole_queues_are_given_out_where_that_is_wanted():
    given = instance(4, 1, 3)
    assert len(list(Auction().assign(given))) == 1
    assert sorted(Auction(commit=True).assign(given)) == [(0, 0), (0, 1), (0, 2)]


def test_a_queue_takes_as_long_on_every_version_of_python():
    """Ten deliveries of 3.1 s, 3 of them at both ends, take 31 s: `sum` has 31.000000000000007 before Python 3.12."""
    robots, tasks = [robot(0, "a")], [task(number, "u") for number in range(10)]
    times = {("a", "u"): 0.0, ("u'", "S"): 0.1, ("S", "u"): 0.0}
    assert QueuePlan(situation(robots, tasks, times), robots, tasks, 10, "total").length(0, range(10)) == 31.0


@pytest.mark.parametrize("wrong", [{"depth": 0}, {"objective": "cost"}, {"robots": 0}, {"candidates": 1.5}])
def test_parameters_are_checked(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Regret(**wrong)
