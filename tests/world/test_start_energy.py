"""Batteries that do not start full."""

from types import SimpleNamespace

import numpy as np
import pytest

import desim_warehouse as dw
from desim_warehouse import ModelError
from desim_warehouse.model.facts.charging import settling_levels, start_levels
from desim_warehouse.values.streams import Streams
from desim_warehouse.world import World
from desim_warehouse.world.robots.settled import LOOKS, SettledError, SettlingRun
from desim_warehouse.world.traffic.events import Clock
from tests.auditor import audit
from tests.world.ring import RING

BASE = {"tasks.goods": {"poisson": 150}, "run": {"length": 7200}}


def tutorial(changes):
    return dw.load("models/tutorial.yaml", {**BASE, **changes})


def first_energies(run):
    return [levels[0] for _, levels in run.history.energy_curves]


def test_all_start_with_the_same_part_and_charge_before_they_work():
    # 40 of 100, and chargers where they start: charging to 100 at 0.5 a second takes 120 s
    run = dw.simulate(tutorial({"fleet.start_energy": 0.4}))
    assert first_energies(run) == [40, 40, 40]
    rows = [(row[0], row[1]) for row in run.record.rows if row[1] in ("charging", "assigned")]
    assert rows[:3] == [(0, "charging")] * 3
    assert rows[3][0] >= 120
    assert audit(run) == []


def test_each_robot_draws_its_own_and_more_robots_leave_it_as_it_is():
    spread = {"fleet.start_energy": {"uniform": [0.5, 0.9]}}
    three, four = tutorial(spread), tutorial({**spread, "fleet.size": 4})
    levels = start_levels(three, Streams(7))
    assert start_levels(four, Streams(7))[:3] == levels
    assert start_levels(three, Streams(8)) != levels
    assert all(50 <= level <= 90 for level in levels)
    many = start_levels(tutorial({**spread, "fleet.size": 2000}), Streams(1))
    assert np.mean(many) == pytest.approx(70, abs=1)
    run = dw.simulate(three, seed=7)
    assert first_energies(run) == levels
    assert audit(run) == []


@pytest.mark.parametrize(
    "given", [1.5, -0.1, {"uniform": [0.2, 1.2]}, {"uniform": [0.9, 0.5]}, {"normal": [0, 1]}, "half"]
)
def test_what_is_no_part_of_a_battery_is_refused(given):
    with pytest.raises(ModelError, match=r"fleet\.start_energy"):
        tutorial({"fleet.start_energy": given})


def test_without_battery_it_says_nothing():
    run = dw.simulate(tutorial({"fleet.start_energy": 0.4, "battery": None}))
    assert run.kpis["tasks"] > 100


def test_a_start_that_does_not_reach_a_charger_is_named_as_the_cause():
    # from B to the charger at A the way leads round, more than 2 s; that is all that 0.1 lasts for at 0.05 a second
    bays = {"parking": {"at": ["B"], "chargers": 0}, "charging": {"at": ["A"], "places": 3}}
    plain = tutorial({}).content()
    plain["layout"]["bays"] = bays
    model = dw.load(plain, {"fleet.start": ["B"], "fleet.start_energy": 0.001})
    message = r"it started with 0\.1 of 100 and came to no charger in time; a higher fleet\.start_energy"
    with pytest.raises(dw.BatteryError, match=message):
        dw.simulate(model)


def test_a_start_below_the_threshold_without_chargers_is_refused_with_the_cure():
    bays = {"layout.bays.parking.chargers": 0, "fleet.start_energy": 0.3}
    message = (
        r"start with 30 of 100, not above 30, where robots stop working; give .*, or the robots a higher fleet\.start_"
    )
    with pytest.raises(dw.CheckError, match=message):
        dw.simulate(tutorial(bays))


BATTERY = {"capacity": 100, "threshold": 30, "consumption": 0.01, "charge_rate": 1}
SETTLED = {"fleet.start_energy": "settled", "policies.charging": "four-thresholds", "run": {"length": 3600}}


def few_chargers(changes):
    """Robots start at B, where they cannot charge; the one charger is at A."""
    plain = tutorial({}).content()
    plain["layout"]["bays"] = {"parking": {"at": ["B"], "chargers": 0}, "charging": {"at": ["A"], "places": 1}}
    return dw.load(plain, {**SETTLED, "fleet.start": ["B"], "tasks.goods": {"poisson": 60}, **changes})


