"""A load is done when the work on it is done: the square of tests/world/test_hours.py, with a worker at the desk.

The robot delivers at 65, 140 and 215. With 100 s of work a unit one worker is on them from 65, 165 and 265 on.
"""

import pytest

import desim_warehouse as dw
from desim_warehouse.outcome.verdicts import judge
from desim_warehouse.questions.check import check
from tests.accounting import faults
from tests.world.test_hours import SQUARE, simulated

pytestmark = pytest.mark.usefixtures("brief_probes")

DESK = "layout.stations.desk"
GOODS = [{"good": 0, "due": 170}, {"good": 0, "due": 170}, {"good": 0, "due": 400}]
SLOW = {f"{DESK}.work_time": 100, "tasks.goods": GOODS, "run.length": 300}
"""The first is worked on until 165, the second until 265, the third is not finished when the run ends."""


def test_due_times_and_cycle_times_count_to_the_end_of_the_work():
    run = simulated(SLOW)
    assert [task.delivered for task in run.history.tasks.values()] == [65, 140, 215]
    assert [task.done for task in run.history.done] == [165, 265]
    assert run.kpis["tasks"] == 3
    assert run.kpis["on_time"] == 0.5  # the second is late
    assert run.kpis["tardiness_mean"] == 95 / 2
    assert run.kpis["cycle_time_mean"] == (165 + 265) / 2
    assert run.kpis["backlog"] == 1


def test_a_run_ends_when_all_is_worked_on():
    """The robot is home at 225, the third load is finished at 365; the last one never, where the desk stays closed."""
    ends = {key: value for key, value in SLOW.items() if key != "run.length"}
    assert simulated(ends).kpis["T"] == 365
    once = {**ends, "calendars.once": {"between": [[0, 300]]}, f"{DESK}.hours": "once"}
    with pytest.raises(dw.StallError, match="load units that are not worked on: in E"):
        simulated({**once, f"{DESK}.at_close": "pause"})


def test_to_the_delivery_where_the_model_says_so():
    run = simulated({**SLOW, "tasks.done_when": "delivered"})
    assert run.kpis["on_time"] == 1
    assert run.kpis["cycle_time_mean"] == (65 + 140 + 215) / 3
    assert run.kpis["backlog"] == 0
    assert run.kpis["T"] == 225  # when the robot is home, whatever lies at the desk
    assert (run.kpis["worked"], run.kpis["work_backlog"]) == (1, 2)


def test_what_workers_do_is_counted():
    """From 65 to the end at 300 one is at work; the second waits from 140 to 165, the third from 215 to 265."""
    kpis = simulated(SLOW).kpis
    assert kpis["worked"] == 2
    assert kpis["work_backlog"] == 1
    assert kpis["worker_wait"] == 25 + 50
    assert kpis["worker_utilisation"] == pytest.approx(235 / 300)
    assert simulated({**SLOW, f"{DESK}.workers": 2}).kpis["worker_utilisation"] == pytest.approx(285 / 600)


def test_a_warm_up_is_left_out():
    """From 100 to 300: the worker is busy all the time, 25 and 50 s are waited, two units are finished."""
    kpis = simulated({**SLOW, "run.warm_up": 100}).kpis
    assert (kpis["worked"], kpis["worker_wait"], kpis["worker_utilisation"]) == (2, 75, 1)


def test_workers_are_at_work_in_the_hours_of_their_station():
    """Open to 100, from 200 to 300 and from 400 on: work from 65 to 100 and 200 to 265; then the second to 300."""
    over = {**SLOW, f"{DESK}.hours": "day", f"{DESK}.at_close": "pause"}
    run = simulated(over)
    assert run.history.tasks[0].worked == 265
    assert run.kpis["worker_utilisation"] == pytest.approx((35 + 65 + 35) / 200)


def test_each_flow_has_its_own():
    flows = {
        "packed": {
            "from": "storage",
            "to": "desk",
            "arrivals": {"schedule": [{"at": 0, "tasks": 2}]},
            "due_within": 170,
        },
        "restock": {"from": "desk", "to": "storage", "arrivals": {"schedule": [{"at": 100}]}, "due_within": 900},
    }
    tasks = {"flows": flows, "load_time": 5, "unload_time": 30}
    run = simulated({"tasks": tasks, f"{DESK}.work_time": 100, "run.length": 600})
    assert run.kpis["worked:packed"] == 2
    assert run.kpis["worked_on_time:packed"] == run.kpis["on_time:packed"] == 0.5
    assert run.kpis["on_time:restock"] == 1
    assert not [name for name in run.kpis if name.startswith("work") and name.endswith(":restock")]


def test_tasks_account_for_their_time_at_work():
    """Hand-over to the worker and work are parts of a task's time, and the parts add up to its cycle time."""
    run = simulated(SLOW)
    parts = run.account("task")
    assert parts["waiting_for_worker"].tolist() == [0, 25, 50]
    assert parts["worked_on"].tolist() == [100, 100, 35]
    assert parts.sum(axis=1).iloc[:2].mean() == run.kpis["cycle_time_mean"]
    assert faults(run) == []
    assert "worked_on" not in simulated({}).account("task")


def test_work_that_piles_up_cannot_be_kept_up_with():
    """40 tasks an hour, 36 can be worked on: with always work waiting, and with arrivals at random."""
    lifelong = {f"{DESK}.work_time": 100, "run.length": 40_000}
    for goods in ({"saturated": 1}, {"poisson": 47}):
        model = dw.load(SQUARE, {**lifelong, "tasks.goods": goods})
        for done_when in ("worked", "delivered"):
            run = dw.simulate(model.replace({"tasks.done_when": done_when}), 3)
            assert [verdict.code for verdict in judge(run.kpis, run.model)] == ["CANNOT_KEEP_UP"], goods
    enough = dw.load(SQUARE, {**lifelong, "tasks.goods": {"saturated": 1}, f"{DESK}.workers": 2})
    assert judge(dw.simulate(enough).kpis, enough) == []


def test_check_names_what_is_missing():
    """40 tasks an hour, 100 s of work: one worker does 36; 90 s of unloading are too much for one server, too."""
    over = {f"{DESK}.work_time": 100, "run.length": 40_000, "tasks.goods": {"poisson": 40}, "fleet.size": 1}
    message = warnings({**over, f"{DESK}.unload_time": 10})
    assert "takes 111.1 % of the time of its 1 worker" in message
    assert "it needs 2 workers, or less work_time" in message
    both = warnings({**over, f"{DESK}.unload_time": 100})
    assert "it needs 2 servers, or less unload_time" in both
    assert "it needs 2 workers, or less work_time" in both
    just = warnings({**over, f"{DESK}.work_time": 180, f"{DESK}.unload_time": 10})  # 200 %: two are not enough
    assert "it needs 3 workers" in just


def warnings(over):
    report = check(dw.load(SQUARE, over))
    assert report.errors == []
    return " ".join(map(str, report.findings))
