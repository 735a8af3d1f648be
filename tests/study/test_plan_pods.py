"""With pods more robots may do worse: a plan says which fleet does most, and searches up to it."""

import math
from statistics import fmean

import pytest

import desim_warehouse as dw
from desim_warehouse.folders import gallery
from desim_warehouse.outcome.targets import parse_target
from desim_warehouse.study.fleet.most import APART, RUNS, most_steps
from desim_warehouse.study.statistics.judge import Budget
from desim_warehouse.study.statistics.procedure import follow

pytestmark = pytest.mark.usefixtures("brief_probes")

HALL = dw.load(gallery()["goods-to-person"])
ALWAYS = {  # as much work as they can do
    "tasks.flows.picks.arrivals": {"saturated": 100},
    "battery": None,
    "layout.stations.picking.places": 9,
    "layout.bays.parking.places": 10,
}
SHORT = {**ALWAYS, "run.length": "20 min"}
AT_LEAST, AT_MOST = parse_target("throughput_per_hour >= 600"), parse_target("cycle_time_mean <= 90")


def most(does, robots=range(1, 41), target=AT_LEAST, zone=5.0, runs=1000):
    """What is found where a fleet does so much; how many runs it took."""
    asked = []

    def sample(rank, run):
        asked.append((rank, run))
        return does(robots[rank])

    budget = Budget(runs)
    best = follow(most_steps(robots, target, zone, budget), sample)
    assert len(asked) == len(set(asked)) == budget.spent
    return best, len(asked)


def test_the_fleet_that_does_most_is_found_between_those_looked_at_first():
    best, runs = most(lambda robots: 650 - abs(robots - 9) * (100 if robots < 9 else 2))
    assert (best.robots, best.mean, best.largest, best.at_largest) == (9, 650, 40, 588)
    assert best.up_to == 11  # beyond the zone of 5 they do worse
    assert runs <= RUNS * 20
    assert (
        most(lambda robots: 650 - abs(robots - 10) * (2 if robots < 10 else 100))[0].robots == 10
    )  # above the 8 of then
    most_of_many, runs = most(lambda robots: -abs(robots - 170), range(1, 401), runs=2 * APART * RUNS)
    assert abs(most_of_many.robots - 170) <= 3


def test_without_runs_nothing_is_said():
    assert most(lambda robots: -robots, runs=10) == (None, 0)


def test_one_fleet_is_no_choice():
    assert most(lambda robots: 600, [7])[0] is None


def test_less_may_be_better():
    best, _ = most(lambda robots: 60 + abs(robots - 5), target=AT_MOST, zone=1.0)
    assert (best.robots, best.mean, best.at_largest) == (5, 60, 95)


@pytest.mark.parametrize("does", [lambda robots: min(robots, 20), lambda robots: 600 - 0.1 * robots])
def test_nothing_is_said_where_the_largest_does_no_worse(does):
    assert most(does)[0] is None


def test_a_fleet_that_fails_does_worst():
    best, _ = most(lambda robots: math.nan if robots < 3 else 500 - robots * 10, range(1, 6))
    assert (best.robots, best.largest) == (3, 5)


@pytest.mark.slow
def test_a_plan_says_where_more_do_worse():
    plan = dw.plan(
        HALL.replace(SHORT),
        "throughput_per_hour >= 600",
        robots=[2, 4, 20],
        strategies={},
        search=dw.Search(first=2, cap=4),
    )
    assert plan.today.best.robots == plan.today.most.robots == plan.today.most.up_to == 4
    assert plan.today.most.largest == 20
    assert "More is not always better here: 4 robots do most, " in plan.answer.answer[0]
    assert plan.answer.promise.endswith("Assumption: a larger fleet never does worse, up to 4 robots.")
    assert plan.today.counts == ((2, 0), (4, 0))
    assert plan.answer.model_dump()["today"]["most"]["robots"] == 4


@pytest.mark.long
def test_single_loads_are_searched_as_ever():
    plan = dw.plan(HALL.replace({**SHORT, "pods": None}), "throughput_per_hour >= 100", robots=[2, 3], strategies={})
    assert plan.today.most is None
    assert plan.answer.promise.endswith("Assumption: a larger fleet never does worse.")


@pytest.mark.long
def test_the_most_is_where_brute_force_has_it():
    plan = dw.plan(HALL.replace(ALWAYS), "throughput_per_hour >= 660", robots="1..20", strategies={})
    means = {}
    for robots in range(1, 21):
        model = HALL.replace({**ALWAYS, "fleet.size": robots})
        means[robots] = fmean(dw.simulate(model, seed).kpis["throughput_per_hour"] for seed in range(1000, 1010))
    assert plan.today.most.robots == max(means, key=means.get)


@pytest.mark.long
def test_the_fleet_of_the_gallery_is_enough_on_twenty_fresh_days_and_one_robot_fewer_is_not():
    plan = dw.plan(HALL, "on_time >= 95 %", strategies={})
    fleets = (plan.today.best.overrides, {**plan.today.best.overrides, "fleet.size": plan.today.best.robots - 1})
    enough, fewer = (
        fmean(dw.simulate(HALL.replace(fleet), seed).kpis["on_time"] for seed in range(1000, 1020)) for fleet in fleets
    )
    assert enough >= 0.95 > fewer
