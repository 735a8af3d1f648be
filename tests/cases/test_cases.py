"""Models on which a run once failed or said what cannot be; each is named for what it shows."""

import dataclasses
import re
from pathlib import Path

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import WarehouseError
from desim_warehouse.questions.study import Study
from tests import little
from tests.auditor import audit
from tests.recount import differences

pytestmark = pytest.mark.usefixtures("brief_probes")
HERE = Path(__file__).parent


def load(name, **changed):
    model = dw.load(HERE / f"{name}.yaml")
    return model.replace({key.replace("__", "."): value for key, value in changed.items()}) if changed else model


def is_right(run):
    return audit(run) == [] and differences(run) == [] and little.faults(run) == []


@pytest.mark.parametrize("routing", ["shortest", "highways"])
def test_an_edge_next_to_two_d_does_not_hold_a_robot_for_ever(routing):
    run = dw.simulate(load("lengths_next_to_two_d", policies__routing=routing), 3)
    assert run.kpis["tasks"] == 25
    assert audit(run) == []


@pytest.mark.parametrize(
    "allocation",
    ["in-order", "nearest", "nearest-aging", "earliest-due", "hungarian", "regret", "auction", "cost-aware"],
)
def test_a_pair_is_decided_with_the_station_that_it_gets(allocation):
    run = dw.simulate(load("station_taken_in_the_same_decision", policies__allocation=allocation))
    assert run.kpis["tasks"] == 2
    assert is_right(run)


def test_a_wait_that_is_not_over_counts_up_to_the_end():
    """The fast robot waits 10 for the slow one to clear the bay's node, and then behind it, on from there, to the end.

    So it waits for all of the run, half of the fleet's time, and the slow one alone drives: 300 at a speed of 0.1.
    """
    run = dw.simulate(load("wait_beyond_the_end"))
    assert is_right(run)
    assert [(wait.start, wait.end) for wait in run.waits.itertuples()] == [(0, 10), (10, 300)]
    kpis = run.kpis
    assert (kpis["S"], kpis["waiting"], kpis["distance"]) == (2, pytest.approx(300), pytest.approx(30))
    assert (kpis["share_empty"], kpis["share_waiting"]) == (pytest.approx(0.5), pytest.approx(0.5))
    assert kpis["cost"] == pytest.approx(30 + 300 + 2)


@pytest.mark.parametrize("seed", [1, pytest.param(0, marks=pytest.mark.long), pytest.param(3, marks=pytest.mark.long)])
def test_a_robot_does_not_give_a_task_back_again_and_again(seed):
    """Four chargers for twelve robots, and policies that break off charging: nobody takes what it would give back."""
    run = dw.simulate(load("packing_hall", policies__charging="opportunity", log="tasks"), seed)
    assert run.T == 28_800


TWO_CHARGERS = {
    "policies__charging": "four-thresholds",
    "layout__bays__chargers__at": ["A", "H"],
    "layout__bays__parking__at": ["B", "C", "D", "E", "F", "G"],
    "log": "tasks",
}
"""What they give, 0.04 a second, is less than what the fleet draws, up to 0.06: flat after ten hours."""


def test_two_chargers_last_for_eight_hours_and_not_for_a_day():
    with pytest.raises(dw.BatteryError, match="ran flat") as flat:
        dw.simulate(load("packing_hall", **TWO_CHARGERS, run__length=172_800), 1)
    assert 28_800 < float(re.search(r"at time ([\d.]+)", str(flat.value))[1]) < 86_400


@pytest.mark.long  # that batteries last for so long is seen every day
def test_with_two_chargers_orders_of_eight_hours_are_on_time():
    assert dw.simulate(load("packing_hall", **TWO_CHARGERS), 1).kpis["on_time"] > 0.95


def test_an_answer_averages_over_none_of_three_factors(tmp_path):
    """A row and a bar a design, for each demand: two chargers and four are not thrown together."""
    plan = Study.read(HERE / "chargers_and_growth.yaml").plan
    base = plan.base.replace({"run.length": 2700, "run.warm_up": 900})
    answer = Study.of(dataclasses.replace(plan, base=base, replications=1)).run(out=tmp_path).results.answer
    bars = {bar.label: bar.text for bar in answer.figure.rows}
    rows = {", ".join(filter(None, (one.group, one.name))): one for one in answer.options}
    assert all(any(number.text == text for number in rows[label].numbers) for label, text in bars.items())
    assert sum(1 + len(one.same) for one in answer.options) == 12
    assert len(rows) == len(answer.options)


def test_robots_whose_home_has_no_charger_take_turns_or_check_says_that_they_run_flat():
    """Under policies that ran flat once: they live where chargers give what is drawn at rest; else check warns."""
    run = dw.simulate(load("packing_hall", policies={}))
    assert run.kpis["energy_lowest"] > 0.1
    assert not [verdict for verdict in run.verdicts if verdict.is_lasting]
    slow = load("packing_hall", policies={}, **{"battery.charge_rate": 0.001})
    assert {"CHARGERS_SHORT", "REST_FLAT"} <= {item.code for item in dw.check(slow).findings}
    with pytest.raises(WarehouseError, match=r"at least 10 chargers are needed .layout\.bays."):
        dw.simulate(slow)


def test_decisions_at_intervals_do_not_block_the_lane():
    """A robot that has unloaded does not keep the lane until the next decision, up to 200 time units later."""
    paper = dw.load("models/multibots.yaml")
    busy = {
        "tasks.goods": {"poisson": 1500},
        "fleet.size": 5,
        "policies.allocation": "hungarian",
        "policies.interval": 200,
        "run.length": 28_800,
        "log": "tasks",
    }
    assert dw.simulate(paper.replace(busy), 0).T == 28_800


def test_a_name_that_cannot_be_written_is_refused():
    """A lone surrogate is no character: no terminal and no file takes it."""
    with pytest.raises(dw.ModelError, match="name"):
        dw.load(load("wait_beyond_the_end").content() | {"name": "\ud800"})
