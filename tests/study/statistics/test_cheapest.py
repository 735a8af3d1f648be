"""The cheapest of designs with two counts, and three: cases worked out by hand, then laws on random surfaces."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.errors import StudyError
from desim_warehouse.outcome.targets import parse_target
from desim_warehouse.study.statistics.cheapest import NOTHING, Earlier, _Proof, cheapest_meeting_steps, scout_steps
from desim_warehouse.study.statistics.judge import Budget, Judge, verdict_steps
from desim_warehouse.study.statistics.procedure import follow
from tests.study.statistics.searches import up_to

GRID = [(robots, chargers) for robots in range(1, 9) for chargers in range(1, 5)]
ENOUGH = parse_target("on_time >= 0.9")


def fewest(design):
    return tuple(map(float, design))


def priced(robot, charger):
    return lambda design: (robot * design[0] + charger * design[1], *map(float, design))


def search(
    mean, cost=fewest, *, noise=0.0, seed=0, designs=GRID, target=ENOUGH, zone=0.01, cap=80, earlier=NOTHING, **options
):
    """Scout and proof of a surface of means with normal noise."""
    rng = np.random.default_rng(seed)

    def sample(number, _):
        return mean(designs[number]) + noise * rng.standard_normal()

    budget = options.pop("budget", Budget(10**6))
    doubted = follow(scout_steps(designs, cost, target, budget, earlier), sample)
    judge = Judge(target, zone=zone, budget=budget, days=up_to(cap), **options)
    steps = cheapest_meeting_steps(designs, cost, judge, doubted, earlier=earlier)
    return follow(steps, sample)


def at_least(robots, chargers):
    """0.95 with so many robots and chargers, 0.5 with less."""
    return lambda design: 0.95 if design[0] >= robots and design[1] >= chargers else 0.5


def test_fewest_robots_then_fewest_chargers():
    outcome = search(at_least(5, 2), noise=0.01)
    assert GRID[outcome.design] == (5, 2)
    # what rules out all smaller ones: a robot less with all chargers there are, a charger less with as many robots
    assert [GRID[number] for number in outcome.below] == [(4, 4), (5, 1)]
    assert [outcome.verdicts[number].verdict for number in (*outcome.below, outcome.design)] == [
        "fails",
        "fails",
        "meets",
    ]
    # only these three are judged, the one named in 33 runs and the others in five; five runs each of (4, 1) and (6, 2)
    # show that four robots do no worse with all chargers, and six robots no worse than five
    assert (len(outcome.verdicts), outcome.runs, outcome.close) == (3, 53, ())


def test_a_robot_more_may_be_cheaper_than_the_chargers_it_saves():
    # 4 robots need 4 chargers, 5 need 2, 6 need 1
    def mean(design):
        return 0.95 if design[1] >= {4: 4, 5: 2}.get(design[0], 1) and design[0] >= 4 else 0.5

    # robots cost 1, chargers 10: 44, 25 and 16
    outcome = search(mean, priced(1, 10), noise=0.01)
    assert GRID[outcome.design] == (6, 1)
    # robots cost 10, chargers 1: 44, 52 and 61
    assert GRID[search(mean, priced(10, 1), noise=0.01).design] == (4, 4)


def test_nothing_is_enough():
    outcome = search(lambda _: 0.5, noise=0.01)
    assert outcome.design is None
    assert [GRID[number] for number in outcome.below] == [(8, 4)]


def test_a_design_within_the_zone_may_be_left_out_and_ends_the_search():
    # 4 robots are 0.004 better than the target, less than matters: looks until the bounds are 0.01 apart
    def mean(design):
        return 0.5 if design[0] < 4 else 0.904 if design[0] == 4 else 0.99

    outcome = search(mean, noise=0.02, seed=4, cap=320)
    (close,) = outcome.close
    assert GRID[outcome.design][0] in {4, 5}
    assert GRID[close][0] == 4
    assert outcome.verdicts[close].within_zone
    assert outcome.verdicts[close].n < 320  # more runs would tell nothing that matters


def test_what_the_runs_do_not_tell_is_said():
    outcome = search(
        lambda design: 0.9 if design[0] == 4 else 0.5 if design[0] < 4 else 0.99, noise=0.05, cap=20, zone=0.0
    )
    assert GRID[outcome.design] == (5, 1)
    assert [GRID[number] for number in outcome.close] == [(4, 4)]


def test_the_budget_is_kept():
    budget = Budget(120)
    outcome = search(at_least(5, 2), noise=0.2, budget=budget)
    assert budget.spent <= 120
    assert outcome.design is None or outcome.close or outcome.open
    with pytest.raises(StudyError, match="the runs allowed ended"):
        search(at_least(5, 2), budget=Budget(3))


def test_what_cannot_last_does_not_meet_the_target():
    numbers = {design: number for number, design in enumerate(GRID)}
    outcome = search(
        lambda design: 0.95 if design[0] >= 5 else 0.5,
        noise=0.01,
        veto=lambda number: "batteries fall" if GRID[number][1] < 3 else None,
    )
    assert GRID[outcome.design] == (5, 3)
    assert outcome.vetoed == {numbers[5, 1]: "batteries fall", numbers[5, 2]: "batteries fall"}


def test_a_fleet_whose_batteries_fall_rules_out_no_smaller_one_on_as_many_chargers():
    """One charger lasts for four robots, which are enough, and for no more; a charger is dear."""
    flat = {n: "batteries fall" for n, (robots, chargers) in enumerate(GRID) if chargers == 1 and robots > 4}
    outcome = search(
        at_least(4, 1),
        priced(1, 3),
        noise=0.01,
        veto=flat.get,
        hopeless=flat.get,
        drains=lambda number: number in flat,
    )
    assert GRID[outcome.design] == (4, 1)
    kept = search(at_least(5, 1), priced(1, 3), noise=0.01, veto=flat.get, hopeless=flat.get, drains=flat.__contains__)
    assert GRID[kept.design] == (5, 2)


def test_a_dearer_fleet_that_meets_the_target_neither_replaces_the_answer_nor_is_judged_for_ever():
    """(7, 1) is at the target, where no run tells; (6, 4), which might rule out fewer robots, is enough, and dearer."""

    def mean(design):
        robots, chargers = design
        return 0.5 if robots < 5 else 0.9 if chargers == 1 else 0.95

    outcome = search(mean, priced(1, 3), noise=0.02, cap=12, seed=1)
    assert GRID[outcome.design] == (5, 2)
    assert outcome.verdicts[GRID.index((7, 1))].verdict == "undecided"
    assert outcome.verdicts[GRID.index((6, 4))].verdict == "meets"


def test_designs_that_are_named_get_their_verdicts():
    judge = follow(
        verdict_steps([3, 7], Judge(ENOUGH)), lambda number, r: (0.95 if number == 7 else 0.5) + 0.001 * (r % 2)
    )
    assert {number: outcome.verdict for number, outcome in judge.verdicts.items()} == {3: "fails", 7: "meets"}


def test_a_design_that_its_first_runs_show_to_be_hopeless_is_not_run_again():
    outcome = search(
        lambda design: 0.95 if design[0] >= 5 else 0.5,
        noise=0.01,
        hopeless=lambda number: "batteries fall" if GRID[number][1] < 3 else None,
    )
    assert GRID[outcome.design] == (5, 3)
    assert {outcome.verdicts[number].n for number in outcome.vetoed} == {3}


def test_a_design_that_is_known_by_its_first_runs_is_not_judged():
    asked = []
    steps = verdict_steps([3, 7], Judge(ENOUGH), lambda number: number == 3)
    judge = follow(steps, lambda number, r: asked.append((number, r)) or 0.5 + 0.001 * (r % 2))
    assert set(judge.verdicts) == {7}
    assert [r for number, r in asked if number == 3] == [0, 1, 2]
    assert [r for number, r in asked if number == 7] == list(range(5))


def closely(mean, doubted):
    """The search on a surface without chance, but for 5 robots and 2 chargers, whose runs tell nothing for long."""
    numbers = {design: number for number, design in enumerate(GRID)}
    judge = Judge(ENOUGH, zone=0.01)
    steps = cheapest_meeting_steps(GRID, fewest, judge, {numbers[design] for design in doubted})
    outcome = follow(
        steps, lambda number, r: mean(GRID[number]) + (0.2 if GRID[number] == (5, 2) else 0.001) * (-1) ** r
    )
    return outcome, {GRID[number]: judge.runs(number) for number in judge.verdicts}


def test_one_that_leans_to_failing_waits_for_the_one_with_all_chargers_which_fails():
    outcome, runs = closely(lambda design: 0.95 if design[0] > 5 else 0.89, [(4, 4), (5, 1)])
    assert GRID[outcome.design] == (6, 1)
    assert [GRID[number] for number in outcome.below] == [(5, 4)]
    assert (runs[5, 2], runs[5, 4], (5, 3) in runs) == (5, 5, False)


def test_one_that_leans_to_failing_waits_for_the_one_with_all_chargers_which_leans_to_meeting():
    outcome, runs = closely(lambda design: 0.95 if design >= (5, 3) else 0.85, [(4, 4), (5, 1)])
    assert GRID[outcome.design] == (5, 3)
    assert [GRID[number] for number in outcome.below] == [(4, 4), (5, 2)]
    assert (runs[5, 4], runs[5, 3], runs[5, 2] > 5) == (5, 33, True)  # a look is enough at the one with all chargers


@given(
    needs=st.lists(st.integers(1, 5), min_size=8, max_size=8),
    robot=st.integers(1, 20),
    charger=st.integers(1, 20),
    by_price=st.booleans(),
)
def test_without_noise_it_is_the_cheapest_of_all_that_meet(needs, robot, charger, by_price):
    """On any surface on which more never does worse: more robots need fewer chargers (5: none will do)."""
    falling = [max(needs[i:]) for i in range(8)]
    cost = priced(robot, charger) if by_price else fewest
    outcome = search(lambda design: 1.0 if design[1] >= falling[design[0] - 1] else 0.0, cost, deterministic=True)
    right = [design for design in GRID if design[1] >= falling[design[0] - 1]]
    assert (None if outcome.design is None else GRID[outcome.design]) == (min(right, key=cost) if right else None)


@pytest.mark.parametrize("trials", [40, *(pytest.param(many, marks=pytest.mark.long) for many in (150, 400))])
def test_its_statement_holds_as_often_as_it_says(trials):
    """Random surfaces: the design named meets the target, no cheaper one is better by the zone; at least 95 %."""
    rng = np.random.default_rng(1)
    held = 0
    for trial in range(trials):
        need, width, share = rng.uniform(1, 8), rng.uniform(0.3, 2), rng.uniform(0, 0.3)

        def mean(design, need=need, width=width, share=share):
            return 1 / (1 + np.exp(-(design[0] - need) / width)) - share / design[1] ** 2

        outcome = search(mean, noise=rng.uniform(0.01, 0.1), seed=trial, cap=2560)
        truth = [mean(design) for design in GRID]
        cheaper = GRID[: outcome.design] if outcome.design is not None else GRID
        meets = outcome.design is None or truth[outcome.design] >= 0.9
        held += meets and all(mean(design) < 0.91 for design in cheaper)
    assert held >= 0.95 * trials - 3 * np.sqrt(trials * 0.05 * 0.95)


def test_where_runs_do_not_tell_of_fleets_those_with_most_chargers_are_judged():
    """Five robots are a little better than the target with any number of chargers, six beat it, four fail."""
    rng = np.random.default_rng(6)
    means = {5: 0.92, 6: 1.5}
    doubted = [number for number, (robots, _) in enumerate(GRID) if robots < 5]
    outcome = follow(
        cheapest_meeting_steps(GRID, fewest, Judge(ENOUGH, zone=0.01), doubted),
        lambda number, _: means.get(GRID[number][0], 0.5 if GRID[number][0] < 5 else 1.5) + 0.2 * rng.standard_normal(),
    )
    judged = {GRID[number]: one.verdict for number, one in outcome.verdicts.items()}
    assert GRID[outcome.design] == (6, 1)
    assert judged == {(5, 4): "undecided", (4, 4): "fails", (6, 1): "meets"}
    assert [GRID[number] for number in outcome.below] == [(4, 4), (5, 4)]


# Where more does worse


def test_a_second_charger_that_does_worse_keeps_no_cheaper_design_from_being_the_answer():
    """A second charger brings a queue, so of the designs with two only the largest is enough."""
    designs = [(first, second) for first in range(1, 6) for second in (1, 2)]
    means = {design: 0.9 + 0.05 * design[0] - 0.2 * (design[1] == 2) + 0.3 * (design == (5, 2)) for design in designs}
    judge = Judge(parse_target("on_time >= 1"), first=4, days=up_to(4), deterministic=True)
    steps = cheapest_meeting_steps(designs, lambda design: (design[1], design[0]), judge)
    outcome = follow(steps, lambda number, _: means[designs[number]])
    assert designs[outcome.design] == (2, 1)
    assert [(designs[one.number], one.worse) for one in outcome.larger] == [((3, 1), False)]


def test_fewer_robots_are_not_ruled_out_by_more_chargers_with_which_they_do_worse():
    """Three robots are enough with one charger only: each further one brings a slot far from the work."""
    designs = [(first, second) for first in range(1, 6) for second in (1, 2, 3)]
    means = {design: 0.81 + 0.05 * design[0] - 0.03 * (design[1] - 1) * (design[0] < 4) for design in designs}
    judge = Judge(parse_target("on_time >= 0.95"), first=4, days=up_to(4), deterministic=True)
    doubted = [number for number, design in enumerate(designs) if means[design[0], 3] < 0.95]  # by a scout
    steps = cheapest_meeting_steps(designs, lambda design: design, judge, doubted)
    outcome = follow(steps, lambda number, _: means[designs[number]])
    assert designs[outcome.design] == (3, 1)
    assert [(designs[one.base], designs[one.number]) for one in outcome.larger if one.worse] == [((3, 1), (3, 3))]


def test_no_comparison_with_a_larger_design_is_made_where_the_runs_end():
    """Two robots are enough; a run of (1, 2) rules out one robot, if (1, 1), in a third run, does no better."""
    designs = [(1, 1), (1, 2), (2, 1), (2, 2)]
    for runs, compared in ((2, 0), (3, 1)):
        judge = Judge(parse_target("on_time >= 1"), first=1, days=up_to(1), deterministic=True, budget=Budget(runs))
        steps = cheapest_meeting_steps(designs, lambda design: design, judge, {0, 1})
        outcome = follow(steps, lambda number, _: float(designs[number][0] == 2))
        assert designs[outcome.design] == (2, 1)
        assert len(outcome.larger) == compared


# Three counts


CUBE = [(a, b, c) for a in range(1, 6) for b in range(1, 4) for c in range(1, 4)]


@given(least=st.lists(st.tuples(st.integers(1, 5), st.integers(1, 3), st.integers(1, 3)), min_size=1, max_size=3))
def test_of_three_counts_it_is_the_cheapest_that_meets_by_any_prices(least):
    """What meets is what has no less than one of some designs, so that more never does worse."""

    def meets(design):
        return any(all(a >= b for a, b in zip(design, one, strict=True)) for one in least)

    for cost in (fewest, lambda design: (3 * design[0] + design[1] + 7 * design[2], *design)):
        outcome = search(lambda design: 1.0 if meets(design) else 0.0, cost, designs=CUBE, deterministic=True)
        assert CUBE[outcome.design] == min(filter(meets, CUBE), key=cost)


def test_what_is_known_to_fail_is_not_judged_again():
    """Two robots with everything failed with less demand; what is enough for more is where the scout ends."""
    numbers = {design: number for number, design in enumerate(GRID)}
    earlier = Earlier(
        frozenset(n for design, n in numbers.items() if design[0] <= 4), frozenset(), numbers[6, 1], compare=False
    )
    asked = []

    def sample(number, r):
        asked.append((GRID[number], r))
        return at_least(5, 2)(GRID[number]) + 0.001 * (-1) ** r

    doubted = follow(scout_steps(GRID, fewest, ENOUGH, Budget(100), earlier), sample)
    outcome = follow(cheapest_meeting_steps(GRID, fewest, Judge(ENOUGH), doubted, earlier=earlier), sample)
    assert GRID[outcome.design] == (5, 2)
    assert {design[0] for design, _ in asked} == {5}
    assert [GRID[number] for number in outcome.below] == [(5, 1)]


def test_batteries_that_fell_with_less_demand_rule_out_no_fewer_robots_on_as_many_chargers():
    """One charger did not last for six robots or more with less demand; today five are enough, and it lasts."""
    flat = frozenset(n for n, (robots, chargers) in enumerate(GRID) if chargers == 1 and robots > 5)
    for drained, cheapest in ((flat, (5, 1)), (frozenset(), (5, 2))):
        earlier = Earlier(flat, compare=False, drained=drained)
        assert GRID[search(at_least(5, 1), noise=0.01, earlier=earlier).design] == cheapest


@pytest.mark.parametrize("mean", [0.92, 0.88])
def test_where_runs_do_not_tell_of_a_fleet_the_cheapest_that_promises_more_is_next(mean):
    """A packer more is clearly enough here, with as many robots and chargers."""
    number = {design: n for n, design in enumerate(CUBE)}
    doubted = [number[design] for design in CUBE if design[0] < 3]
    judge = Judge(ENOUGH, zone=0.01)
    steps = cheapest_meeting_steps(CUBE, fewest, judge, doubted)

    def sample(n, r):
        noise = (0.2 if CUBE[n] == (3, 1, 1) else 0.001) * (-1) ** r
        return (0.5 if CUBE[n][0] < 3 else mean if CUBE[n] == (3, 1, 1) else 0.97) + noise

    outcome = follow(steps, sample)
    assert CUBE[outcome.design] == (3, 1, 2)
    runs = {CUBE[n]: judge.runs(n) for n in judge.verdicts}
    assert runs[3, 3, 3] == 5  # a look at the largest, before those between
    assert judge.verdicts[number[3, 1, 1]].verdict == "undecided"


@pytest.mark.parametrize(("drop", "worse"), [(1.0, False), (3.0, True)])
def test_more_robots_do_worse_only_where_that_is_clear_at_the_level_of_the_search(drop, worse):
    """Five differences around `drop` hundredths, with a standard error of 0.7: t is 1.4 and 4.2, and it takes 3.5."""
    proof = SimpleNamespace(judge=Judge(ENOUGH))
    days = [(0.90, 0.90 + (rank - 2 - drop) / 100) for rank in range(5)]
    outcome = _Proof._held(proof, (1, 0), ENOUGH, 0.0, days, 1.0)
    assert (outcome.difference.mean, outcome.worse) == (pytest.approx(-drop / 100), worse)
