"""What may hold goods to person up: how pods are changed, called and filled is tried beside robots and pickers."""

import pytest

import desim_warehouse as dw
from desim_warehouse.study.suspects import suspects
from tests.world.test_pods import RING

BUSY = {
    "pods": {"count": 3, "items": 9, "per_pod": 4, "orders": 4, "stock": 500, "change_time": 4},
    "tasks.flows.picks.arrivals": {"saturated": 20},
    "run": {"length": 2000},
    "log": "all",
}


def reliefs(**changes):
    run = dw.simulate(dw.load(RING, {**BUSY, **changes}))
    for suspect in (ranked := suspects(run)):
        run.model.replace(suspect.overrides)  # every relief is a model
    return {suspect.name: suspect for suspect in ranked}


def test_each_part_of_goods_to_person_is_relieved():
    by_name = reliefs()
    assert {name: dict(by_name[name].overrides) for name in PARTS} == PARTS
    doses = {name: by_name[name].dose for name in PARTS}
    assert doses["orders at the stations"] == doses["what pods hold"] == pytest.approx(1 / 4)
    assert doses["the change of pods"] == -0.5
    assert doses["pods at the stations"] == pytest.approx(-1 / 4)
    assert doses["stock"] is None
    assert by_name["picking"].beside  # the work itself, of which less always gains
    assert {"pickers of pick", "the number of robots"} <= set(by_name)


PARTS = {
    "the change of pods": {"pods.change_time": 2},
    "picking": {"tasks.flows.picks.stop_time": 9},
    "orders at the stations": {"pods.orders": 5},
    "what pods hold": {"pods.per_pod": 5},
    "stock": {"pods.stock": None},
    "pods at the stations": {"layout.stations.pick.places": 4},
    "policies.pod": {"policies.pod": "most-lines"},
    "policies.order_station": {"policies.order_station": "most-lines-in-common"},
}


def test_what_there_is_none_of_is_not_relieved():
    pods = {"count": 3, "items": 4, "per_pod": 4, "orders": 0, "change_time": 0}
    by_name = reliefs(pods=pods, **{"layout.stations.pick.places": 2})
    gone = {"the change of pods", "orders at the stations", "what pods hold", "stock", "pods at the stations"}
    assert not gone & set(by_name)  # pods hold all items already, and of two places one is picked at


def test_single_loads_have_no_pods_to_relieve():
    assert not set(PARTS) & set(reliefs(pods=None))
