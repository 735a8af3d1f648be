"""Goods to person before a run: ordinary mistakes are named, and the quick estimate counts lines."""

import pytest

import desim_warehouse as dw
from desim_warehouse.feasibility.mistakes import unused
from desim_warehouse.feasibility.pods import driven
from desim_warehouse.findings import CODES
from desim_warehouse.folders import gallery
from desim_warehouse.model.facts.demand import arrival_rate
from desim_warehouse.questions.check import check
from desim_warehouse.run.quick import estimate
from tests.daily import some

pytestmark = pytest.mark.usefixtures("brief_probes")

HALL = gallery()["goods-to-person"]
MANY = {"fleet.size": 20, "layout.bays.parking.places": 20}
CLASSES = {"classes": [{"share": 0.2, "demand": 0.8}, {"share": 0.8, "demand": 0.2}]}

MISTAKES = {
    "popularity of places": ({"tasks.popularity": CLASSES}, "CHANGES_NOTHING", "tasks.popularity"),
    "popularity of a flow": (
        {"tasks.flows.picks.from": {"popularity": CLASSES}},
        "CHANGES_NOTHING",
        "tasks.flows.picks.from.popularity",
    ),
    "two pods on a robot": ({"fleet.robot.capacity": 2}, "CHANGES_NOTHING", "fleet.robot.capacity"),
    "priorities for allocation": (
        {"tasks.flows.picks.priority": 3, "policies.allocation": "earliest-due"},
        "CHANGES_NOTHING",
        "tasks.flows.picks.priority",
    ),
    "pods change in no time": ({"pods.change_time": 0}, "UNUSUAL", "pods.change_time"),
    "fewer robots than stations": ({"fleet.size": 1}, "MORE_THAN_FIT", "fleet.size"),
    "too many pods at the stations": (
        {**MANY, "layout.stations.picking.places": 9},
        "PODS_QUEUE",
        "layout.stations.picking.places",
    ),
    "stock that nobody replenishes": ({"pods.stock": 1, "run.length": "8 h"}, "STOCK_RUNS_OUT", "pods.stock"),
    "more lines than pickers pick": (
        {"tasks.flows.picks.arrivals.poisson": 300},
        "DEMAND_ABOVE_STATIONS",
        "layout.stations: r5c1",
    ),
}


def test_the_hall_itself_is_sound():
    assert check(dw.load(HALL)).findings == []


@pytest.mark.parametrize("mistake", some(MISTAKES, 3))
def test_a_mistake_is_named(mistake):
    changes, code, place = MISTAKES[mistake]
    findings = [item for item in check(dw.load(HALL, changes)).findings if item.code == code]
    assert [(item.place, item.level) for item in findings if item.place == place] == [(place, CODES[code].level)]


def test_bundles_that_bring_as_much_as_is_picked_make_stock_last():
    # 450 lines an hour, and 90 bundles of 6 units: 540
    flows = {"picks": HALL_PICKS, "bundles": {"from": "picking", "to": "storage", "arrivals": {"poisson": 90}}}
    flows["bundles"]["stop_time"] = 5
    changes = {"pods.stock": 1, "run.length": "8 h", "tasks.flows": flows}
    by_bundle = {bundle: codes({**changes, "pods.bundle": bundle}) for bundle in (1, 6)}
    assert "STOCK_RUNS_OUT" in by_bundle[1]
    assert "STOCK_RUNS_OUT" not in by_bundle[6]


HALL_PICKS = {"from": "storage", "to": "picking", "lines": [1, 4], "arrivals": {"poisson": 180}, "stop_time": 5}


def codes(changes):
    return {item.code for item in check(dw.load(HALL, changes)).findings}


def test_places_are_no_limit_to_raise_where_few_pods_are_enough():
    """More slots would spread lines over more visits: the note that more let more robots work is left out."""
    assert "STATION_PLACES" not in codes({**MANY, "layout.stations.picking.places": 2})


def test_what_is_of_single_loads_is_not_said():
    """Visits are called when a robot is free, so there are none to choose from, and no item has a place."""
    facts = " ".join(check(dw.load(HALL, {"tasks.popularity": CLASSES})).facts)
    assert "to choose from" not in facts
    assert "nearer" not in facts


