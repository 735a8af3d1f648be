"""The quick estimate with stops on the way and with tours, worked out on a ring."""

import pytest

import desim_warehouse as dw
from desim_warehouse.layout import build
from tests.world.test_flows import RING

pytestmark = pytest.mark.usefixtures("brief_probes")

FLOW = {"from": "dock", "to": "pack", "arrivals": {"poisson": 30}}


def checked(flow=None, **changes):
    changes = {key.replace("__", "."): value for key, value in changes.items()}
    model = dw.load(RING, {"tasks.flows": {"flow": FLOW if flow is None else flow}, "run.length": 36000, **changes})
    from desim_warehouse.feasibility import examine
    from desim_warehouse.run.quick import estimate

    return examine(model, build(model.layout), estimate)


@pytest.mark.parametrize(
    ("changes", "warned"),
    [
        ({}, True),
        ({"policies__batching": {"name": "fixed-size", "size": 2}}, False),
        ({"policies__batching": {"name": "time-window", "window": 60}}, False),
        ({"flow": {**FLOW, "kinds": ["small"]}}, False),
    ],
)
def test_robots_that_carry_less_than_every_tour_are_named(changes, warned):
    """Tours have four loads, as the large robot carries, and the two small ones carry two."""
    kinds = {"small": {"count": 2, "capacity": 2}, "large": {"count": 1}}
    common = {"fleet.size": 3, "fleet.kinds": kinds, "fleet__robot__capacity": 4, "policies__batching": "fixed-size"}
    findings, _ = checked(**{**common, **changes})
    named = {item.place for item in findings if item.code == "MORE_THAN_FIT"}
    assert named == ({"fleet.kinds.small.capacity"} if warned else set())


def test_a_stop_on_the_way_is_driven_to_and_handled():
    _, alone = checked()
    assert (alone.cycle.empty, alone.cycle.loaded, alone.cycle.unload) == pytest.approx((40, 40, 6))
    # by A: from the dock at B on round to A 60, handled for 3, and on round to D 60
    _, calculation = checked({**FLOW, "via": ["A"], "stop_time": 3})
    assert (calculation.cycle.empty, calculation.cycle.loaded, calculation.cycle.unload) == pytest.approx((40, 120, 9))
    shares = {item.node: item.share for item in calculation.stations}
    assert shares == pytest.approx({"B": 1, "D": 1, "A": 1}, rel=0.01)
    capacity = {item.node: 1 / item.capacity for item in calculation.stations}
    assert capacity == pytest.approx({"B": 4, "D": 6, "A": 3})


def test_a_tour_shares_its_drives():
    _, calculation = checked(fleet__robot__capacity=4, policies__batching="fixed-size")
    assert calculation.cycle.time == pytest.approx((40 + 40) / 4 + 4 + 6)
    assert calculation.fleet_capacity == pytest.approx(1 / 30)
    assert calculation.robots_busy == pytest.approx(30 / 3600 * 30)


def test_a_run_does_what_the_estimate_says():
    flow = {**FLOW, "arrivals": {"saturated": 12}}
    changes = {"fleet.robot.capacity": 4, "policies.batching": "fixed-size"}
    model = dw.load(RING, {"tasks.flows": {"flow": flow}, "run.length": 36000, **changes})
    run = dw.simulate(model)
    from desim_warehouse.run.quick import estimate

    most = estimate(model).fleet_capacity * 3600
    assert run.kpis["throughput_per_hour"] == pytest.approx(most, rel=0.01)
    assert run.kpis["loads_per_trip"] == 4


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"fleet__robot__capacity": 2}, "policies.batching"),
        ({"policies__batching": "fixed-size"}, "fleet.robot.capacity"),
        ({"fleet__robot__capacity": 2, "policies__batching": "fixed-size"}, None),
    ],
)
def test_loads_that_never_come_together_are_said(changes, place):
    findings, _ = checked(**changes)
    assert [item.place for item in findings if item.code == "ONE_LOAD"] == ([] if place is None else [place])


def test_the_threshold_must_leave_enough_for_all_of_a_tour():
    # from the dock 4, 40, 6 and 20 to the charger at A: 70; three loads more are handled in 30
    battery = {"capacity": 1000, "threshold": 71, "consumption": 1, "charge_rate": 10}
    findings, _ = checked(battery=battery)
    assert "THRESHOLD_TOO_LOW" not in {item.code for item in findings}
    findings, _ = checked(battery=battery, fleet__robot__capacity=4, policies__batching="fixed-size")
    assert "THRESHOLD_TOO_LOW" in {item.code for item in findings}


def test_nodes_that_only_orders_name_must_be_reached(tmp_path):
    nodes = {**RING["layout"]["nodes"], "X": [40, 0]}
    edges = [*RING["layout"]["edges"], ["B", "X"]]
    path = tmp_path / "orders.csv"
    changes = {"layout__nodes": nodes, "layout__edges": edges, "run__length": None}
    for row, codes in (("0,dock,pack", {"UNREACHABLE_UNUSED"}), ("0,dock,X", {"UNREACHABLE"})):
        path.write_text(f"release,from,to\n{row}\n", encoding="utf-8")
        findings, _ = checked({**FLOW, "arrivals": {"orders": {"file": str(path)}}}, **changes)
        assert {item.code for item in findings if item.code.startswith("UNREACHABLE")} == codes
