"""What pickers can do by the quick estimate, worked out by hand."""

from collections import Counter
from functools import partial

import pytest

import desim_warehouse as dw
from desim_warehouse.feasibility.loads import loads
from desim_warehouse.feasibility.mistakes import clashes
from desim_warehouse.feasibility.parts import PickerLoad
from desim_warehouse.feasibility.pickers import picker_load
from desim_warehouse.questions.check.words import sentences
from desim_warehouse.run.backlog import Backlog
from desim_warehouse.run.probe import log_of, shares_of_flows
from desim_warehouse.run.quick import estimate, measured
from tests.world.pick_assist import hall
from tests.world.test_pickers import RING

STORED = {"from": "storage", "to": "packing", "arrivals": {"poisson": 60}}
PUT = {"from": "packing", "to": "storage", "arrivals": {"poisson": 20}, "unload_time": 3}
FLOWS = {"tasks": {"flows": {"out": STORED, "in": PUT}, "load_time": 7, "unload_time": 4}, "run.length": "1 h"}


def test_walk_between_two_places_is_the_mean_of_all_pairs():
    """Places at 5, 10 and 15: of nine pairs four are 5 apart and two 10, at a speed of 0.5."""
    load = picker_load(dw.load(RING))
    assert (load.count, load.open, load.share, load.pick) == (1, 1.0, 1.0, 7.0)
    assert load.walks == pytest.approx([40 / 9 / 0.5], rel=0.1)
    assert load.most == 1 / 7
    assert load.least == 1 / (7 + load.walks[0])


def test_nearest_of_two_is_nearer():
    """Of two places the nearer is 25/9 away from either end of the lane, and 20/9 from its middle."""
    one, two = picker_load(dw.load(RING, {"pickers.count": 2})).walks
    assert one == pytest.approx(40 / 9 / 0.5, rel=0.1)
    assert two == pytest.approx(70 / 27 / 0.5, rel=0.1)


def test_stops_of_a_task_are_those_of_the_flows_that_need_a_picker():
    """Of 80 tasks 60 are picked for 7 and 20 put away for 3; or 60 of 80 with pickers for what goes out."""
    both, out = picker_load(dw.load(RING, FLOWS)), picker_load(dw.load(RING, {**FLOWS, "pickers.flows": ["out"]}))
    assert (both.share, both.pick) == (pytest.approx(1), pytest.approx((60 * 7 + 20 * 3) / 80))
    assert (out.share, out.pick) == (pytest.approx(0.75), pytest.approx(7))


@pytest.mark.parametrize(("rate", "busy"), [(0.01, 0.10), (0.04, 0.8), (0.15, 1.0), (0.3, 1.5)])
def test_fewer_free_pickers_walk_farther(rate, busy):
    """Two pickers, 10 to pick, 10 to walk where both are free and 30 where one is; they do 0.2 without a step."""
    assert PickerLoad(2, 1.0, 1.0, 10.0, (30.0, 10.0)).busy(rate) == pytest.approx(busy)


@pytest.mark.usefixtures("brief_probes")
def test_demand_beyond_pickers_is_measured_by_the_walks_among_robots_that_they_keep_waiting():
    """Of three robots two wait, the nearer 70/27 away: at 0.1, with 30 to pick, 56 for each of 100 lines an hour.

    A robot takes 60 for the way round, 30 and 4, and waits 44 for a picker who has nothing else to do: three do 78.
    """
    changes = {"tasks.goods": {"poisson": 100}, "tasks.load_time": 30, "fleet.size": 3, "run.length": "1 h"}
    model = dw.load(RING, {**changes, "pickers.speed": 0.1})
    quick = estimate(model)
    assert quick.pickers.crowded == pytest.approx(70 / 27 / 0.1, rel=0.1)
    robots, pickers = (one.mean for one in loads(model, quick) if one.group.kind in {"robots", "pickers"})
    assert (robots, pickers) == (pytest.approx(100 / 78, rel=0.1), pytest.approx(100 * 56 / 3600, rel=0.1))
    assert "The pickers are busiest: demand is 1" in " ".join(sentences(model, quick))


def test_check_says_what_pickers_can_do_and_that_they_are_busiest():
    changes = {"tasks.goods": {"saturated": 8}, "fleet.size": 3, "run.length": "1 h", "pickers.speed": 0.1}
    model = dw.load(RING, {**changes, "layout.stations.packing.places": 20})
    quick = estimate(model)
    text = " ".join(sentences(model, quick))
    assert "1 picker, 3 storage places" in text
    assert "Pickers: 1 can pick" in text
    assert "to 514 lines an hour; the more robots wait for them, the less they walk." in text
    assert quick.limits["the pickers"] == 1 / 7
    assert quick.knee[1] == "the pickers"
    assert max(loads(model, quick), key=lambda load: load.mean).group.name == "pickers"


