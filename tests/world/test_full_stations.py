"""Decisions that can give nobody anything, as every station is full: the policy need not be asked."""

from collections import Counter
from functools import cache

import pytest

import desim_warehouse as dw
from desim_warehouse.policies.allocation import EarliestDue, Hungarian, InOrder, Nearest, NearestAging
from desim_warehouse.world.places.openings import Openings
from desim_warehouse.world.places.stations import Stations
from tests.daily import some

pytestmark = pytest.mark.usefixtures("brief_probes")

FULL = {
    "fleet.size": 6,
    "tasks.goods": {"poisson": 900, "due_within": 600},
    "layout.stations.packing.places": 1,
    "tasks.unload_time": 60,
    "run": {"length": 1500, "warm_up": 0},
    "log": "all",
}

OPEN_BY_DAY = {"calendars": {"day": {"open": ["00:00-12:00"]}}, "layout.stations.packing.hours": "day"}


@cache
def drafted():
    from desim_warehouse.draft import Draft, draft
    from desim_warehouse.model.parse import read_yaml

    model = dw.Model.model_validate(read_yaml(draft(Draft((16, 14), orders=60)), "draft").data)
    return model.replace({"fleet.start_energy": 0.9})


@pytest.mark.slow
@pytest.mark.parametrize("policy", some([Nearest, InOrder, NearestAging, EarliestDue, Hungarian], 4))
def test_it_is_asked_less_often_and_nothing_else_changes(policy, monkeypatch, tmp_path):
    names = {InOrder: "in-order", NearestAging: "nearest-aging", EarliestDue: "earliest-due"}
    model = drafted().replace({**FULL, "policies.allocation": names.get(policy, policy.__name__.lower())})
    asked, assign = [], policy.assign

    def counted(self, situation):
        asked.append(situation.time)
        return assign(self, situation)

    monkeypatch.setattr(policy, "assign", counted)
    rows = dw.simulate(model, 1).record.rows
    few, asked[:] = len(asked), []
    monkeypatch.setattr(policy, "gives_only", False)
    assert dw.simulate(model, 1).record.rows == rows
    assert few < 0.7 * len(asked)


@pytest.fixture
def asked(monkeypatch):
    """How often it is asked whether a station has room for a task, and whether it is open when the robot comes."""
    asked = Counter()

    def count(kind, method):
        original = getattr(kind, method)

        def counted(*args):
            asked[method] += 1
            return original(*args)

        monkeypatch.setattr(kind, method, counted)

    count(Stations, "has_room")
    count(Openings, "admit")
    return asked


@pytest.mark.slow
def test_a_station_with_hours_asks_no_more_of_each_task_when_the_list_is_longer(asked):
    """Six robots before one station that closes at night: with four times the tasks, four times the questions."""
    questions = []
    for rate in (500, 2000):
        asked.clear()
        model = drafted().replace({**FULL, **OPEN_BY_DAY, "tasks.goods": {"poisson": rate}, "run.length": 300})
        run = dw.simulate(model)
        questions.append(asked.total() / len([*run.history.rows("released")]))
    assert 1 < questions[1] < 1.5 * questions[0]


def test_of_a_station_with_hours_and_room_only_those_tasks_are_asked_that_the_policy_reads(asked):
    """Six robots are fewer than the tasks, and the policy considers 20: four times the tasks, the same questions."""
    questions = []
    for tasks in (100, 400):
        asked.clear()
        changes = {
            **OPEN_BY_DAY,
            "fleet.size": 6,
            "tasks.goods": {"random": tasks},
            "layout.stations.packing.places": 20,
            "policies.allocation": {"name": "nearest", "candidates": 20},
            "run": {"length": 400, "warm_up": 0},
        }
        assert len([*dw.simulate(drafted().replace(changes)).history.rows("assigned")]) > 20
        questions.append(asked["admit"])
    assert 100 < questions[1] < 1.2 * questions[0]
