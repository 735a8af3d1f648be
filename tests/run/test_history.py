"""What the history says of a run: the energy that is left at its end, worked out by hand and told by the batteries."""

import math

import numpy as np
import pytest

import desim_warehouse as dw
from desim_warehouse import plot
from desim_warehouse.replay.payload import ENERGY, payload
from tests.daily import some
from tests.run.ring import RATES, played, ring


def drawn(run):
    """The last level of every robot in the battery figure."""
    axes = (plot.battery(run, robots=[number]) for number in range(run.model.fleet.size))
    return [float(one.lines[0].get_ydata()[-1]) for one in axes]


def test_a_battery_goes_on_falling_in_the_last_state_of_a_run():
    """At 13 it has 1000 - 10 x 1 - 3 x 1.5 = 985.5; at the end, at 40, it has carried for 27: 985.5 - 27 x 2."""
    battery = {"capacity": 1000, "threshold": 10, "consumption": RATES, "charge_rate": 1}
    run, levels = played(dw.load(ring(battery, 40)))
    assert levels == [pytest.approx(931.5)]
    assert run.history.energy_at_end == [pytest.approx(931.5, abs=1e-9)]
    assert drawn(run) == [pytest.approx(931.5, abs=1e-9)]


def test_a_robot_at_rest_draws_nothing_beside_a_charger_and_stands_elsewhere():
    """Back at 128 with 1000 - 10 x 1 - 3 x 1.5 - 50 x 2 - 5 x 1.5 - 60 x 1 = 818, it stands for 72: 818 - 72 x 0.5.

    At the charger halfway back it is full, after 848 of 1000 at 98, at 98 + 152 / 10, and stays so.
    """
    battery = {"capacity": 1000, "threshold": 10, "consumption": RATES, "charge_rate": 10}
    model = ring(battery, 200)
    model["layout"]["bays"] = {"home": {"at": ["A"], "places": 1, "chargers": 0}, "power": {"at": ["D"], "places": 1}}
    model["fleet"]["start"] = ["A"]
    for parking, level, node in (("home", 782, "A"), ("nearest", 1000, "D")):
        run, levels = played(dw.load(model, {"policies.parking": parking}))
        [[*_, last]] = run.history.states
        assert (last.state, last.node) == ("idle", node)
        assert levels == run.history.energy_at_end == [pytest.approx(level, abs=1e-9)]


CUT = [100.0, 333.3, 610.0, 905.5, 1200.0]
"""Ends of runs, some of which find robots driving, waiting, handling and charging."""


@pytest.mark.parametrize("length", some(CUT, 3))
@pytest.mark.parametrize("taper", [None, {"start": 0.6}])
@pytest.mark.parametrize(
    "consumption", [0.005, {"standing": 0.001, "empty": 0.005, "loaded": 0.006, "handling": 0.003}]
)
def test_figure_and_replay_end_at_the_batteries_own_levels(length, taper, consumption):
    changes = {"run.length": length, "battery.taper": taper, "battery.consumption": consumption}
    goods = {"fleet.size": 16, "tasks.goods": {"saturated": 20}, "battery.capacity": 4, "battery.threshold": 2.5}
    run, levels = played(dw.load("models/multibots.yaml", {**changes, **goods}), seed=3)
    assert run.history.energy_at_end == pytest.approx(levels, abs=1e-9)
    assert drawn(run) == pytest.approx(levels, abs=1e-9)
    steps = [level / run.model.battery.capacity * ENERGY for level in levels]
    assert replayed(run) == pytest.approx(steps, abs=0.5 + 1e-6)


def replayed(run):
    """The last level of every robot on the replay page, in its steps of a full battery."""
    _, columns = payload(run.history, 0.0, run.record.end)
    levels = np.split(np.cumsum(columns["energy"]), np.cumsum(columns["energy_count"])[:-1])
    return [int(robot[-1]) for robot in levels]


def test_a_tapered_charge_is_shown_as_it_is():
    """At the charger at 128 with 100 - 128 x 0.46875 = 40, it takes 5 to the knee at 50; then u = level - 50 rises by
    2 - u / 50, so that after another 20 it is 100 (1 - exp(-20 / 50)) above the knee: 82.97, and not 90.
    """
    taper = {"start": 0.5, "end_rate": 0.5}
    battery = {"capacity": 100, "threshold": 45, "consumption": 0.46875, "charge_rate": 2, "taper": taper}
    run, levels = played(dw.load(ring(battery, 153)))
    level = 50 + 100 * (1 - math.exp(-0.4))
    assert run.history.states[0][-1][1:4] == ("charging", 128, 153)
    assert levels == run.history.energy_at_end == drawn(run) == [pytest.approx(level, abs=1e-9)]
    assert replayed(run) == [830]


def test_a_robot_that_waits_at_the_end_is_shown_with_what_standing_left_it():
    """The second robot waits before the station, where the first unloads.

    It sets out at 1, is at its good at 11 and leaves it at 14, with 1000 - 1 x 0.5 - 10 x 1 - 3 x 1.5 = 985. Of the 86
    that follow it drives 19 to the stop line before B and 30 to the one before C, and stands for the other 37.
    """
    battery = {"capacity": 1000, "threshold": 10, "consumption": RATES, "charge_rate": 1}
    model = ring(battery, 100)
    model["layout"]["storage"].append({"edge": ["A", "B"], "offset": 20})
    model["fleet"]["size"] = 2
    model["tasks"] |= {"goods": [1, 0], "unload_time": 50}
    run, levels = played(dw.load(model))
    assert run.history.changes[1][-1][1:6] == ("loaded", 14, 100, 1, 985)
    assert (run.history.waits[-1].robot, run.history.waits[-1].end) == (1, 100)
    assert levels[1] == pytest.approx(985 - 49 * 2 - 37 * 0.5)
    assert run.history.energy_at_end == drawn(run) == pytest.approx(levels, abs=1e-9)
    assert replayed(run)[1] == pytest.approx(868.5, abs=0.5)
