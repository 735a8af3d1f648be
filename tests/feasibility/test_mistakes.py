"""Ordinary mistakes of a planner, in a warehouse of his own: each is refused or named, with its cure."""

from pathlib import Path

import pytest

import desim_warehouse as dw
from desim_warehouse import CheckError, LayoutError, ModelError
from desim_warehouse.findings import CODES
from desim_warehouse.questions.check import check
from tests.daily import some

pytestmark = pytest.mark.usefixtures("brief_probes")

PLANNER = Path(__file__).with_name("planner.yaml")
FOUR = {"policies.charging": "four-thresholds"}
PARKING = ["B", "C", "D", "E", "F", "G"]

MISTAKES = {
    # lengths and speeds
    "radius in mm": ({"fleet.robot.radius": 500}, "ROBOT_WIDER_THAN_AISLE"),
    "aisles too narrow": ({"layout.blocks.aisle_width": 0.9}, "ROBOT_WIDER_THAN_AISLE"),
    "cross aisles too narrow": ({"layout.blocks.cross_aisle_width": 0.9}, "ROBOT_WIDER_THAN_AISLE"),
    "floor in mm": ({"layout.blocks.aisle_width": 3000, "layout.blocks.goods_size": 1200}, "FLOOR_SIZE"),
    "all in m, unit mm": ({"units.length": "mm"}, "FLOOR_SIZE"),
    "speed in m, unit mm": ({"units.length": "mm"}, "SLOW"),
    "speed in km/h": ({"fleet.robot.speed": 5.4}, "FAST"),
    "speed in m/min": ({"fleet.robot.speed": 90}, "FAST"),
    "margin in mm": ({"fleet.robot.margin": 200}, "SHORT_EDGES"),
    # times
    "length of the run in hours": ({"run": {"length": 8}}, "SHORT_RUN"),
    "length of the run in minutes": ({"run": {"length": 480, "warm_up": 60}}, "SHORT_RUN"),
    "warm-up beyond the end": ({"run.warm_up": 30000}, ModelError),
    "warm-up takes nearly all": ({"run.warm_up": 28700}, "SHORT_RUN"),
    "loading in ms": ({"tasks.load_time": 15000}, "LONG_HANDLING"),
    "unloading in ms": ({"tasks.unload_time": 30000}, "LONG_HANDLING"),
    "due in minutes": ({"tasks.goods.due_within": 15}, "DUE_TOO_SOON"),
    # demand
    "demand a day for an hour": ({"tasks.goods.poisson": 4800}, "DEMAND_ABOVE_FLEET"),
    "demand a second for an hour": ({"tasks.goods.poisson": 0.055}, "SHORT_RUN"),
    "more than the stations serve": ({"tasks.goods.poisson": 300}, "DEMAND_ABOVE_STATIONS"),
    "too few robots": ({"fleet.size": 4}, "DEMAND_ABOVE_FLEET"),
    "too few places at the stations": ({"layout.stations.packing.places": 1}, "DEMAND_ABOVE_FLEET"),
    "more servers than places": ({"layout.stations.packing.servers": 5}, ModelError),
    "unloading in the aisle": ({"layout.stations": {}}, "UNLOAD_IN_LANE"),
    "a station that is not there": ({"tasks.unload_at": ["Z"]}, ModelError),
    # bays
    "too few places to park": ({"layout.bays.parking.places": 2}, "BAY_CROWDED"),
    "robots start where no bay is": ({"fleet.start": ["I"]}, "START_WITHOUT_BAY"),
    "one-way rules without a way back": (
        {"layout.blocks.directions": {"rows": ["east"] * 3, "columns": ["south"] * 8}},
        "UNREACHABLE",
    ),
    # batteries
    "zero chargers": ({"layout.bays.chargers.chargers": 0}, "NO_CHARGER"),
    "parking without chargers, default policies": (
        {"policies": {}, "battery.charge_rate": 0.009},
        "REST_FLAT",
    ),
    "two chargers": (
        {**FOUR, "layout.bays.chargers.at": ["A", "H"], "layout.bays.parking.at": PARKING},
        "CHARGERS_SHORT",
    ),
    "charge rate a minute too low": ({"battery.charge_rate": 0.0003}, "CHARGERS_SHORT"),
    "charge rate an hour": ({"battery.charge_rate": 72}, "FAST_CHARGE"),
    "consumption an hour": ({"battery.consumption": 18}, "BATTERY_TOO_SMALL"),
    "capacity as a share": ({"battery.capacity": 1, "battery.threshold": 0.9}, "BATTERY_TOO_SMALL"),
    "threshold as a share": ({"battery.threshold": 0.25}, "THRESHOLD_TOO_LOW"),
    "threshold above capacity": ({"battery.threshold": 120}, ModelError),
}


def test_there_are_36_of_them_and_the_warehouse_itself_is_sound():
    assert len(MISTAKES) == 36
    [finding] = check(dw.load(PLANNER)).findings
    assert (finding.code, finding.level) == ("START_ENERGY", "note")  # all batteries start full
    assert check(dw.load(PLANNER, {"fleet.start_energy": "settled"})).findings == []


@pytest.mark.parametrize("mistake", some(MISTAKES, 2))
def test_a_mistake_is_named_with_its_cure(mistake):
    changes, code = MISTAKES[mistake]
    if code is ModelError:
        with pytest.raises(ModelError, match="expected"):
            dw.load(PLANNER, changes)
        return
    model = dw.load(PLANNER, changes)
    report = check(model)
    findings = {item.code: item for item in report.findings}
    assert code in findings
    assert findings[code].cure
    if CODES[code].level == "error":
        kind = LayoutError if report.calculation is None else CheckError
        with pytest.raises(kind) as error:
            dw.simulate(model)
        assert findings[code].problem in error.value.problems
