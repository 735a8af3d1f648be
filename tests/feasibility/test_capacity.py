"""Queues by mean value analysis: by hand for two robots, its limits, and against runs of saturated fleets."""

import math

import pytest

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.feasibility.estimate import Network, Place
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.run.quick import estimate


def test_two_robots_at_one_server():
    # 10 s at the desk, 40 s elsewhere: the second finds the other there for 10/50 of its time, and waits 10 s for it
    network = Network(50, [Place("the desk", 10, 1)])
    assert network.throughput(1) == 1 / 50
    assert network.throughput(2) == pytest.approx(2 / (50 + 10 * 10 / 50))
    assert network.longest == "the desk"


def test_two_servers_are_one_twice_as_fast_and_a_time_without_queues():
    both = Network(50, [Place("desks", 10, 2)])
    assert both.throughput(1) == 1 / 50
    assert both.throughput(2) == pytest.approx(2 / (50 + 5 * 5 / 50))
    assert both.most == 0.2


def test_many_robots_keep_the_slowest_place_busy_and_none_does_more():
    network = Network(100, [Place("desk", 10, 1), Place("charger", 20, 1)])
    assert 0.95 / 20 < network.throughput(20) < 1 / 20
    assert network.robots_for(1 / 20) == math.inf
    assert network.robots_for(1 / 100) == pytest.approx(1)
    assert network.longest == "charger"


def test_with_no_place_to_queue_robots_add_up():
    network = Network(50, [Place("desk", 0, 1)])
    assert network.throughput(7) == 7 / 50
    assert network.robots_for(7 / 50) == pytest.approx(7)


@pytest.mark.parametrize(("robots", "chargers"), [(4, 1), (8, 2), (14, 1)])
def test_a_saturated_fleet_does_what_is_said(robots, chargers):
    """Charging takes long, and robots queue for it: without queues up to half more would be told."""
    words = Draft(size=(40, 30), orders=100, robots=robots, chargers=chargers, stations=2)
    changes = {
        "battery.charge_rate": 0.008 if robots < 14 else 0.02,
        "tasks.goods": {"saturated": 3 * robots},
        "policies.allocation": "in-order",
        "run": {"length": 10 * 3600, "warm_up": 3600},
        "log": "tasks",
    }
    model = dw.Model.model_validate(read_yaml(draft(words), "draft").data).replace(changes)
    found = estimate(model)
    done = dw.simulate(model, 3).kpis["throughput_per_hour"]
    assert found.capacity * 3600 == pytest.approx(done, rel=0.15)
