"""Several targets at once: a design is enough when it meets all, with one budget of error."""

import numpy as np
import pytest

from desim_warehouse.outcome.targets import parse_target
from desim_warehouse.study.statistics.cheapest import cheapest_meeting_steps, scout_steps
from desim_warehouse.study.statistics.judge import Beside, Budget, Judge, judged, on_all
from desim_warehouse.study.statistics.procedure import follow

EXPRESS, REST = parse_target("on_time >= 95 %"), parse_target("cycle_time_mean <= 100")
GRID = [(robots, chargers) for robots in range(1, 7) for chargers in range(1, 4)]


def search(surfaces, goals, *, designs=GRID, noise=0.0, seed=0, **how):
    """The scout and the proof, by a surface of means for each target."""
    rng = np.random.default_rng(seed)
    runs = {}

    def values(number, replication):
        if (number, replication) not in runs:
            means = [surface(designs[number]) for surface in surfaces]
            runs[number, replication] = [mean * (1 + noise * rng.standard_normal()) for mean in means]
        return runs[number, replication]

    def of(place):
        return lambda number, n: [values(number, replication)[place] for replication in range(n)]

    def cost(design):
        return tuple(map(float, design))

    def misses(number):
        return not all(goal.met_by(value) for goal, value in zip(goals, values(number, 0), strict=True))

    beside = [Beside(goal, 0.01 * goal.value, of(place)) for place, goal in enumerate(goals) if place]
    fewer = not all(goal.more_helps for goal in goals)

    def first(number, replication):
        return values(number, replication)[0]

    scout = scout_steps(designs, cost, goals[0], Budget(10**6), hopeless=misses)
    doubted = set() if fewer else follow(scout, first)
    runs.clear()  # those of the scout are others
    judge = Judge(goals[0], zone=0.01, beside=beside, **how)
    return follow(cheapest_meeting_steps(designs, cost, judge, doubted, fewer=fewer), first)


def test_each_target_needs_something_else_and_the_answer_has_both():
    """On time from 3 robots on, fast from 2 chargers on: 3 robots and 2 chargers, by runs with noise."""
    cheapest = search(
        (lambda design: 0.99 if design[0] >= 3 else 0.6, lambda design: 60 if design[1] >= 2 else 160),
        (EXPRESS, REST),
        noise=0.005,
    )
    assert GRID[cheapest.design] == (3, 2)
    assert [one.verdict for one in cheapest.verdicts[cheapest.design].each] == ["meets", "meets"]
    (too_few, too_slow) = (cheapest.verdicts[GRID.index(design)].each for design in ((2, 3), (3, 1)))
    # five runs rule a design out; that it meets the other target is not said after so few
    assert [one.verdict for one in too_few] == ["fails", "undecided"]
    assert [one.verdict for one in too_slow] == ["undecided", "fails"]


def test_the_error_of_a_look_is_shared_by_the_targets():
    """Bonferroni: with two targets each is judged at half of the error that one alone would have."""
    both = search((lambda _: 0.99, lambda _: 60), (EXPRESS, REST), designs=[(1, 1)], noise=0.001)
    alone = search((lambda _: 0.99,), (EXPRESS,), designs=[(1, 1)], noise=0.001)
    assert 1 - both.verdicts[0].level == pytest.approx((1 - alone.verdicts[0].level) / 2)
    assert {one.level for one in both.verdicts[0].each} == {both.verdicts[0].level}


def test_a_mean_known_to_within_the_zone_and_within_it_of_the_target_is_about_at_it():
    """Five values around 103 at a target of 100, known to 4: with a zone of 5 it is close, with one of 3 it is not."""
    target, data = parse_target("throughput_per_hour >= 100"), [103 + 3.2 * step for step in (-2, -1, 0, 1, 2)]
    close, open_ = (judged("", data, target, 0.95, False, target.measure.within, zone) for zone in (5.0, 3.0))
    assert (close.low, close.high) == (pytest.approx(99, abs=1), pytest.approx(107, abs=1))
    assert (close.verdict, close.within_zone) == ("undecided", True)
    assert (open_.verdict, open_.within_zone) == ("undecided", False)


def test_one_missed_target_is_enough_to_fail_and_an_open_one_to_stay_open():
    def verdict(values, goal):
        return judged("", values, goal, 0.95, False, goal.measure.within, 0.001)

    met, missed = verdict([0.99, 0.992, 0.991] * 3, EXPRESS), verdict([150.0, 152.0, 151.0] * 3, REST)
    left = verdict([40.0, 155.0, 110.0], REST)
    assert [one.verdict for one in (met, missed, left)] == ["meets", "fails", "undecided"]
    assert on_all((met, missed)).verdict == on_all((left, missed)).verdict == "fails"
    assert (on_all((met, left)).verdict, on_all((met, met)).verdict) == ("undecided", "meets")
    assert on_all((met, left)).mean == met.mean


def test_a_bound_on_cost_beside_one_on_time_has_the_fleets_between():
    """From 3 robots on time, up to 4 not too far: 3 and 4 are enough, and no bound on either side hides them."""
    near = parse_target("distance <= 900")
    surfaces = (lambda design: 0.99 if design[0] >= 3 else 0.6, lambda design: 500 + 100 * design[0])
    cheapest = search(surfaces, (EXPRESS, near), deterministic=True)
    assert GRID[cheapest.design] == (3, 1)
    nothing = search(surfaces, (EXPRESS, parse_target("distance <= 700")), deterministic=True)
    assert nothing.design is None


def drawn(seed):
    """Two or three targets, and a surface for each, that rises with counts; most are met by some designs, not all."""
    rng = np.random.default_rng(seed)
    goals = (EXPRESS, REST, parse_target("backlog <= 10"))[: 2 + seed % 2]
    surfaces = []
    for goal in goals:
        levels = rng.uniform(0, 1, (6, 3)).cumsum(axis=0).cumsum(axis=1) + 1
        need = np.quantile(levels, rng.uniform(0.2, 0.95)) * (1.3 if seed == 9 else 1)
        reached = (levels / need) ** goal.sign * goal.value
        surfaces.append(lambda design, reached=reached: reached[design[0] - 1, design[1] - 1])
    return goals, surfaces


@pytest.mark.parametrize("seed", range(10))
def test_it_is_the_cheapest_of_all_that_meet_two_or_three_targets(seed):
    goals, surfaces = drawn(seed)
    enough = [
        number
        for number, design in enumerate(GRID)
        if all(goal.met_by(surface(design)) for goal, surface in zip(goals, surfaces, strict=True))
    ]
    cheapest = search(surfaces, goals, deterministic=True)
    assert cheapest.design == min(enough, key=lambda number: GRID[number], default=None)


@pytest.mark.parametrize(("minutes", "forecast"), [(60, "meets"), (100, "undecided"), (160, "fails")])
def test_a_design_is_forecast_to_meet_if_it_is_on_every_target(minutes, forecast):
    """On time is clear after five days that differ by 0.002; the second target decides, or stays open at its bound."""
    seconds = Beside(REST, 1.0, lambda _, n: [minutes + 10 * (-1) ** run for run in range(n)])
    judge = Judge(EXPRESS, zone=0.01, beside=[seconds])
    follow(judge.look(0), lambda _, run: 0.99 + 0.001 * (-1) ** run)
    assert judge.runs(0) == 5
    assert judge.forecast(0) == forecast
