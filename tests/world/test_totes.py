"""Totes: several whole orders on one robot, each handed over whole, worked out by hand."""

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import ModelError, PolicyError
from tests.accounting import faults
from tests.auditor import audit
from tests.recount import differences
from tests.world.test_flows import RING
from tests.world.test_tours import trips


def ring(tmp_path, *lines, batching, **changes):
    """One way round, A B C D, 20 to a side; place 0 is 10 beyond B, place 1 is 15 beyond C; a robot at A carries 4.

    Loading takes 4, unloading 6. `lines`: release, place and order of each.
    """
    path = tmp_path / "orders.csv"
    path.write_text("release,from,to,order\n" + "\n".join(f"{at},{place},pack,{order}" for at, place, order in lines))
    flow = {"from": "storage", "to": "pack", "arrivals": {"orders": {"file": str(path)}}, **changes.pop("flow", {})}
    storage = [{"edge": ["B", "C"], "offset": 10}, {"edge": ["C", "D"], "offset": 15}]
    base = {"layout.storage": storage, "fleet.robot.capacity": 4, "policies.batching": {"name": "by-order", **batching}}
    more = {key.replace("__", "."): value for key, value in changes.items()}
    run = dw.simulate(dw.load(RING, {**base, "tasks.flows": {"flow": flow}, **more}))
    assert audit(run) == []
    assert faults(run) == []
    assert differences(run) == []
    return run


def delivered(run):
    return [(row.task, row.time) for row in run.history.rows("delivered")]


TWO = [(0, 0, "a"), (0, 1, "a"), (0, 0, "b"), (0, 1, "b")]
WHOLE = {"flow": {"unload_per": "order"}}


def test_two_orders_go_together_and_their_lines_are_unloaded_one_by_one(tmp_path):
    """Both of place 0 from 30 to 38, of place 1 from 63 to 71; D is at 76."""
    run = ring(tmp_path, *TWO, batching={"orders": 2})
    assert trips(run) == [[0, 2, 1, 3]]
    assert [row.time for row in run.history.rows("loading")] == [30, 34, 63, 67]
    assert delivered(run) == [(0, 82), (2, 88), (1, 94), (3, 100)]


def test_tote_is_handed_over_whole_one_order_after_the_other(tmp_path):
    """At D at 76: order a until 82, b until 88, though its first line was picked before the last of a."""
    run = ring(tmp_path, *TWO, batching={"orders": 2}, **WHOLE)
    assert trips(run) == [[0, 2, 1, 3]]
    assert delivered(run) == [(0, 82), (1, 82), (2, 88), (3, 88)]
    assert [order.done for order in run.history.orders] == [82, 88]
    assert run.account("robot")["unloading"].sum() == 12


def test_each_tour_hands_its_part_of_an_order_over(tmp_path):
    """Two fit on the robot: place 0 from 30 to 38, D at 68, order a until 74; again from D 50 to place 0, 30 to D."""
    run = ring(tmp_path, *[(0, 0, "a")] * 3, batching={}, fleet__robot__capacity=2, **WHOLE)
    assert trips(run) == [[0, 1], [2]]
    assert delivered(run) == [(0, 74), (1, 74), (2, 74 + 50 + 4 + 30 + 6)]


def test_lines_of_no_order_are_totes_of_their_own(tmp_path):
    run = ring(tmp_path, (0, 0, ""), (0, 0, ""), batching={"orders": 2}, **WHOLE)
    assert delivered(run) == [(0, 74), (1, 80)]


def test_orders_wait_until_there_are_enough(tmp_path):
    """The second comes at 40; nothing more is to come when the third does."""
    run = ring(tmp_path, (0, 0, "a"), (40, 0, "b"), (90, 0, "c"), batching={"orders": 2})
    assert trips(run) == [[0, 1], [2]]
    assert [row.time for row in run.history.rows("assigned")][:2] == [40, 40]


def test_orders_wait_no_longer_than_the_window(tmp_path):
    run = ring(tmp_path, (0, 0, "a"), (40, 0, "b"), (90, 0, "c"), batching={"orders": 3, "window": 50})
    assert trips(run) == [[0, 1], [2]]
    assert [row.time for row in run.history.rows("assigned")][:2] == [50, 50]


def test_order_that_does_not_fit_any_more_goes_on_the_next_tour_whole(tmp_path):
    """Three of a and two of b are more than 4, and so are five of c by themselves."""
    lines = [(0, 0, "a")] * 3 + [(0, 0, "b")] * 2 + [(0, 0, "c")] * 5
    run = ring(tmp_path, *lines, batching={"orders": 2})
    assert trips(run) == [[0, 1, 2], [3, 4], [5, 6, 7, 8], [9]]


def test_what_is_put_away_is_handed_over_line_by_line():
    flow = {"from": "pack", "to": "storage", "arrivals": {"poisson": 10}, "unload_per": "order"}
    with pytest.raises(ModelError, match="each line is put away at a storage place of its own, expected line"):
        dw.load(RING, {"tasks.flows": {"flow": flow}})


@pytest.mark.parametrize("wrong", [{"orders": 0}, {"window": -1}])
def test_policy_refuses_what_makes_no_sense(wrong):
    flow = {"from": "storage", "to": "pack", "arrivals": {"poisson": 10}}
    changes = {"tasks.flows": {"flow": flow}, "run.length": 9, "policies.batching": {"name": "by-order", **wrong}}
    with pytest.raises((ModelError, PolicyError), match=next(iter(wrong))):
        dw.load(RING, changes)


@pytest.mark.usefixtures("brief_probes")
def test_check_says_that_single_lines_are_no_totes():
    flow = {"from": "storage", "to": "pack", "arrivals": {"poisson": 10}, "lines": 2, "unload_per": "order"}
    single = {"tasks.flows": {"flow": flow}, "run.length": 7200}
    several = {"fleet.robot.capacity": 4, "policies.batching": "by-order"}
    places = [
        [item.place for item in dw.check(dw.load(RING, {**single, **more})).findings if item.code == "CHANGES_NOTHING"]
        for more in ({}, several)
    ]
    assert places == [["tasks.flows.flow.unload_per"], []]
