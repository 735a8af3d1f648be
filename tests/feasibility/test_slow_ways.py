"""Warnings of ways that are short and slow, and of a single slot for which a fleet waits."""

import pytest

import desim_warehouse as dw
from desim_warehouse.feasibility.slow_ways import slow_ways
from desim_warehouse.questions.check import check

pytestmark = pytest.mark.usefixtures("brief_probes")
NODES = {"A": [0, 0], "S": [10, 2], "F": [10, -6], "B": [20, 0], "X": [10, 20]}
"""From A to B over S, 20.4 m, or over F, 23.3 m; back over X."""


def loop(speed=0.2, routing="shortest", **changes):
    edges = [
        {"from": "A", "to": "S", "speed": speed},
        {"from": "S", "to": "B", "speed": speed},
        ["A", "F"],
        ["F", "B"],
        ["B", "X"],
        ["X", "A"],
    ]
    model = {
        "name": "loop",
        "layout": {
            "nodes": NODES,
            "edges": edges,
            "storage": [{"node": "A"}],
            "bays": {"park": {"at": ["X"], "places": 3}},
            "stations": {"packing": {"at": ["B"], "places": 4}},
        },
        "fleet": {"size": 2, "robot": {"radius": 0.4, "speed": 1}},
        "tasks": {"goods": {"saturated": 4}, "unload_at": ["packing"], "load_time": 5, "unload_time": 5},
        "policies": {"routing": routing},
        "run": {"length": 3600},
    }
    return dw.load(model, {key.replace("__", "."): value for key, value in changes.items()})


def slow(model):
    return [one.text for one in slow_ways(model, model.floor)]


def test_a_short_way_that_is_far_slower_is_told_with_both_times():
    (told,) = slow(loop())
    assert "the shortest way takes 102 s, where 23.32 s do" in told


@pytest.mark.parametrize(
    "model",
    [
        loop(routing="fastest"),
        loop(routing="congestion-aware"),
        loop(speed=0.8),  # 25.5 s beside 23.3
        loop(speed=1.0),
        loop(speed=2.0),  # faster than robots
    ],
)
def test_ways_that_are_not_far_slower_are_not_told(model):
    assert slow(model) == []


def test_a_slow_zone_counts_as_a_slow_lane():
    zone = {"zone": {"members": [["A", "S"], ["S", "B"]], "speed": 0.2}}
    assert "takes 102 s, where 23.32 s do" in slow(loop(speed=None, traffic__slow=zone))[0]
    assert slow(loop(speed=None)) == []


def spur(places, size):
    nodes = {"A": [0, 0], "B": [20, 0], "C": [20, 10], "D": [0, 10], "S": [10, 16], "M": [10, 10]}
    spur_lane = {"from": "M", "to": "S", "two_way": True}
    return dw.load(
        {
            "name": "spur",
            "layout": {
                "nodes": nodes,
                "edges": [["A", "B"], ["B", "C"], ["C", "M"], ["M", "D"], ["D", "A"], spur_lane],
                "storage": [{"node": "A"}, {"node": "B"}],
                "bays": {"p": {"at": ["D"], "places": 8, "chargers": 0}},
                "stations": {"sink": {"at": ["S"], "places": places}},
            },
            "fleet": {"size": size, "robot": {"radius": 0.4, "speed": 1}},
            "tasks": {"goods": {"saturated": 8}, "load_time": 10, "unload_time": 10, "unload_at": ["sink"]},
            "run": {"length": 3600},
        }
    )


@pytest.mark.parametrize(("places", "size", "told"), [(1, 2, True), (1, 6, True), (2, 2, False), (1, 1, False)])
def test_one_slot_for_a_fleet_is_a_warning_with_what_it_costs(places, size, told):
    findings = check(spur(places, size)).findings
    warnings = [one for one in findings if one.code == "ONE_AT_WORK"]
    assert bool(warnings) == told
    assert not (told and any(one.code == "STATION_PLACES" for one in findings))  # said once
    if told:
        assert warnings[0].level == "warning"
        assert warnings[0].text.startswith(f"1 slot for {size} robots: 1 of {size} works at a time")
        parts = warnings[0].text.split(" tasks an hour; with a slot for each they do ")
        does, could = (float(part.split()[-1]) for part in parts)
        assert could > 1.5 * does
        assert does == pytest.approx(39, abs=2)  # as simulated


def test_one_slot_of_a_bay_for_two_robots_is_refused_as_ever():
    findings = check(spur(2, 2).replace({"layout.bays.p.places": 1, "fleet.start": ["D"]})).findings
    assert {"TOO_FEW_PLACES", "BAY_CROWDED"} & {one.code for one in findings}
