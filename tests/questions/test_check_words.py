"""What a check says first: loads an hour, robots, chargers and stations, by hand, on one screen of a terminal."""

from dataclasses import replace

import pytest

import desim_warehouse as dw
from desim_warehouse.feasibility.asked import orders_a_day
from desim_warehouse.feasibility.power import Power
from desim_warehouse.questions.check.words import sentences
from desim_warehouse.run.quick import estimate
from tests.world.test_hours import SQUARE

DAY = {
    **SQUARE,
    "calendars": {"half": {"every": 40_000, "lasts": 20_000}},
    "tasks": {**SQUARE["tasks"], "goods": {"poisson": 60}},
    "run": {"length": 80_000},
}
"""One robot does a task in 75 s, of which 30 are unloading at the desk: 48 an hour."""


def said(**changes):
    model = dw.load(DAY, {key.replace("__", "."): value for key, value in changes.items()})
    return sentences(model, estimate(model))


def test_a_fleet_that_is_too_small():
    lines = said()
    assert lines[1] == "Demand: 60 an hour = 1,440 orders a day."
    assert lines[2:4] == [
        "1 robot can do about 48 loads an hour; you need 60.",
        "Robots: 2 are needed; you have 1.",
    ]


def test_the_demand_of_a_day_counts_lorries_and_names_what_nobody_can_count():
    """37.5 an hour are 900 a day; two lorries bring 90 loads each on the first day, and a third comes the day after."""
    lorries = [{"at": hour * 3600, "tasks": 90} for hour in (1, 3, 25)]
    ends = {"from": "storage", "to": "desk"}
    flows = {
        "out": {**ends, "arrivals": {"poisson": 37.5}},
        "lorries": {**ends, "arrivals": {"schedule": lorries}},
        "spare": {**ends, "arrivals": {"saturated": 2}},
    }
    model = dw.load(DAY, {"tasks": {"flows": flows, "load_time": 5, "unload_time": 30}, "run.length": 100_000})
    assert list(orders_a_day(model)) == ["demand: out 900, lorries 180 = 1,080 orders a day, not counting spare"]


def test_hours_are_said_in_hours():
    assert "Hours leave a robot 11.1 of 22.2 h for work." in said(fleet__hours="half")
    broken = {"every": 9000, "repair": 1000}
    assert "Breakdowns leave a robot 20 of 22.2 h for work." in said(fleet__robot__breakdowns=broken)


@pytest.mark.parametrize(
    ("chargers", "needed", "draws", "slack", "by_chargers", "line"),
    [
        (4, 2, 1.0, 0.0, 1.0, "2 are enough; you have 4"),
        (1, 1, 1.0, 0.0, 1.0, "1 is enough; you have 1"),
        (2, 0, 0.0, 0.0, 1.0, "none is enough; you have 2"),
        (0, 1, 1.0, 0.0, 1.0, "1 is needed; you have none"),
        (2, 3, 2.5, 0.0, 1.0, "3 are needed; you have 2"),
        (2, 3, 2.5, 0.6, 1.0, "3 are needed in the long run; 2 give 80 % of what the fleet draws"),
        (2, 1, 2.5, 0.6, 0.76, "1 is enough, as it charges overnight, too; you have 2"),
        (2, 2, 2.5, 0.6, 0.76, "2 are enough, as they charge overnight, too; you have 2"),
        (2, 3, 2.7, 0.6, 0.76, "3 are needed; you have 2"),
    ],
)
def test_chargers_that_are_enough_and_that_are_not(chargers, needed, draws, slack, by_chargers, line):
    model = dw.load(DAY)
    power = Power(
        task=1.0,
        share=0.01,
        lasts=7200.0,
        chargers=chargers,
        charging_rate=1.0,
        gives=float(chargers),
        draws=draws,
        most=draws,
        needed=needed,
        slack=slack,
        by_chargers=by_chargers,
    )
    told = sentences(model, replace(estimate(model), power=power))
    assert f"Chargers: {line}. A full battery lasts 2 h of work." in told
