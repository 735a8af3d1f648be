"""Robots that park on a node: no route leads through it, and it must not cut the network.

A loop A B C D with a short cut A > P > C, and a spur B - E; lengths 10, speed 1, D = 1.
"""

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import PolicyError
from tests.auditor import audit

LOOP = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [10, 10], "D": [0, 10], "P": [5, 5], "E": [20, 0]},
        "edges": [
            *(["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"], ["A", "P"], ["P", "C"]),
            {"from": "B", "to": "E", "two_way": True},
        ],
        "storage": [{"node": "C"}],
        "bays": {"park": {"at": ["P"], "in_lane": True}, "home": {"at": ["D"], "places": 1}},
    },
    "fleet": {"size": 1, "start": ["park"], "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {"goods": [0], "unload_at": ["A"], "load_time": 5, "unload_time": 3},
    "policies": {"routing": "shortest"},
}


def edges(run):
    return [">".join(row.edge) for row in run.history.rows("enter")]


@pytest.mark.parametrize(
    "routing", ["highways", "shortest", {"name": "shortest", "spread": 3}, "fastest", "congestion-aware"]
)
@pytest.mark.parametrize("turn_time", [0, 1])
def test_no_route_leads_through_it_but_to_it_and_from_it(routing, turn_time):
    changes = {"policies.routing": routing, "traffic.turn_time": turn_time, "tasks.goods": [0, 0]}
    run = dw.simulate(dw.load(LOOP, changes))
    there_and_back = ["P>C", "C>D", "D>A"]
    assert edges(run) == [*there_and_back, "A>B", "B>C", "C>D", "D>A", "A>P"]
    assert audit(run) == []


def test_beside_the_node_others_may_pass():
    run = dw.simulate(dw.load(LOOP, {"layout.bays.park.in_lane": False, "tasks.goods": [0, 0]}))
    assert edges(run)[3:5] == ["A>P", "P>C"]


def test_a_routing_policy_that_leads_through_it_is_refused(tmp_path):
    code = "class Through:\n    def route(self, origin, goal, roads):\n"
    code += "        return {'PC': 'PC', 'CA': 'CDA', 'AC': 'APC', 'AP': 'AP'}[origin + goal]\n"
    (tmp_path / "own.py").write_text(code, encoding="utf-8")
    changes = {"policies.routing": f"{tmp_path / 'own.py'}:Through", "tasks.goods": [0, 0]}
    with pytest.raises(PolicyError, match="A > P > C is no route from A to C, as P is a bay in the lane"):
        dw.simulate(dw.load(LOOP, changes, run_code=True))


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"layout.bays.park.at": ["B"]}, r"layout.bays.park: B: a robot parked on the node cuts off E"),
        ({"layout.storage": [{"node": "P"}]}, r"park: P: robots park on the node, but good 0 is picked there"),
        ({"layout.storage": [{"edge": ["A", "P"], "offset": 3}]}, r"but good 0 is picked there, or on an edge beside"),
        ({"tasks.unload_at": ["P"]}, r"robots park on the node, but goods are unloaded at P"),
        ({"fleet.size": 2, "fleet.start": ["P"]}, r"layout.bays.park.places: 2 robots start at P"),
    ],
    ids=["a cut", "a good", "a good beside it", "unloading", "two robots"],
)
def test_what_robots_there_would_hold_up_is_refused_by_name(changes, text):
    spur = {"layout.stations": {"pack": {"at": ["E"]}}, "tasks.unload_at": ["pack"]}
    with pytest.raises(dw.LayoutError, match=text):
        dw.simulate(dw.load(LOOP, {**spur, **changes}))


def test_the_end_of_a_spur_cuts_nothing():
    changes = {"layout.bays.park.at": ["E"], "fleet.start": ["park"]}
    run = dw.simulate(dw.load(LOOP, changes))
    assert edges(run)[0] == "E>B"
    assert edges(run)[-1] == "B>E"
    assert audit(run) == []


def test_more_than_one_slot_on_a_node_is_refused():
    with pytest.raises(dw.ModelError, match=r"layout.bays.park.places: too many for a bay in the lane \(got 2\)"):
        dw.load(LOOP, {"layout.bays.park.places": 2})


def test_nobody_starts_on_the_node_but_in_the_bay():
    with pytest.raises(dw.CheckError, match="robot 0 on node P is where another may be parked"):
        dw.simulate(dw.load(LOOP, {"fleet.start_on_lanes": [{"node": "P"}]}))


def test_nobody_starts_in_a_part_that_such_a_bay_cuts_off():
    """A dead end that nobody uses, behind B."""
    changes = {"layout.bays.park.at": ["B"], "fleet.start": ["home"], "fleet.start_on_lanes": [{"node": "E"}]}
    with pytest.raises(dw.CheckError, match="robot 0 on node E cannot get to the goods, or home"):
        dw.simulate(dw.load(LOOP, changes))