@pytest.mark.parametrize(("speed", "is_named"), [(0.1, False), (100, True)])
def test_a_number_of_robots_beyond_which_pickers_are_the_limit_is_named_only_where_they_hardly_walk(speed, is_named):
    """A walk between random places takes 30 of 37 at 0.1, and less with more robots that wait; at 100 it takes none.

    The stations have few slots. These are not the limit, although they let through less than pickers who never walk.
    """
    changes = {"tasks.goods": {"poisson": 480}, "fleet.size": 3, "run.length": "1 h", "pickers.speed": speed}
    model = dw.load(RING, {**changes, "layout.stations.packing.places": 6 if speed < 1 else 20})
    quick = estimate(model)
    text = " ".join(sentences(model, quick))
    assert quick.narrowest == "the pickers"
    assert quick.pickers_walk_less != is_named
    assert ("the pickers are the limit" in text) == is_named
    assert ("Robots: a run tells how many are enough for 480" in text) != is_named
    assert "slots" not in text


HALL = hall(4, 6, {"at": ["L", "N"], "places": 12}, 30, {"length": 4200, "warm_up": 600})


def test_orders_of_a_probe_become_known_whole():
    """A robot takes 3 lines of an order; 4 that are known would leave a tour of 1 otherwise."""
    model = dw.load(HALL, {"tasks.flows.picks.lines": 3, "run.length": 1e9, "run.warm_up": 0})
    source = {"flows": ("picks",), "count": 20, "waiting": 4, "in_turn": False, "pause": 0.0}
    log = log_of(model, partial(Backlog, rates=shares_of_flows(model), **source))
    released = Counter(row.time for row in log.of("released"))
    assert sum(released.values()) == 60
    assert {tasks % 3 for tasks in released.values()} == {0}


CHANGES = (
    {},
    {"pickers.count": 2, "pickers.stay": "order"},
    {"fleet.size": 4, "layout.aisles": "narrow"},
    {"calendars.shift": {"between": [[0, 2100]]}, "pickers.hours": "shift", "run.warm_up": 0},
)
WHOLE = [pytest.param(changes, marks=pytest.mark.long) for changes in CHANGES]
"""With whole probes."""


@pytest.mark.parametrize("changes", [CHANGES[0], CHANGES[1], CHANGES[3], *WHOLE])
@pytest.mark.usefixtures("brief_probes")
def test_range_of_a_check_holds_what_a_run_does(changes):
    model = dw.load(HALL, changes)
    least, most = measured(model).range
    assert least <= dw.simulate(model, 1).kpis["throughput_per_hour"] / model.units.hour <= most


@pytest.mark.parametrize(("flows", "part"), [({}, 0.25), ({"pickers.flows": ["out"]}, 1.0)])
def test_robots_work_in_the_hours_of_pickers_where_each_task_needs_one(flows, part):
    """A quarter of an hour; 60 of 80 tasks are picked, and those put away alone go on."""
    hours = {"calendars.shift": {"between": [[0, 900]]}, "pickers.hours": "shift"}
    quick = estimate(dw.load(RING, {**FLOWS, **hours, **flows}))
    assert quick.on_duty == part
    assert quick.limits["the pickers"] == pytest.approx(0.25 / quick.pickers.pick / quick.pickers.share)


@pytest.mark.parametrize(
    ("flows", "warned"), [({}, True), ({"pickers.flows": ["out"]}, True), ({"pickers.flows": ["in"]}, False)]
)
def test_orders_that_come_when_pickers_have_gone_home_are_late_with_any_fleet(flows, warned):
    """They leave after 15 of 60 minutes; due within 5, all that come until 55 are late: 40 of 60 minutes.

    Where pickers are for another flow alone, these go on without them.
    """
    changes = {"calendars.shift": {"between": [[0, 900]]}, "pickers.hours": "shift", "fleet.size": 3}
    model = dw.load(RING, {**FLOWS, **changes, **flows}).replace({"tasks.flows.out.due_within": 300})
    texts = {one.code: one.text for one in clashes.warnings(model, model.floor)}
    assert ("BREAK_BEYOND_DUE" in texts) == warned
    assert not warned or texts["BREAK_BEYOND_DUE"] == (
        "no robot or no picker works, or no station is open, for up to 45 min; tasks that arrive in the first 40 min "
        "of this break cannot be done within 5 min, with any fleet (66.67 % of the time)"
    )


@pytest.mark.usefixtures("brief_probes")
def test_pickers_who_never_come_are_an_error_and_not_an_endless_search():
    never = {"calendars.late": {"between": [["2 h", "3 h"]]}, "pickers.hours": "late"}
    assert "NEVER_OPEN" in {finding.code for finding in dw.check(dw.load(HALL, never)).findings}
    assert measured(dw.load(HALL, never)).knee[1] == "the pickers"
