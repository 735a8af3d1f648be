"""The stepped reference against the results of the authors' program, and against cases worked out by hand."""

from dataclasses import replace
from functools import cache

import pytest

import desim_warehouse as dw
from tests.daily import some

from .paper import CELLS, GROUPS, changes
from .stepped import LETTERS, Outcome, Setting, Warehouse, highways, place_of, simulate
from .stops import Watched, unmatched, waits

MULTIBOTS = dw.load("models/multibots.yaml")

# Steps: along a row ceil(150 / 4) = 38, along a column ceil(250 / 4) = 63, and one at the node reached.
ROW, COLUMN = 38 + 1, 63 + 1
OUT, LOAD, UNLOAD, IN = 11, 10, 20 + 3, 1


@cache
def outcome_of(robots, group):
    return simulate(Setting(robots, GROUPS[group]))


@pytest.mark.parametrize("cell", CELLS, ids=lambda cell: f"{cell['robots']:.0f}x{cell['group']:.0f}")
def test_a_cell_of_the_paper(cell):
    """T and C equal the program's to the step; S too, but for one episode more with 6 robots, group 2."""
    robots, group = int(cell["robots"]), int(cell["group"])
    stops = int(cell["S_program"]) + ((robots, group) == (6, 2))
    expected = Outcome(cell["T_steps_program"], stops, int(cell["C_program"]), delivered=10)
    assert outcome_of(robots, group) == expected


@pytest.mark.parametrize("groups", [{1}, pytest.param({*GROUPS}, marks=pytest.mark.long)])
def test_who_goes_first_at_a_tie_matters_in_one_cell(groups):
    """Robots 0 and 2 come to P at the same instant: the other order takes 4 steps more than the program."""
    turned = []
    for cell in CELLS:
        robots, group = int(cell["robots"]), int(cell["group"])
        if group in groups:
            outcome = simulate(Setting(robots, GROUPS[group]), higher_first=False)
            if outcome != outcome_of(robots, group):
                turned.append((robots, group, outcome.T - cell["T_steps_program"]))
    assert turned == [(6, 1, 4)]


def test_the_clock_of_the_figures_shows_a_little_more():
    """A step is 0.05 s; the figures' wall clock shows 0.3 to 1.9 % more."""
    for cell in CELLS:
        outcome = outcome_of(int(cell["robots"]), int(cell["group"]))
        assert 1.003 < cell["T_seconds_figure"] / (outcome.T * 0.05) < 1.019


def test_highways_counts_hops_not_lengths():
    assert highways("A", "O") == list("BCDJPO")
    assert highways("J", "M") == list("PONM")
    assert highways("C", "C") == []


def test_a_good_is_picked_from_the_aisle_beside_it():
    assert place_of(8) == ("M", "G", (25, 325))  # left of block column 0, lower row: M → G goes up
    assert place_of(1) == ("B", "H", (175, 75))  # right: B → H goes down
    assert place_of(79) == ("L", "R", (775, 475))


def test_one_good_step_by_step():
    """Good 1 lies 50 px down B → H: A B, 13 steps to it; the other 200 px to H, on to N and M; home by G."""
    fetch = OUT + ROW + 13 + LOAD
    deliver = (50 + 1) + COLUMN + ROW + UNLOAD
    home = 2 * COLUMN + IN
    assert simulate(Setting(1, (1,))) == Outcome(fetch + deliver + home, S=0, C=0, delivered=1)


def test_a_good_on_an_upward_edge():
    """Good 8 lies 200 px up M → G: A B H N M, 50 steps to it; the other 50 px to G, on by H and N to M."""
    fetch = OUT + ROW + 2 * COLUMN + ROW + 50 + LOAD
    deliver = (13 + 1) + ROW + COLUMN + ROW + UNLOAD
    home = 2 * COLUMN + IN
    assert simulate(Setting(1, (8,))) == Outcome(fetch + deliver + home, S=0, C=0, delivered=1)


def test_two_goods_unloaded_at_another_letter():
    """Good 7 lies 200 px down B → H, good 9 50 px down H → N: unloaded at N, where that edge ends."""
    first = OUT + ROW + 50 + LOAD + (13 + 1) + COLUMN + UNLOAD
    second = ROW + COLUMN + ROW + 13 + LOAD + (50 + 1) + UNLOAD  # N M G H, and down to N
    home = ROW + 2 * COLUMN + IN
    assert simulate(Setting(1, (7, 9), unload_at="N")) == Outcome(first + second + home, S=0, C=0, delivered=2)


