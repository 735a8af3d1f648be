"""Which way a target moves with robots is a guess: searches begin from it, and look at both ends of the range."""

import pytest

from desim_warehouse.outcome.indicators import INDICATORS
from desim_warehouse.outcome.targets import parse_target
from desim_warehouse.study.statistics.cheapest import cheapest_meeting_steps
from desim_warehouse.study.statistics.judge import Judge
from desim_warehouse.study.statistics.procedure import follow
from tests.study.statistics.searches import line

GRID = [(robots, chargers) for robots in range(1, 7) for chargers in range(1, 3)]
SHORT = parse_target("distance <= 900")


def search(mean, *, designs=GRID, target=SHORT, doubted=(), veto=lambda _: False):
    """The search with exact runs; designs that `veto` names cannot last."""
    judge = Judge(target, deterministic=True, veto=lambda number: "overloaded" if veto(designs[number]) else None)
    fewer = not target.more_helps
    return follow(
        cheapest_meeting_steps(designs, lambda design: tuple(map(float, design)), judge, doubted, fewer=fewer),
        lambda number, _: mean(designs[number]),
    )


@pytest.mark.parametrize(
    ("text", "helps"),
    [
        ("on_time >= 95 %", True),
        ("cycle_time_p95 <= 5 min", True),
        ("throughput_per_hour >= 90", True),
        ("robots_busy@11:30-13:00 <= 85 %", True),
        ("charger_utilisation <= 80 %", True),  # neither way: as people expect of more
        ("distance <= 900", False),
        ("energy <= 900", False),
        ("annual_cost <= 255000", False),
        ("share_idle <= 25 %", False),
        ("share_waiting <= 5 %", False),
        ("S <= 20", False),
        ("share_empty <= 20 %", True),
    ],
)
def test_targets_say_whether_more_robots_are_guessed_to_help(text, helps):
    assert parse_target(text).more_helps == helps


def test_what_is_better_for_a_fleet_by_itself_says_nothing_of_its_size():
    assert INDICATORS["charger_utilisation"].with_robots is None
    assert {INDICATORS[name].with_robots for name in ("on_time", "S", "distance")} == {"rises"}


def test_where_fewer_robots_are_better_one_is_enough_and_nothing_else_is_judged():
    cheapest = search(lambda design: 700 + 100 * design[0])
    assert GRID[cheapest.design] == (1, 1)
    assert (cheapest.runs, cheapest.below, cheapest.against) == (1, (), False)


def test_the_fewest_that_can_last_are_named_where_fewer_are_better():
    cheapest = search(lambda design: 500 + 100 * design[0], veto=lambda design: design[0] < 3)
    assert GRID[cheapest.design] == (3, 1)
    # each of the smaller ones cannot last, and none of them says anything of larger ones
    assert [GRID[number] for number in cheapest.below] == [(1, 1), (1, 2), (2, 1), (2, 2)]


def test_none_is_enough_where_the_smallest_that_can_last_is_not_and_the_largest_neither():
    cheapest = search(lambda design: 1000 + 100 * design[0], veto=lambda design: design[0] < 3)
    assert cheapest.design is None
    # of fleets beyond 3 robots only the largest is judged, as those between are no better by the guess
    assert [GRID[number] for number in cheapest.below] == [(1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (6, 2)]


def test_where_the_ends_contradict_that_fewer_are_better_all_are_judged_one_by_one():
    """From five robots on they drive less, as if parked nearer: the cheapest of those is named."""
    cheapest = search(lambda design: 800 if design[0] >= 5 else 1000)
    assert GRID[cheapest.design] == (5, 1)
    assert cheapest.against
    assert len(cheapest.verdicts) == 10  # all up to it, and the largest


def test_robots_in_a_jam_where_more_usually_help():
    """Two robots are enough, three and more stand in each other's way; a scout doubted all of them."""
    designs, on_time = line(8), parse_target("on_time >= 90 %")
    cheapest = search(lambda design: 0.95 if design[0] == 0 else 0.5, designs=designs, target=on_time, doubted=range(8))
    assert (cheapest.design, cheapest.against) == (0, True)
    assert set(cheapest.verdicts) == {7, 0}  # both ends; the largest against half of it is compared, not judged
