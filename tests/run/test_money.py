"""The year's cost and the cost of a task, worked out by hand, and where studies use them."""

import json
import math

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import ModelError
from desim_warehouse.model.facts.costs import year_of
from desim_warehouse.study.fleet import Designs
from desim_warehouse.study.procedures import race
from tests.world import test_pickers
from tests.world.test_flows import RING

PRICES = {
    "hours": 4000,
    "robot": 10000,
    "kinds": {"truck": 25000},
    "charger": 1200,
    "energy": 0.002,
    "station_hour": 20,
    "late_order": 5,
}
SETTING = {
    "tasks.flows": {
        "flow": {
            "from": "dock",
            "to": "pack",
            "arrivals": {"schedule": [{"at": 0, "tasks": 2}, {"at": 1740}]},
            "due_within": 100,
        }
    },
    "fleet.size": 3,
    "fleet.kinds": {"truck": {"count": 1}},
    "battery": {"capacity": 10000, "threshold": 100, "consumption": 1, "charge_rate": 5},
    "layout.bays.home.chargers": 2,
    "run.length": 1800,
    "prices": PRICES,
}


def test_the_year_and_the_task_by_hand():
    run = dw.simulate(dw.load(RING, SETTING))
    # half an hour is counted; of the tasks at 0 the first is delivered at 24 + 40 + 6 = 70, the second, loaded four
    # later in the same dock, at 74 + 6 = 80; the third, released at 1740, is under way at the end
    assert run.kpis["tasks"] == 2
    energy = run.kpis["energy"] / 0.5
    year = 25000 + 2 * 10000 + 2 * 1200 + 4000 * (0.002 * energy + 2 * 20)
    assert run.kpis["annual_cost"] == pytest.approx(year)
    assert run.kpis["cost_per_task"] == pytest.approx(year / (2 / 0.5 * 4000))
    assert run.kpis["cost"] == pytest.approx(run.kpis["distance"] + run.record.end + run.S)  # the paper's stays


def test_what_is_late_costs():
    plain = dw.simulate(dw.load(RING, SETTING)).kpis["annual_cost"]
    flow = {**SETTING["tasks.flows"]["flow"], "due_within": 55}
    late = dw.simulate(dw.load(RING, {**SETTING, "tasks.flows": {"flow": flow}})).kpis["annual_cost"]
    # the first two, and the third, due at 1795 and not delivered: 3 in half an hour
    assert late - plain == pytest.approx(4000 * 5 * 3 / 0.5, rel=1e-3)


def test_an_order_is_late_once(tmp_path):
    (tmp_path / "orders.csv").write_text("release,due,order\n0,10,a\n0,10,a\n0,500,b\n", encoding="utf-8")
    flow = {"from": "dock", "to": "pack", "arrivals": {"orders": {"file": str(tmp_path / "orders.csv")}}}
    only = {"hours": 1000, "late_order": 7}
    run = dw.simulate(dw.load(RING, {"tasks.flows": {"day": flow}, "prices": only}))
    assert run.kpis["annual_cost"] == pytest.approx(1000 * 7 * 1 / (run.T / 3600))


def test_without_prices_there_is_no_cost():
    kpis = dw.simulate(dw.load(RING, {**SETTING, "prices": None})).kpis
    assert not {"annual_cost", "cost_per_task"} & kpis.keys()
    idle = {
        **SETTING,
        "tasks.flows": {"flow": {**SETTING["tasks.flows"]["flow"], "arrivals": {"schedule": [{"at": 1799}]}}},
    }
    assert math.isnan(dw.simulate(dw.load(RING, idle)).kpis["cost_per_task"])


def test_a_price_for_a_kind_that_there_is_not():
    with pytest.raises(
        ModelError, match=r"prices.kinds.lorry: no such kind of robot .got 'lorry'., expected one of truck"
    ):
        dw.load(RING, {**SETTING, "prices.kinds": {"lorry": 1}})


@pytest.mark.parametrize(("late", "robots"), [(0, 2), (5, 4)])
def test_the_best_fleet_depends_on_what_lateness_costs(late, robots, tmp_path):
    arrivals = {"tasks.flows.flow.arrivals": {"poisson": 60}, "run.length": 3600, "log": "tasks"}
    changes = {**SETTING, **arrivals, "fleet.kinds": {}, "prices.kinds": {}, "prices.late_order": late}
    (tmp_path / "model.yaml").write_text(json.dumps(dw.load(RING, changes).content()), encoding="utf-8")
    study = dw.Study(tmp_path / "model.yaml", {"fleet.size": [2, 4]})
    study.plan = study.plan.unreplicated()
    choice = race(study, "cost_per_task", 0.01, search=dw.Search(first=5, cap=20))
    assert str(choice.point) == f"fleet.size={robots}"
    assert not choice.maximise


def test_fewest_robots_are_sized_by_a_cost():
    changes = {**SETTING, "tasks.flows.flow.arrivals": {"poisson": 60}, "run.length": 3600, "log": "tasks"}
    base = dw.load(RING, {**changes, "fleet.kinds": {}, "prices.kinds": {}, "prices.late_order": 0})
    study = dw.Study(base, {"fleet.size": [2, 4]})
    study.plan = study.plan.unreplicated()
    assert dw.size(study, "cost_per_task <= 100", search=dw.Search(first=5, cap=10)).smallest == 2


def test_pickers_are_paid_for_their_hours():
    """Two at 30 an hour, at work for half of 1,000 hours."""
    hours = {"calendars": {"half": {"every": 200, "lasts": 100}}, "pickers": {"count": 2, "speed": 1, "hours": "half"}}
    model = dw.load({**test_pickers.RING, **hours}, {"run.length": 400, "prices": {"hours": 1000, "picker_hour": 30}})
    assert year_of(model) == pytest.approx(2 * 30 * 500)


def test_people_are_paid_for_the_time_that_is_counted_however_long_the_run_may_last():
    """Pack is open every other 100; the run ends with its work in the first 100: all of its time is paid."""
    flow = {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 0, "tasks": 2}]}}
    prices = {"hours": 1000, "station_hour": 20}
    model = dw.load(RING, {"tasks.flows": {"flow": flow}, "prices": prices, "fleet.size": 3})
    hours = {"calendars": {"half": {"every": 200, "lasts": 100}}, "layout.stations.pack.hours": "half"}
    for length in (None, 300, 600):
        run = dw.simulate(model.replace({**hours, "run.length": length}))
        assert run.record.end < 100
        assert run.kpis["annual_cost"] == pytest.approx(2 * 20 * 1000)  # with dock, always open


def test_chargers_that_nobody_uses_and_nobody_counted_cost_nothing():
    # without batteries: by default each of the 4 slots has a charger, which is there only if the model counts them
    prices = {"hours": 1, "robot": 1000, "charger": 100}
    model = dw.load(RING, {"prices": prices, "tasks.flows": SETTING["tasks.flows"], "layout.bays.home.places": 4})
    assert model.battery is None
    robots = 1000 * model.fleet.size
    assert year_of(model) == Designs(model).cost((model.fleet.size, 0)) == robots
    counted = model.replace({"layout.bays.home.chargers": 2})
    assert year_of(counted) == robots + 200