@pytest.mark.slow
def test_runs_that_begin_settled_draw_one_look_at_the_fleet_for_all_robots():
    """Who charges stands at a charger at once, even if its home has none, and all others are free."""
    model = few_chargers({})
    runs = [dw.simulate(model, seed) for seed in range(12)]
    first = [first_energies(run) for run in runs]
    assert len({tuple(levels) for levels in first}) > 6
    assert first_energies(dw.simulate(model, 3)) == first[3]
    assert all(0 < level <= 100 for levels in first for level in levels)
    charging = [{row[2]: row[4] for row in run.record.rows if row[:2] == (0, "charging")} for run in runs]
    assert {name for nodes in charging for name in nodes.values()} == {"A"}
    assert max(map(len, charging)) == 1
    for run, node_of in zip(runs, charging, strict=True):
        assert [start.node for start in run.history.starts] == [node_of.get(robot, "B") for robot in range(3)]
    assert [problem for run in runs for problem in audit(run)] == []


def test_a_fleet_that_takes_long_to_settle_is_given_a_day_and_observed_in_its_second_half():
    """At 0.01 a second its one robot draws 864 at most in 24 hours, of 5 times the 1,300 between 30 and 95 % of 2,000.

    Intervals double after 0.8, 1.6, 3.2, 6.4 and 12.8 hours, from 15 seconds to 8 minutes: 90 fit into 12 hours.
    """
    battery = {**BATTERY, "capacity": 2000, "threshold": 600}
    slow = dw.load(RING, {**SETTLED, "fleet.size": 1, "tasks.goods": {"poisson": 4}, "battery": battery})
    settling = SettlingRun(slow)
    world = World(settling.model, 1, settles=True)
    settling.watch(world.env, world.robots)
    with pytest.raises(SettledError):
        world.run()
    assert world.env.now == pytest.approx(24 * 3600)
    assert len(settling.fleets) == 90


def falling(until):
    """A battery of 100 that falls from 100 by 2 an hour until some hour and then stays, while 100 an hour are drawn."""
    battery = SimpleNamespace(capacity=100, drawn=lambda now: 100 * now / 3600)
    battery.level = lambda now: 100 - 2 * min(now / 3600, until)
    return battery


@pytest.mark.parametrize(("until", "hours"), [(10, 23.1), (0, 6.5)])
def test_a_fleet_has_settled_when_its_mean_level_differs_little_between_the_halves_of_the_run(until, hours):
    """Falling by 20 in 10 hours and then steady: after t hours, 20 or more, the first half is 200 / t above the second.

    That is 0.75 % an hour for t / 2 hours where t t = 400 / 0.75, at 23.1 hours. A steady level is settled once ten
    times 65 are drawn, in 6.5 hours.
    """
    settling = SettlingRun(
        dw.load(RING, {**SETTLED, "fleet.size": 1, "tasks.goods": {"poisson": 4}, "battery": BATTERY})
    )
    env = Clock()
    robot = SimpleNamespace(kind="", env=env, battery=falling(until), bay=None, charging=None)
    settling.watch(env, [robot])
    with pytest.raises(SettledError):
        env.run()
    assert env.now / 3600 == pytest.approx(hours, abs=0.15)
    assert {robot.energy for [robot] in settling.fleets} == {100 - 2 * until}
    assert LOOKS <= len(settling.fleets) <= 2 * LOOKS


@pytest.mark.parametrize(
    ("policy", "low", "high"),
    [
        ("four-thresholds", 30, 60),  # good
        ({"name": "four-thresholds", "sufficient": 0.8}, 30, 80),
        ("opportunity", 20, 100),
        ("threshold", 30, 100),
        ({"name": "swap", "time": 60}, 20, 100),
    ],
)
def test_a_settling_run_begins_at_levels_of_robots_at_work(policy, low, high):
    """Charged at rest from the upper level down, or then interrupted by work; a policy without either charges fully."""
    levels = settling_levels(tutorial({**SETTLED, "policies.charging": policy, "fleet.size": 300}), Streams(1))
    assert low <= min(levels) < low + 2
    assert high - 2 < max(levels) <= high


def test_work_that_ends_has_no_long_run_to_begin_in():
    """Levels are drawn between where charging begins, 30 %, and where it ends, 95 %."""
    model = tutorial({**SETTLED, "tasks.goods": {"random": 5}, "run": {}, "fleet.size": 300})
    levels = start_levels(model, Streams(1))
    assert 30 <= min(levels) < 32
    assert 93 < max(levels) <= 95


def test_a_fleet_that_would_run_flat_has_no_long_run_to_begin_in_and_the_run_says_that_it_does_not_last():
    slow = few_chargers({"battery.charge_rate": 0.001, "run": {"length": 600}})
    run = dw.simulate(slow)
    assert all(30 <= level <= 95 for level in first_energies(run))
    assert [verdict.code for verdict in run.verdicts if verdict.is_lasting] == ["BATTERIES_FALL"]