def test_a_robot_with_its_good_delivers_before_it_charges():
    """The battery is down to 9.5 after 100 steps, with good 1 on board: the robot delivers it and goes home.

    Home after 378 steps (and one to go in): 1.89 used, so 38 steps of charging, 1 until it takes the next
    good, 2 until it stands at A; from there on as the first time.
    """
    once = simulate(Setting(1, (1,))).T
    assert once == 378 + IN
    twice = 378 + 38 + 1 + 2 + (once - OUT)
    assert simulate(Setting(1, (1, 1), threshold=9.5)) == Outcome(twice, S=0, C=1, delivered=2)


def test_an_empty_robot_gives_its_good_back_and_goes_home():
    """The battery is down to 9.775 after 45 steps, 5 before B: on to B, home by H N M G, 345 steps in all.

    1.725 used: 35 steps of charging, 1 and 2. Now B is reached after 2 + 39 = 41 steps, so good 1 is kept.
    """
    once = simulate(Setting(1, (1,))).T
    home = OUT + ROW + 2 * COLUMN + ROW + 2 * COLUMN
    assert home == 345
    again = home + 35 + 1 + 2 + (once - OUT)
    assert simulate(Setting(1, (1,), threshold=9.775)) == Outcome(again, S=0, C=1, delivered=1)


def test_one_robot_waits_while_another_unloads():
    """Robots 0 and 1 bring goods 1 and 3 to M and unload 40 steps: robot 1 is at M after 188 to 231 steps.

    Robot 0 is 30 px from it after 218 steps: it stops. Robot 1 is over 33 px away when it is 16 px up M → G
    (hypot(30, 16) = 34), in step 231 + 4, and in that step robot 0 goes on: 16 steps lost, one stop.
    """
    alone = simulate(Setting(1, (1,), unload_time=40))
    both = simulate(Setting(2, (1, 3), unload_time=40))
    assert both == Outcome(alone.T + 16, S=1, C=0, delivered=2)


def test_the_seventh_robot_comes_out_when_the_first_has_left_the_letter():
    """Both start at A; robot 0 is over 33 px away after 9 steps, so robot 6 is 9 steps later: one stop."""
    warehouse = Warehouse(Setting(7, (1, 15, 23, 31, 39, 47, 1)))
    first, *_, seventh = warehouse.robots
    while seventh.inside:
        warehouse.step()
    assert warehouse.now == OUT + 9 + 1
    assert first.point == (25 + 9 * 4 + 4, 25)
    assert warehouse.S == 1


@pytest.mark.parametrize("robots", [6, *(pytest.param(robots, marks=pytest.mark.long) for robots in (12, 18))])
@pytest.mark.parametrize("unload_at", some(LETTERS[12:], 2))
def test_every_robot_gets_home(robots, unload_at):
    goods = tuple((7 * k + 3) % 80 for k in range(3 * robots))
    outcome = simulate(Setting(robots, goods, unload_at=unload_at))
    assert outcome.delivered == len(goods)
    assert outcome == simulate(Setting(robots, goods, unload_at=unload_at))


def test_finer_steps_give_the_same_time_and_ever_more_stops():
    """6 robots, group 1: each of seven stops is one here and there. In finer steps one that waits for a robot that
    turns off goes on in jerks: how many stops that is depends on the step, so S has no value without one."""
    expected = Setting(6, GROUPS[1])
    outcomes = {finer: simulate(replace(expected, finer=finer)) for finer in (1, 2, 4, 8)}
    assert [outcomes[finer].S for finer in outcomes] == [7, 19, 31, 55]
    for outcome in outcomes.values():
        assert abs(outcome.T / outcomes[1].T - 1) < 0.002
    run = dw.simulate(MULTIBOTS.replace({"fleet.size": 6, "tasks.goods": list(GROUPS[1]), "log": "all"}))
    assert run.S == 7
    assert unmatched([(run.model, expected)])[1] == (0, 0, 0, 0)


def test_a_robot_right_behind_another_waits_shorter_than_steps_can_tell():
    """Seven robots: the last comes out of A when robot 0 is D ahead, and again stands behind it at B.

    Robot 0 spends 1.5 steps there, and so does robot 6 behind it. In steps robot 6 comes out 36 px behind, as robots
    move by 4, and need not stop.
    """
    setting = Setting(7, (40, 15, 23, 31, 39, 47, 40))
    run = dw.simulate(MULTIBOTS.replace({**changes(setting), "log": "all"}))
    [wait] = [wait for wait in waits(run) if wait.robot == 6 and wait.end < 60 and wait.start > 20]
    assert wait.end - wait.start == 1.5
    reference = Watched(setting)
    reference.run()
    assert not [wait for wait in reference.waits[6] if 20 < wait.start < 60]
