"""Whether workers see to a load unit is said by the world, and not by the node at which it was put down."""

import json

import pytest

import desim_warehouse as dw
from tests.world.test_flows import RING

STORAGE_AT_WORK = {
    "layout.storage": [{"node": "C"}],
    "layout.stations": {"work": {"at": ["C"], "places": 2, "work_time": 5}, "dock": {"at": ["B"], "places": 2}},
    "tasks.flows": {
        "in": {"from": "dock", "to": "storage", "arrivals": {"schedule": [{"at": 0, "tasks": 3}]}, "due_within": 1000}
    },
}
"""Three load units are put into the storage place on node C, beside which there is a station with workers."""
TO_WORK = {"from": "dock", "to": "work", "arrivals": {"schedule": [{"at": 0, "tasks": 2}]}, "due_within": 1000}


@pytest.fixture(scope="module")
def run():
    return dw.simulate(dw.load(RING, STORAGE_AT_WORK))


def test_what_is_put_into_a_storage_place_is_done_whatever_stands_there(run):
    assert [task.done for task in run.history.done] == [task.delivered for task in run.history.delivered]
    assert (run.kpis["tasks"], run.kpis["backlog"], run.kpis["on_time"]) == (3, 0, 1)
    assert run.kpis["cycle_time_mean"] == sum(task.delivered for task in run.history.delivered) / 3
    assert not {"worked", "work_backlog", "worked_on_time", "worker_utilisation"} & run.kpis.keys()


def test_it_is_accounted_to_no_station():
    parts = dw.simulate(dw.load(RING, {**STORAGE_AT_WORK, "log": "all"})).account("station")
    assert list(parts.index) == []


def test_loads_put_down_with_and_without_work_at_one_node_are_told_apart():
    """Of five load units put down at C two are worked on, 5 each."""
    flows = {**STORAGE_AT_WORK["tasks.flows"], "out": TO_WORK}
    run = dw.simulate(dw.load(RING, {**STORAGE_AT_WORK, "tasks.flows": flows, "log": "all"}))
    assert (run.kpis["tasks"], run.kpis["worked"], run.kpis["backlog"], run.kpis["work_backlog"]) == (5, 2, 0, 0)
    assert run.kpis["on_time:in"] == run.kpis["on_time:out"] == run.kpis["worked_on_time:out"] == 1
    assert "worked:in" not in run.kpis
    by_task = {task.number: task.done - task.delivered for task in run.history.tasks.values()}
    assert sorted(by_task.values()) == pytest.approx([0, 0, 0, 5, 5])
    assert list(run.account("station").index) == ["work at C"]
    assert run.account("station")["worked_on"].tolist() == pytest.approx([5])


def test_a_run_of_before_is_read_as_then(run, tmp_path):
    """Versions before 0.4.0 did not say it: whatever was put down at C is taken to be for the workers there."""
    folder = run.save(tmp_path / "run")
    content = json.loads((folder / "run.json").read_text())
    del content["log"]["for_workers"]
    (folder / "run.json").write_text(json.dumps(content))
    (folder / "kpis.json").unlink()
    before = dw.load_run(folder)
    assert (before.kpis["tasks"], before.kpis["backlog"], before.kpis["work_backlog"]) == (3, 3, 3)