def test_stations_are_limited_by_their_pickers():
    """Two pickers, a line in 10 s: 720 an hour, of which 450 are 62.5 %."""
    calculation = estimate(dw.load(HALL))
    assert calculation.station_capacity * 3600 == pytest.approx(720)
    assert [item.busy for item in calculation.stations] == pytest.approx([0.625, 0.625])
    assert calculation.places_limit["picking at r5c1"] * 3600 == pytest.approx(720)


def test_priorities_are_for_a_pod_policy_of_your_own(tmp_path):
    """Allocation chooses a robot for a pod that is called already: only who calls it chooses among lines."""
    (tmp_path / "mine.py").write_text(
        "class Urgent:\n"
        "    def choose(self, call):\n"
        "        return max(call.pods, key=lambda pod: max(line.priority for line in pod.lines)).number\n"
    )
    urgent = {"tasks.flows.picks.priority": [{"priority": 1, "share": 0.1}, {"priority": 0, "share": 0.9}]}
    for allocation in ("nearest", "earliest-due"):
        assert ignored({**urgent, "policies.allocation": allocation}) == [
            "priorities are given, and policies.pod: most-lines does not look at them"
        ]
    assert ignored({**urgent, "policies.pod": f"{tmp_path / 'mine.py'}:Urgent"}) == []


def ignored(changes):
    model = dw.load(HALL, changes)
    return [item.text for item in unused.warnings(model, model.floor)]


@pytest.mark.parametrize(("every", "tasks"), [(20, 1), (60, 3), (180, 9)])
@pytest.mark.parametrize("lines", [1, 2.5, 9])
def test_a_schedule_asks_for_as_many_lines_in_any_batches(every, tasks, lines):
    """180 lines an hour of two stations: 1 every 20 s is no visit for each line at each of them."""
    schedule = [{"at": every * n, "tasks": tasks} for n in range(3600 // every)]
    picks = {"from": "storage", "to": "picking", "arrivals": {"schedule": schedule}, "stop_time": 5}
    visits = driven(dw.load(HALL, {"tasks.flows": {"picks": picks}, "run.length": "1 h"}), lines)
    assert arrival_rate(visits) * lines * 3600 == pytest.approx(180)


def test_a_short_file_asks_for_its_lines_where_visits_serve_many(tmp_path):
    """10 lines in 5 min are 120 an hour, and 1.3 visits an hour where each serves 93: not one in 5 min."""
    (tmp_path / "orders.csv").write_text("release,quantity\n0,9\n300,1\n")
    picks = {"from": "storage", "to": "picking", "arrivals": {"orders": {"file": str(tmp_path / "orders.csv")}}}
    changes = {"tasks.flows": {"picks": {**picks, "stop_time": 5}}, "run.length": None, "run.warm_up": 0}
    assert arrival_rate(driven(dw.load(HALL, changes), 93)) * 3600 == pytest.approx(120 / 93)


@pytest.mark.parametrize(("least", "less"), [(3, 1.5), pytest.param(1, 2, marks=pytest.mark.long)])
def test_energy_is_said_by_line(least, less):
    """As many lines as a visit has share what it draws."""
    few, many = (estimate(dw.load(HALL, {"pods.orders": orders})) for orders in (least, 12))
    assert many.power.task < few.power.task / less


@pytest.mark.long
def test_the_policy_that_the_model_names_is_estimated():
    """Many lines wait: the pod with most of them saves visits, so that fewer robots are needed."""
    many = {"tasks.flows.picks.arrivals": {"saturated": 100}, "tasks.flows.picks.lines": 1, "run.length": "1 h"}
    models = [dw.load(HALL, {**many, "policies.pod": name}) for name in ("random", "most-lines")]
    random, most = (check(model).calculation for model in models)
    assert most.pile_on.many > 1.2 * random.pile_on.many
    for model, calculation in zip(models, (random, most), strict=True):
        done = dw.simulate(model, 2).kpis
        assert done["throughput_per_hour"] == pytest.approx(calculation.capacity * 3600, rel=0.1)
        assert done["pile_on"] == pytest.approx(calculation.pile_on.many, rel=0.1)
