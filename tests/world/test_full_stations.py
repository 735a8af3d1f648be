"""Decisions that can give nobody anything, as every station is full: the policy need not be asked."""

import pytest

import desim_warehouse as dw
from desim_warehouse.policies.allocation import EarliestDue, InOrder, Nearest, NearestAging
from desim_warehouse.policies.assignment import Hungarian

FULL = {
    "fleet.size": 6,
    "tasks.goods": {"poisson": 900, "due_within": 600},
    "layout.stations.packing.places": 1,
    "tasks.unload_time": 60,
    "run": {"length": 1500, "warm_up": 0},
    "log": "all",
}


@pytest.mark.parametrize("policy", [InOrder, Nearest, NearestAging, EarliestDue, Hungarian])
def test_it_is_asked_less_often_and_nothing_else_changes(policy, monkeypatch, tmp_path):
    from desim_warehouse.draft import Draft, draft
    from desim_warehouse.model.parse import read_yaml

    described = dw.Model.model_validate(read_yaml(draft(Draft((16, 14), orders=60)), "draft").data)
    names = {InOrder: "in-order", NearestAging: "nearest-aging", EarliestDue: "earliest-due"}
    model = described.replace({**FULL, "policies.allocation": names.get(policy, policy.__name__.lower())})
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
