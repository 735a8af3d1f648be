"""The parts of the day in which orders come at one rate, and what a run has of each."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

import desim_warehouse as dw
from desim_warehouse.answer import words
from desim_warehouse.errors import NoIndicatorError
from desim_warehouse.model.facts.day_parts import MOST, parts_of_the_day
from desim_warehouse.outcome import measures
from desim_warehouse.outcome.indicators import counted_in, look_up, split
from desim_warehouse.outcome.parts import PartHistory
from desim_warehouse.study.target import read_target
from tests.world.test_flows import RING

HOUR = 3600.0
QUIET_THEN_BUSY = [0] * 8 + [10, 10, 10, 60] + [0] * 12
"""Orders an hour from 08:00 to 12:00, of which most come in the last hour."""


def ring(per_hour, *, every=None, start="08:00", length=4 * HOUR, warm_up=0.0):
    """The ring of `test_flows`, whose robot needs 80 s for an order that is due in 150."""
    profile = {"per_hour": per_hour, **({} if every is None else {"every": every})}
    flow = {"from": "storage", "to": ["pack"], "due_within": 150, "arrivals": {"profile": profile}}
    run = {"start": start, "length": length, "warm_up": warm_up}
    return dw.load({**RING, "tasks": {**RING["tasks"], "flows": {"out": flow}}, "run": run})


def test_long_stretches_of_one_rate_are_cut_at_full_hours():
    model = ring(QUIET_THEN_BUSY)
    assert parts_of_the_day(model) == {
        "08:00-09:00": [(0, HOUR)],
        "09:00-10:00": [(HOUR, 2 * HOUR)],
        "10:00-11:00": [(2 * HOUR, 3 * HOUR)],
        "11:00-12:00": [(3 * HOUR, 4 * HOUR)],
    }


def test_hours_are_those_of_the_clock_and_the_warm_up_is_no_part():
    model = ring(QUIET_THEN_BUSY, start="07:45", length=4.25 * HOUR, warm_up=0.5 * HOUR)
    assert next(iter(parts_of_the_day(model).items())) == ("08:15-09:00", [(0.5 * HOUR, 1.25 * HOUR)])
    assert list(parts_of_the_day(model))[1:] == ["09:00-10:00", "10:00-11:00", "11:00-12:00"]


def test_a_part_of_a_run_of_several_days_is_the_same_on_each():
    model = ring(QUIET_THEN_BUSY, length=48 * HOUR)
    parts = parts_of_the_day(model)
    assert list(parts) == ["08:00-09:00", "09:00-10:00", "10:00-11:00", "11:00-12:00"]
    assert parts["11:00-12:00"] == [(3 * HOUR, 4 * HOUR), (27 * HOUR, 28 * HOUR)]


def test_orders_for_whom_goods_make_way_have_their_parts_though_their_sum_stays():
    """Goods come in for two hours, and then as many orders go out."""
    model = ring([30, 30, 0, 0], every=HOUR)
    goods_in = {
        **model.tasks.flows["out"].content(),
        "arrivals": {"profile": {"per_hour": [0, 0, 30, 30], "every": HOUR}},
    }
    assert list(parts_of_the_day(model.replace({"tasks.flows.in": goods_in}))) == ["08:00-10:00", "10:00-12:00"]


def test_there_are_none_where_the_rate_stays():
    assert parts_of_the_day(ring([30] * 24)) == {}
    goods = {**RING["tasks"], "goods": [0], "unload_at": ["pack"]}
    assert parts_of_the_day(dw.load({**RING, "tasks": goods})) == {}


@given(
    rates=st.lists(st.integers(0, 3), min_size=1, max_size=60).filter(any),
    every=st.sampled_from([300, 900, 1800, 3600, 5400]),
    start=st.sampled_from(["00:00", "06:30", "23:15"]),
    hours=st.integers(1, 60),
    warm_up=st.sampled_from([0, 0.25, 0.6]),
)
def test_parts_hold_all_orders_once_and_are_no_more_than_a_table_holds(rates, every, start, hours, warm_up):
    model = ring(rates, every=every, start=start, length=hours * HOUR, warm_up=warm_up * hours * HOUR)
    parts = parts_of_the_day(model)
    assert len(parts) <= MOST + 2  # the first and the last hour may be parts of one
    stretches = sorted(stretch for part in parts.values() for stretch in part)
    assert all(one[1] <= other[0] for one, other in pairwise(stretches))
    one = model.rates(model.tasks.flows["out"].when.profile)
    whole = one.expected(model.run.end) - one.expected(model.run.warm_up)
    if parts:
        inside = math.fsum(one.expected(end) - one.expected(begin) for begin, end in stretches)
        assert inside == pytest.approx(whole, abs=1e-9)


def test_each_part_has_the_orders_that_come_in_it_and_those_of_them_on_time():
    run = dw.simulate(ring(QUIET_THEN_BUSY, length=48 * HOUR), 3)
    for part, stretches in parts_of_the_day(run.history.model).items():
        came = [
            task
            for task in run.history.tasks.values()
            if any(begin <= task.released < end for begin, end in stretches) and task.due < run.history.end
        ]
        assert run.kpis[f"tasks_due@{part}"] == len(came)
        assert run.kpis[f"on_time@{part}"] == pytest.approx(sum(task.done <= task.due for task in came) / len(came))
    parts = [name for name in run.kpis if name.startswith("tasks_due@")]
    assert sum(run.kpis[name] for name in parts) == run.kpis["tasks_due"]
    assert run.kpis["on_time@11:00-12:00"] < run.kpis["on_time"] < run.kpis["on_time@08:00-09:00"]


def test_robots_and_servers_are_busy_in_stretches_of_a_run_as_its_states_say():
    """The robot loads at the dock from 20 to 24 and unloads on a lane from 49 to 55; at 90 it is back, and idle."""
    due = {"schedule": [{"at": 0}, {"at": 135}]}  # the second load takes until 225
    flow = {"from": "dock", "to": {"popularity": {"weights": [1, 0]}}, "arrivals": due}
    stations = {name: {**RING["layout"]["stations"][name], "servers": 1} for name in ("dock", "pack")}
    layout = {**RING["layout"], "stations": stations}
    tasks = {**RING["tasks"], "flows": {"in": flow}}
    run = dw.simulate(dw.load({**RING, "layout": layout, "tasks": tasks}))
    assert run.kpis["robots_busy"] == pytest.approx(180 / 225)
    assert run.kpis["server_utilisation"] == pytest.approx(2 * 4 / (2 * 225))
    some = PartHistory(run.history, lambda _: True, [(0, 22), (60, 100)])
    assert measures.robots_busy(some) == pytest.approx((22 + 30) / 62)
    assert measures.server_utilisation(some) == pytest.approx(2 / (2 * 62))


def test_the_parts_of_a_day_add_up_to_the_utilisation_of_the_whole():
    model = ring(QUIET_THEN_BUSY).replace({"layout.stations.pack.work_time": 30, "layout.stations.pack.workers": 1})
    run = dw.simulate(model, 3)
    for name in ("robots_busy", "server_utilisation", "worker_utilisation"):
        parts = [run.kpis[f"{name}@{part}"] for part in parts_of_the_day(model)]  # of an hour each
        assert math.fsum(parts) / 4 == pytest.approx(run.kpis[name])
        assert parts[3] == max(parts)
    # 80 s a task, and the robot is its own bottleneck in the last hour, when 60 tasks come
    assert run.kpis["robots_busy@11:00-12:00"] > 0.95
    assert words.target(read_target("robots_busy@11:00-12:00 <= 85 %")) == "robots busy at most 85 %, 11:00 to 12:00"


def test_a_part_is_an_indicator_as_any_other():
    name = "on_time@11:00-12:00"
    assert split(name) == ("on_time", "@", "11:00-12:00")
    assert split("on_time:a@b") == ("on_time", ":", "a@b")  # a flow may be called so
    assert look_up(name).title == "Done on time, 11:00 to 12:00"
    assert look_up(name).is_share
    assert counted_in(name, [name, "tasks_due@11:00-12:00", "tasks_due"]) == ["tasks_due@11:00-12:00"]
    assert read_target(f"{name} >= 90 %").indicator == name
    assert words.target(read_target(f"{name} >= 90 %")) == "at least 90 % on time, 11:00 to 12:00"
    for wrong in ("on_time@", "T@11:00-12:00"):
        assert look_up(wrong) is None
    with pytest.raises(NoIndicatorError, match="does not have it"):
        dw.simulate(ring(QUIET_THEN_BUSY)).kpis["on_time@03:00-04:00"]
