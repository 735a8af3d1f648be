"""Pick-assist in wide aisles beside a program without lanes: with pickers scarce, and with pickers to spare."""

from statistics import fmean

import pytest

import desim_warehouse as dw
from tests.reference.on_foot import Hall
from tests.world.pick_assist import hall

HALL = hall(8, 40, {"at": ["r2c3", "r2c5"], "places": 20}, 60, {"length": 7200, "warm_up": 900})
SETTINGS = [(robots, pickers) for robots in (6, 12, 18, 24) for pickers in (3, 6, 9)]


@pytest.mark.long
@pytest.mark.parametrize(("robots", "pickers"), SETTINGS)
def test_lines_an_hour_are_those_of_a_program_without_lanes(robots, pickers):
    """Within 3 %, in all settings of docs/how-to/people-who-pick.md."""
    model = dw.load(HALL, {"fleet.size": robots, "pickers.count": pickers})
    here = fmean(dw.simulate(model, seed).kpis["throughput_per_hour"] for seed in range(3))
    apart = 3600 * fmean(Hall(model, seed).run(900, 7200) for seed in range(6))
    assert here == pytest.approx(apart, rel=0.03)


def test_a_single_robot_and_a_picker_take_the_same_time_for_a_line():
    """Nobody is in anybody's way here, whichever program."""
    model = dw.load(HALL, {"fleet.size": 1, "pickers.count": 1, "run.length": 40_000})
    here = fmean(dw.simulate(model, seed).kpis["throughput_per_hour"] for seed in range(3))
    apart = 3600 * fmean(Hall(model, seed).run(900, 120_000) for seed in range(2))
    assert here == pytest.approx(apart, rel=0.05)
