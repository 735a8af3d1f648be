"""Robots that keep their braking distance, against the stepped reference by the same rule: it can stop at any step.

There a robot looks at all others in each step, and drives as fast as lets it stop before the first that would stop it.
The model claims intersections, and a robot that is not let in at its braking distance stops at the stop line: so it is
never much faster, and on a full floor slower.
"""

import statistics

import pytest

import desim_warehouse as dw

from .paper import GROUPS, changes
from .stepped import Setting, simulate

MULTIBOTS = dw.load("models/multibots.yaml")
RATE = 0.4
"""Speed lost in a step: from 4 px a step within 20 px."""


def difference(robots, group):
    """T of the model against the reference, as a share. No battery gets low, as the moment may decide a trip more."""
    setting = Setting(robots, GROUPS[group], braking=RATE, finer=8, threshold=0.1, consumption=0.0005)
    robot = {"fleet.robot.acceleration": RATE, "fleet.robot.keeps": "braking"}
    return dw.simulate(MULTIBOTS.replace({**changes(setting), **robot})).T / simulate(setting).T - 1


def test_a_single_robot_brakes_as_in_steps():
    """In steps gathering speed and braking take part of a step longer: a little less than half a per cent."""
    assert -0.005 < difference(1, 3) < 0


@pytest.mark.parametrize(("robots", "group"), [(4, 1), (6, 3), (8, 5)])
def test_a_few_robots_take_as_long(robots, group):
    assert abs(difference(robots, group)) < 0.005


@pytest.mark.long
@pytest.mark.parametrize(("robots", "mean", "largest"), [(2, 0.005, 0.005), (8, 0.01, 0.05), (12, 0.03, 0.08)])
def test_on_a_full_floor_they_take_a_little_longer(robots, mean, largest):
    differences = [difference(robots, group) for group in GROUPS]
    assert -0.005 < statistics.mean(differences) < mean
    assert max(map(abs, differences)) < largest
