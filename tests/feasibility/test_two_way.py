"""What must be so on two-way lanes, where robots come to goods from either end."""

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.check import check

pytestmark = pytest.mark.usefixtures("brief_probes")

LANE = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0]},
        "edges": [{"from": "A", "to": "B", "two_way": True}],
        "storage": [{"edge": ["A", "B"], "offset": 5}],
        "bays": {"home": {"at": ["B"], "places": 1, "chargers": 1}},
        "stations": {"pack": {"at": ["A"], "places": 1}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.3, "speed": 1}},
    "battery": {"capacity": 41, "threshold": 30, "consumption": 1, "charge_rate": 10},
}
HANDLING = {"load_time": 0, "unload_time": 0}
GOODS = {**HANDLING, "goods": [0, 0], "unload_at": ["pack"]}
OUT = {"from": "storage", "to": "pack", "arrivals": {"schedule": [{"at": 0, "tasks": 2}]}}
FLOWS = {**HANDLING, "flows": {"out": OUT}}
"""A robot at B drives to A, with the load from 15 on, and back: 40, and never from A to the good."""


@pytest.mark.parametrize("tasks", [GOODS, FLOWS])
def test_a_battery_that_lasts_for_the_drive_from_the_nearer_end_is_enough(tasks):
    model = dw.load(LANE, {"tasks": tasks})
    assert "BATTERY_TOO_SMALL" not in {item.code for item in check(model).findings}
    assert dw.simulate(model).kpis["tasks"] == 2
    small = check(model.replace({"battery.capacity": 39})).errors
    assert small[0].text.endswith("and to a charger or home; a battery gives 39")
    assert " draws at least 40" in small[0].text


def test_a_due_time_that_can_be_kept_from_the_nearer_end_is_not_too_soon():
    """From the good to A it is 5, and 35 by way of B."""
    for tasks in (
        {**HANDLING, "goods": {"saturated": 1, "due_within": 6}, "unload_at": ["pack"]},
        {**HANDLING, "flows": {"out": {**OUT, "due_within": 6}}},
    ):
        model = dw.load(LANE, {"tasks": tasks, "battery": None, "run.length": 1000})
        assert "DUE_TOO_SOON" not in {item.code for item in check(model).findings}
    late = model.replace({"tasks.flows.out.due_within": 4})
    assert "DUE_TOO_SOON" in {item.code for item in check(late).findings}
