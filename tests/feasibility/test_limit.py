"""What sets the number of tasks that a fleet can do, worked out by hand: robots, or people for some of the flows."""

import pytest

import desim_warehouse as dw
from desim_warehouse.feasibility.rules import warnings
from desim_warehouse.questions.check.words import sentences
from desim_warehouse.run import probe
from desim_warehouse.run.quick import estimate
from tests.feasibility.test_flow_mix import HOUR, PACKED
from tests.world.test_flows import RING

pytestmark = pytest.mark.usefixtures("brief_probes")

FLOWS = {
    "orders": {"from": "storage", "to": "pack", "arrivals": {"poisson": 90}},
    "in": {"from": "dock", "to": "storage", "arrivals": {"poisson": 30}},
}


def told(**changes):
    """What check says a fleet can do, and its warnings by code."""
    model = dw.load(RING, {"tasks.flows": FLOWS, "fleet.size": 8, **HOUR, **PACKED, **changes})
    quick = estimate(model)
    [can_do] = [line for line in sentences(model, quick) if " can do about " in line]
    return can_do, {item.code: item.text for item in warnings(model, model.floor, quick)}


def test_a_packer_for_one_of_two_flows_is_named_as_the_limit_and_not_the_robots():
    """A packer does 60 of the 90 orders an hour, with the 20 loads that come in meanwhile 80 of 120 tasks.

    The robots alone would do about 8 x 40 = 320.
    """
    can_do, _ = told()
    assert can_do.startswith("With work at D (1 worker) as the limit, 8 robots can do about ")
    assert can_do.endswith("80 loads an hour (60 of flow orders); you need 120 (90 of flow orders).")


def test_hours_of_a_packer_are_told_with_the_limit():
    """In 1 of 3 hours the packer does 60, 20 an hour: a third of the above."""
    can_do, _ = told(**{"calendars.early": {"between": [[0, "1 h"]]}, "layout.stations.pack.hours": "early"})
    assert can_do.startswith("With work at D (1 worker, at work 33.3 % of the time) as the limit, 8 robots can do ")
    assert "26 loads an hour (20 of flow orders)" in can_do


def test_pickers_of_one_flow_are_the_limit_of_demand_that_is_too_much(monkeypatch):
    """Two pickers at 160 s a load do 45 orders an hour, of 60 tasks with the loads in; with 8 robots 5 % less.

    A probe of 200 tasks has three orders for each load in, to the per mille.
    """
    monkeypatch.setattr(probe, "MOST", 200)
    pickers = {"pickers": {"count": 2, "speed": 10, "flows": ["orders"]}, "tasks.load_time": 160}
    can_do, codes = told(**pickers)
    assert can_do.startswith("With the pickers as the limit, 8 robots can do about ")
    assert can_do.endswith("57 loads an hour (42 of flow orders); you need 120 (90 of flow orders).")
    text = "demand is 120 tasks an hour, but with the pickers as the limit, 8 robots can do 57 (42.75 of flow orders)"
    assert codes["DEMAND_ABOVE_FLEET"] == text


def test_robots_that_are_too_few_are_told_as_before():
    """Two robots do about 80 tasks an hour, two packers 120 orders with 40 loads in."""
    can_do, codes = told(**{"fleet.size": 2, "layout.stations.pack.workers": 2})
    assert can_do.startswith("2 robots can do about ")
    assert codes["DEMAND_ABOVE_FLEET"].startswith("demand is 120 tasks an hour, but 2 robots can do ")
    assert "of flow" not in can_do + codes["DEMAND_ABOVE_FLEET"]
