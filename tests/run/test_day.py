"""The course of a run by the clock: each curve integrates to the indicator of the run; the worst stretch is named."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

import desim_warehouse as dw
from desim_warehouse.answer.course import figure, lanes, ticks, worst, worst_hour
from desim_warehouse.outcome.day import DOING, PileUp, day, doing, mean_number, part_length, shares_of_robots
from desim_warehouse.outcome.halts import Halt
from desim_warehouse.outcome.rows import waits_by_row
from desim_warehouse.states import SHOWN
from tests.report.replay.floors import busy, busy_run, due_run, jammed_run, paper_run, people_run
from tests.run.halls import RING
from tests.run.test_halts import LOW_TOGETHER
from tests.world.test_pickers import ring as pick_assist

RUNS = {"busy": busy_run, "due": due_run, "paper": paper_run, "jammed": jammed_run, "people": people_run}


def counted(run, values):
    """The integral of a curve over the counted time."""
    course = day(run.history)
    after = course.bounds[:-1] >= run.history.begin - 1e-9
    return float((values * np.diff(course.bounds))[after].sum())


def test_spans_are_counted_in_the_parts_in_which_they_lie():
    """From 1 to 4 and from 3 to 4: half of the first part of 2, three halves of the second, none of the last."""
    assert mean_number([(1.0, 4.0), (3.0, 4.0)], np.array([0.0, 2.0, 4.0, 6.0])) == pytest.approx([0.5, 1.5, 0.0])
    assert mean_number([], np.array([0.0, 2.0])) == pytest.approx([0.0])


def test_a_day_is_cut_into_parts_of_five_minutes_and_a_short_run_into_finer_ones():
    assert [part_length(hours * 3600) for hours in (2, 4, 16, 24)] == [300.0] * 4
    assert part_length(900.0) == 30.0
    assert part_length(50.0) == 2.0
    assert part_length(12.0) == 0.5
    assert part_length(3 * 86400.0) == 600.0


def test_parts_are_counted_from_the_end_of_the_warm_up_and_fill_the_run():
    course = day(busy_run().history)  # 900 s with a warm-up of 60 s
    assert course.bounds == pytest.approx(np.arange(0.0, 901.0, 30.0))
    moved = dw.simulate(dw.load(busy(run={"length": 900.0, "warm_up": 40.0})), seed=3)
    assert day(moved.history).bounds == pytest.approx([0.0, 10.0, *np.arange(40.0, 900.0, 30.0), 900.0])


@pytest.mark.parametrize("name", RUNS)
def test_robots_are_the_whole_fleet_and_integrate_to_their_shares_of_time(name):
    run = RUNS[name]()
    robots = day(run.history).robots
    assert sum(robots.values()) == pytest.approx(run.model.fleet.size)
    shares = {key: value for key, value in run.kpis.items() if key.startswith("share_") and key != "share_queueing"}
    spent = dict.fromkeys(DOING, 0.0)
    for key, share in shares.items():
        spent[doing(key.removeprefix("share_"))] += share
    waited = (
        run.kpis["charger_wait"] / (run.history.counted * run.model.fleet.size) if "charger_wait" in run.kpis else 0
    )
    spent["empty"] += waited
    spent["queue"] += run.kpis["share_queueing"] - waited
    for what, share in spent.items():
        whole = run.history.counted * run.model.fleet.size
        assert counted(run, robots.get(what, 0.0)) / whole == pytest.approx(share, abs=1e-9)


@pytest.mark.parametrize("name", RUNS)
def test_deliveries_integrate_to_the_tasks_of_the_run(name):
    run = RUNS[name]()
    assert counted(run, day(run.history).delivered) / run.model.units.hour == pytest.approx(run.kpis["tasks"])


@pytest.mark.parametrize("name", RUNS)
def test_open_tasks_integrate_to_the_time_that_tasks_were_open(name):
    run = RUNS[name]()
    time = math.fsum(run.history.within(task.released, task.done) for task in run.history.tasks.values())
    assert counted(run, day(run.history).open) == pytest.approx(time)


@pytest.mark.parametrize("name", RUNS)
def test_robots_in_queues_integrate_to_the_wait_at_stations(name):
    run = RUNS[name]()
    waited = run.kpis["share_queueing"] * run.history.counted * run.model.fleet.size - run.history.charger_wait
    assert counted(run, day(run.history).queue) == pytest.approx(waited, abs=1e-6)


def test_loads_before_workers_integrate_to_the_wait_for_them():
    packing = {"along": "south", "places": 3, "servers": 1, "work_time": 40.0, "workers": 1}
    layout = busy()["layout"] | {"stations": {"packing": packing}}
    tasks = busy()["tasks"] | {"done_when": "worked"}
    run = dw.simulate(dw.load(busy(layout=layout, tasks=tasks)), seed=3)
    assert run.kpis["worker_wait"] > 0
    assert counted(run, day(run.history).queue) == pytest.approx(run.kpis["worker_wait"])


def test_chargers_in_use_integrate_to_their_utilisation():
    run = busy_run()
    course = day(run.history)
    share = counted(run, course.chargers) / (run.history.chargers * run.history.counted)
    assert share == pytest.approx(run.kpis["charger_utilisation"])
    assert 0 < share < 1
    assert day(due_run().history).chargers is None


def test_the_level_of_batteries_integrates_to_what_was_drawn_and_charged():
    """By 200,000 samples of every battery; between its ends the level drifts as the indicator says."""
    run = busy_run()
    course = day(run.history)
    fine = np.linspace(run.history.begin, run.history.end, 200_001)
    levels = [
        np.interp(fine, *map(np.asarray, curve)) / battery.capacity
        for curve, battery in zip(run.history.energy_curves, run.history.batteries, strict=True)
    ]
    assert counted(run, course.battery) / run.history.counted == pytest.approx(np.mean(levels), abs=1e-5)
    last = np.mean(
        [level / one.capacity for level, one in zip(run.history.energy_at_end, run.history.batteries, strict=True)]
    )
    drift = run.kpis["energy_drift_per_hour"] * run.history.counted / run.model.units.hour
    first = np.mean([level[0] for level in levels])
    assert last - first == pytest.approx(drift)
    assert day(due_run().history).battery is None


def test_every_state_of_a_robot_is_in_a_curve():
    assert {doing(name) for name in SHOWN} | {"traffic"} == set(DOING)
    assert doing("behind_robot") == "traffic"
    assert doing("too_low") == doing("queueing_charger") == "empty"


def test_waiting_for_a_picker_is_a_curve_of_its_own_and_no_queue_at_a_station():
    """The first robot waits from 5 to 15, the second from 33 to 53."""
    course = day(pick_assist(tasks__goods=[0, 2], fleet__size=2).history)
    spent = {name: float((values * np.diff(course.bounds)).sum()) for name, values in course.robots.items()}
    assert DOING["picker"] == "waiting for a picker"
    assert spent["picker"] == pytest.approx(10 + 20)
    assert "queue" not in spent
    assert not course.queue.any()


@pytest.fixture(scope="module")
def stopped():
    """Six batteries that are low at the same time, and two chargers: the hall stands still."""
    return dw.simulate(dw.load(RING, LOW_TOGETHER | {"run.start": "06:00"}), 1)


def test_the_worst_stretch_is_when_the_hall_stood_still_and_says_why(stopped):
    course = day(stopped.history)
    assert isinstance(course.worst, Halt)
    assert course.worst.cause == "batteries"
    then = (course.bounds[:-1] >= course.worst.start) & (course.bounds[1:] <= course.worst.end)
    assert then.any()
    assert not course.delivered[then].any()
    sentence = worst(course, stopped.model, stopped.history.chargers)
    assert sentence.startswith("Deliveries stood still from 07:")
    assert "robots charged or waited to charge, with 2 chargers" in sentence
    page = str(figure(course, stopped.model, stopped.history.chargers))
    assert sentence in page
    assert "nothing delivered" in page


def test_without_a_standstill_it_is_when_most_tasks_were_open():
    """Ten times as many orders in the second of three fifths of an hour."""
    rates = {"profile": {"per_hour": [30, 30, 900, 30, 30, 30]}}
    flow = {"from": "storage", "to": "packing", "arrivals": rates}
    tasks = {"load_time": 4.0, "unload_time": 6.0, "flows": {"out": flow}}
    model = busy(tasks=tasks, battery=None, run={"length": 6 * 3600.0}, log="tasks")
    model["fleet"]["size"] = 4
    run = dw.simulate(dw.load(model), seed=1)
    course = day(run.history)
    assert isinstance(course.worst, PileUp)
    assert 2 * 3600 <= course.worst.start < course.worst.end
    assert course.worst.most == pytest.approx(course.open.max())
    assert course.worst.doing == "work"
    sentence = worst(course, run.model, 0)
    assert sentence.startswith("Most tasks were open from 2")
    assert sentence.endswith("of the robots were at work.")


def test_a_run_in_which_nothing_stands_out_says_so():
    run = paper_run()
    assert worst(day(run.history), run.model, run.history.chargers) == "No part of the run stands out."
    assert 'class="band"' not in str(figure(day(run.history), run.model, run.history.chargers))


def test_lanes_are_those_that_the_run_has():
    def names(run):
        course = day(run.history)
        return [lane.name for lane in lanes(course, run.model, run.history.chargers, 0.0, run.history.end)]

    assert names(busy_run())[:2] == ["Robots", "Delivered"]
    assert "Open tasks" not in names(busy_run())  # as many as there always are
    assert names(busy_run())[-2:] == ["Chargers", "Battery"]
    assert names(due_run())[:3] == ["Robots", "Delivered", "Open tasks"]


def test_times_below_are_round_and_by_the_clock_where_the_run_is():
    own = dw.load("models/my_own_day.yaml")
    assert ticks(own, 0.0, 57600.0)[:2] == [(0.0, "06:00"), (12.5, "08:00")]
    assert ticks(dw.load(busy()), 0.0, 900.0)[:2] == [(0.0, "0 min"), (13.33, "2 min")]


@pytest.mark.parametrize("name", ["busy", "people"])
def test_the_shares_of_robots_are_whole_and_their_means_those_of_the_run(name):
    run = RUNS[name]()
    shares = shares_of_robots(run.history)
    assert sum(shares.values()) == pytest.approx(np.ones(16))
    robots = day(run.history).robots
    for what, values in shares.items():
        assert values.mean() == pytest.approx(counted(run, robots[what]) / run.history.counted / 16, abs=1e-9)


def test_waits_add_up_by_the_rows_of_a_floor():
    """Names as `blocks` gives them: r1c2 is in row 1 and aisle 2; what is not waited for in rows is no row."""
    own = dw.load("models/my_own_day.yaml", {"run.length": "30 min", "log": "all"})
    run = dw.simulate(own)
    rows = waits_by_row(run.history)
    assert sum(rows.values()) == pytest.approx(run.kpis["share_waiting"])
    assert list(rows.values()) == sorted(rows.values(), reverse=True)
    assert all(name.split()[0] == next(iter(rows)).split()[0] for name in rows)
    assert waits_by_row(busy_run().history) == {}


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (due_run, "02:20 to 03:20: 40 tasks were open on average, against 17.3 over the whole run."),
        (busy_run, "01:00 to 02:00: 6 loads were delivered, against 17.3 an hour over the whole run."),
    ],
    ids=["orders come", "work never ends"],
)
def test_the_worst_hour_has_most_open_tasks_or_fewest_deliveries(made, message):
    """Four hours in parts of 20 min, the first hour a warm-up: 30, 60 and 30 from 2:20 to 3:20, else 6."""
    values = np.full(12, 6.0)
    values[7:10] = 30.0, 60.0, 30.0
    run = made()
    bounds = np.arange(0.0, 14401.0, 1200.0)
    course = replace(day(run.history), begin=3600.0, bounds=bounds, open=values, delivered=values)
    assert worst_hour(course, run.model) == f"The worst hour was {message}"
    assert worst_hour(day(run.history), run.model) == ""  # of a quarter of an hour
    drawn = str(figure(day(run.history), run.model, 2, named="the worst of 9 days", in_short=True))
    assert "<figcaption>The worst of 9 days</figcaption>" in drawn
    below = "Delivered" if made is busy_run else "Open tasks"
    assert re.findall(r"<b>(\w[\w ]*)</b>", drawn) == ["Robots", below]
