"""Batteries that are swapped for spare ones, which charge by themselves and run short."""

from itertools import pairwise

import pytest

import desim_warehouse as dw
from desim_warehouse.run.quick import measured
from tests.theory import models
from tests.world.test_charging import RING

pytestmark = pytest.mark.usefixtures("brief_probes")
CHARGE = 80.0


def fleet(robots, spare, changes=None):
    """Robots that swap their battery after every task; one that is taken out is full 80 s later."""
    content = models.fleet_with_spare_batteries(robots, spare, 100.0, CHARGE, 30)
    return dw.load({**content, "log": "all"}, changes or {})


def swaps(run):
    """When each robot came to the place where batteries are swapped, and when it left."""
    log = run.log.query("robot >= 0")
    for _, rows in log.groupby("robot"):
        times, kinds = rows["time"].tolist(), rows["kind"].tolist()
        yield [(times[i], times[i + 1]) for i, kind in enumerate(kinds[:-1]) if kind == "charging"]


def test_a_robot_waits_until_the_battery_that_it_left_the_time_before_is_full():
    (stays,) = swaps(dw.simulate(fleet(1, 1)))

    assert len(stays) > 20
    assert stays[0][0] == stays[0][1]  # the spare one is full at the start
    for (before, _), (came, left) in pairwise(stays):
        assert left == pytest.approx(max(came, before + CHARGE))
    assert any(left > came for came, left in stays)


def test_each_robot_more_that_shares_the_spare_batteries_waits_longer():
    waited = [
        sum(left - came for stays in swaps(dw.simulate(fleet(3, n))) for came, left in stays) for n in (1, 3, None)
    ]

    assert waited[0] > waited[1] > waited[2] == 0


def test_the_swap_takes_its_time_after_the_wait():
    (stays,) = swaps(dw.simulate(fleet(1, 1, {"policies.charging.time": 30})))

    for (before, _), (came, left) in pairwise(stays):
        assert left == pytest.approx(max(came, before + CHARGE) + 30)


def test_spare_batteries_limit_a_fleet_that_takes_out_more_than_they_charge():
    """Two batteries charge at once, as a robot waits at the charger for the other: they give 0.2, and a task draws 95.

    So three robots do 7.6 tasks an hour, though a swap takes 20 of the 160 that a battery from full to 20 % lasts.
    """
    swap = {"name": "swap", "time": 20, "batteries": 1}
    draws = {"standing": 0, "empty": 1, "loaded": 1, "handling": 1}
    battery = {"capacity": 200, "consumption": draws, "charge_rate": 0.1}
    over = {"fleet.size": 3, "tasks.goods": {"saturated": 3}, "policies.charging": swap, "battery": battery}
    model = dw.load(RING, {**over, "layout.bays.home": {"at": ["A"], "places": 3, "chargers": 1}, "run.length": 80_000})
    quick = measured(model)
    assert quick.capacity * 3600 == pytest.approx(0.2 / 95 * 3600, rel=0.05)
    assert quick.bottleneck == "the spare batteries"
    done = dw.simulate(model.replace({"run": {"length": 80_000, "warm_up": 20_000}}))
    assert quick.capacity * 3600 == pytest.approx(done.kpis["throughput_per_hour"], rel=0.1)
    assert measured(model.replace({"policies.charging.batteries": 30})).capacity > 4 * quick.capacity


@pytest.mark.slow
def test_spare_batteries_are_shared_out_among_the_bays_so_each_needs_one():
    layout = fleet(1, 2).content()["layout"]
    bays = {
        "home": {"at": ["A"], "chargers": 1},
        "other": {"at": [next(iter(layout["nodes"].keys() - {"A"}))], "chargers": 1},
    }
    model = fleet(1, 1, {"layout.bays": bays})

    (finding,) = [item for item in dw.check(model).findings if item.code == "NO_SPARE"]
    assert finding.text == "1 spare battery for 2 bays with chargers"
    with pytest.raises(dw.CheckError, match="NO_SPARE"):
        dw.simulate(model)


def test_a_spare_battery_has_a_price():
    prices = {"prices": {"hours": 4000, "robot": 6000, "battery": 500}}

    assert dw.simulate(fleet(2, 3, prices)).kpis["annual_cost"] == pytest.approx(2 * 6000 + 3 * 500)


def test_no_spare_battery_at_all_is_refused():
    with pytest.raises(dw.ModelError, match="batteries is 0, expected at least 1"):
        fleet(1, 0)
