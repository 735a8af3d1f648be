"""Subfleets: robots whose kinds share no flow do not help one another."""

import pytest

import desim_warehouse as dw
from desim_warehouse.model.facts.subfleets import subfleets
from tests.questions.test_busiest import HALL


def flow(**more):
    return {"from": "storage", "to": "packing", "arrivals": {"poisson": 6}, **more}


def names(flows, **kinds):
    tasks = {"flows": flows, "load_time": 2, "unload_time": 2}
    model = dw.load(HALL, {"tasks": tasks, "fleet.size": 4, "fleet.kinds": kinds})
    return {subfleet.name: (subfleet.flows, subfleet.robots) for subfleet in subfleets(model)}


ONE = {"count": 1}


@pytest.mark.parametrize("of", [{}, {"kinds": ["a", "b", "c"]}])
def test_a_flow_that_all_do_makes_them_one_subfleet(of):
    """The fourth robot is of no kind, and has nothing to do if the flow is for the three kinds."""
    told = names({"f": flow(**of), "g": flow(kinds=["a"])}, a=ONE, b=ONE, c=ONE)
    assert told == ({"kinds a, b and c": (("f", "g"), (0, 1, 2)), "no kind": ((), (3,))} if of else {})


def test_kinds_are_one_subfleet_with_all_that_share_a_flow_with_one_of_them():
    flows = {"f": flow(kinds=["a", "b"]), "g": flow(kinds=["b", "c"]), "h": flow(kinds=["d"])}
    told = names(flows, a=ONE, b=ONE, d=ONE, c=ONE)
    assert told == {"kinds a, b and c": (("f", "g"), (0, 1, 3)), "kind d": (("h",), (2,))}


def test_what_robots_carry_makes_subfleets_too():
    flows = {"totes": flow(load_type="tote"), "pallets": flow(load_type="pallet")}
    cart, truck = {"count": 3, "carries": ["tote"]}, {"count": 1, "carries": ["pallet"]}
    told = names(flows, cart=cart, truck=truck)
    assert told == {"kind cart": (("totes",), (0, 1, 2)), "kind truck": (("pallets",), (3,))}


def test_listed_goods_are_for_all_robots():
    assert subfleets(dw.load(HALL, {"fleet.kinds": {"a": ONE}})) == ()
