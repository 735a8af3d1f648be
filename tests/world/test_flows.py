"""Flows: from anywhere to anywhere, worked out by hand; when tasks arrive; what is drawn, and for whom."""

from collections import Counter

import numpy as np
import pytest
from scipy import stats

import desim_warehouse as dw
from desim_warehouse.errors import ModelError
from desim_warehouse.layout import build
from desim_warehouse.model.sections.flows import Profile, Rates
from desim_warehouse.questions.run import words as run_words
from desim_warehouse.study.suspects import suspects
from desim_warehouse.values.streams import Streams
from desim_warehouse.world import World
from desim_warehouse.world.orders.flows import _Flow
from desim_warehouse.world.robots.forecast import busy_view
from tests import little
from tests.accounting import faults
from tests.auditor import audit
from tests.daily import some

pytestmark = pytest.mark.usefixtures("brief_probes")

RING = {
    "name": "ring",
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 20], "D": [0, 20]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"edge": ["C", "D"], "offset": 5}, {"edge": ["B", "C"], "offset": 10}],
        "bays": {"home": {"at": ["A"], "places": 4}},
        "stations": {"dock": {"at": ["B"], "places": 2}, "pack": {"at": ["D"], "places": 2}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {"load_time": 4, "unload_time": 6},
}
"""One way round, 20 to a side; a robot at A drives at speed 1."""


def ring(flow, **changes):
    changes = {key.replace("__", "."): value for key, value in changes.items()}
    return dw.simulate(dw.load(RING, {"tasks.flows": {"flow": flow}, **changes}))


def first(place):
    """Storage places by weights that leave one of the two."""
    return {"popularity": {"weights": [int(place == 0), int(place == 1)]}}


def states(run, robot=0):
    return [(span.state, span.start) for span in run.history.states[robot]]


ONCE = {"schedule": [{"at": 0}]}


NO_STORAGE = {**RING, "layout": {key: value for key, value in RING["layout"].items() if key != "storage"}}


def test_a_robot_on_its_way_into_storage_is_free_at_the_end_of_that_lane():
    """At 24 it has loaded at B; from 30 it is 14 to C, 5 to the place, 6 to unload and 15 to D."""
    flow = {"from": "dock", "to": first(0), "arrivals": {"schedule": [{"at": 0, "tasks": 1}]}}
    world = World(dw.load(RING, {"tasks.flows": {"flow": flow}}), 0)
    world.begin(None)
    world.env.run(30)
    view = busy_view(world.robots[0], world.reach, 30)
    assert (view.node, view.free_in) == ("D", 14 + 5 + 6 + 15)


def test_a_floor_of_pick_up_and_drop_off_points_needs_no_storage():
    flow = {"from": "dock", "to": "pack", "arrivals": ONCE}
    run = dw.simulate(dw.load(NO_STORAGE, {"tasks.flows": {"flow": flow}}))
    # A to B 20, loads to 24; B to D 40: 64, unloads to 70; D to A 20: 90
    assert states(run) == [("empty", 0), ("loading", 20), ("loaded", 24), ("unloading", 64), ("returning", 70)]
    assert run.T == 90
    with_places = ring(flow)
    assert run.kpis == with_places.kpis
    assert run.log.equals(with_places.log)


@pytest.mark.parametrize(
    ("tasks", "what"),
    [
        ({"goods": [0], "unload_at": ["dock"]}, "goods are"),
        ({"flows": {"in": {"from": "dock", "to": "storage", "arrivals": ONCE}}}, "tasks of flow 'in' begin or end"),
    ],
)
def test_tasks_that_need_storage_are_refused_without_it(tasks, what):
    with pytest.raises(ModelError, match=rf"layout\.storage: no storage places, where {what}, expected at least one"):
        dw.load({**NO_STORAGE, "tasks": {**RING["tasks"], **tasks}})


def test_rows_of_orders_name_no_storage_without_it(tmp_path):
    (tmp_path / "orders.csv").write_text("release,from,to\n0,dock,pack\n5,storage,pack\n9,0,pack\n")
    flow = {"from": "dock", "to": "pack", "arrivals": {"orders": {"file": str(tmp_path / "orders.csv")}}}
    with pytest.raises(
        ModelError, match=r"2 values: 'storage', '0'.*a node or a station, as the layout has no storage"
    ):
        dw.simulate(dw.load(NO_STORAGE, {"tasks.flows": {"flow": flow}}))


def test_from_a_station_into_storage():
    run = ring({"from": "dock", "to": first(0), "arrivals": ONCE})
    # A to B 20, loads in the dock to 24; B to C 20, 5 along C>D: 49, unloads on the lane to 55; 15 to D, 20 to A: 90
    assert states(run) == [("empty", 0), ("loading", 20), ("loaded", 24), ("unloading", 49), ("returning", 55)]
    assert run.T == 90
    (task,) = run.history.tasks.values()
    assert (task.good, task.flow, task.loaded, task.delivered) == (-1, "flow", 24, 55)
    (row,) = run.history.rows("delivered")
    assert (row.node, row.edge) == ("D", ("C", "D"))
    assert audit(run) == []
    assert faults(run) == []


def test_from_storage_to_a_station():
    run = ring({"from": first(1), "to": ["pack"], "arrivals": ONCE})
    # 20 to B, 10 along B>C: 30, loads to 34; 10 to C, 20 to D: 64, unloads in the station to 70; 20 to A
    assert states(run) == [("empty", 0), ("loading", 30), ("loaded", 34), ("unloading", 64), ("returning", 70)]
    assert run.T == 90
    assert run.history.delivered[0].station == "D"


def test_a_robot_carries_a_load_from_station_to_station():
    run = ring({"from": "dock", "to": "pack", "arrivals": ONCE, "load_time": 1, "unload_time": 2})
    # B 20, 21; D 61, 63; A 83
    assert states(run) == [("empty", 0), ("loading", 20), ("loaded", 21), ("unloading", 61), ("returning", 63)]
    assert run.T == 83


def test_a_robot_carries_a_load_from_one_storage_place_to_another():
    run = ring({"from": first(1), "to": first(0), "arrivals": ONCE})
    # 30, 34; 10 to C, 5 along C>D: 49, 55; 15 to D, 20 to A
    assert states(run) == [("empty", 0), ("loading", 30), ("loaded", 34), ("unloading", 49), ("returning", 55)]
    assert run.T == 90


def test_from_a_node_without_a_station_it_is_loaded_on_the_node():
    run = ring({"from": "C", "to": "pack", "arrivals": ONCE})
    assert states(run) == [("empty", 0), ("loading", 40), ("loaded", 44), ("unloading", 64), ("returning", 70)]


def test_what_is_to_be_fetched_where_it_stands_is_loaded_there():
    flows = {
        "in": {"from": "C", "to": "dock", "arrivals": ONCE},
        "out": {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 1}]}},
    }
    run = dw.simulate(dw.load(RING, {"tasks.flows": flows}))
    # C 40, loads to 44; round to B 60 more: 104, unloads to 110, and loads there to 114; D 154, 160; A 180
    assert [one for one in states(run) if one[1] >= 104] == [
        ("unloading", 104),
        ("loading", 110),
        ("loaded", 114),
        ("unloading", 154),
        ("returning", 160),
    ]
    assert audit(run) == []
    assert run.T == 180


def test_a_robot_that_loaded_where_it_stood_is_not_recalled_on_its_way():
    """At 125 its battery is at the threshold: with the load on board since 116 it goes on beyond the next node."""
    flows = {
        "in": {"from": "C", "to": "dock", "arrivals": ONCE},
        "out": {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 1}]}},
    }
    battery = {"capacity": 300, "threshold": 175, "consumption": 1, "charge_rate": 10}
    run = dw.simulate(dw.load(RING, {"tasks.flows": flows, "battery": battery, "tasks.clear_time": 2}))
    # as above, and 2 to clear its place, in which it has a task and its battery is watched
    assert [(row.node, row.time) for row in run.history.rows("delivered")] == [("B", 110), ("D", 162)]
    assert audit(run) == []


def test_after_unloading_on_a_lane_the_next_task_begins_there():
    run = ring({"from": "dock", "to": first(0), "arrivals": {"schedule": [{"at": 0, "tasks": 2}]}})
    # unloaded on C>D at 55; D 70, A 90, B 110: loads to 114; C>D at 139
    assert [start for state, start in states(run) if state == "unloading"] == [49, 139]
    assert run.history.assignments[1].start == 55


def test_a_full_dock_holds_robots_back_in_their_bays():
    changes = {"fleet.size": 3, "layout.stations.dock": {"at": ["B"], "places": 1}}
    run = ring({"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 0, "tasks": 3}]}}, **changes)
    starts = sorted(assignment.start for assignment in run.history.assignments)
    # the first loads at B from 20 to 24 and leaves at once; its slot is free then
    assert starts[0] == 0
    assert starts[1] == 24
    assert audit(run) == []


def test_due_at_the_next_departure():
    schedule = {"schedule": [{"at": 0}, {"at": 50}, {"at": 150}]}
    run = ring({"from": "dock", "to": "pack", "arrivals": schedule, "due_at": [50, 100]})
    assert [task.due for task in run.history.tasks.values()] == [50, 50, None]


def test_due_at_a_time_of_day_comes_every_day():
    """From 06:00: departures at 06:01 and 18:00, and again on the next day."""
    at = [0, 60, 61, 43200, 43201, 86401, 86460, 86461]
    schedule = {"schedule": [{"at": time} for time in at]}
    for start, times in (("06:00", ["06:01", "18:00"]), ("2026-03-02T18:00", ["06:00", "18:01"])):
        run = ring({"from": "dock", "to": "pack", "arrivals": schedule, "due_at": times}, run__start=start)
        assert [task.due for task in run.history.tasks.values()] == [
            60, 60, 43200, 43200, 86460, 86460, 86460, 129600,
        ]  # fmt: skip


def test_what_comes_after_the_cut_off_takes_the_next_departure():
    schedule = {"schedule": [{"at": time} for time in (0, 20, 21, 70, 71)]}
    due_at = {"times": [50, 100], "cut_off": 30}
    run = ring({"from": "dock", "to": "pack", "arrivals": schedule, "due_at": due_at})
    assert [task.due for task in run.history.tasks.values()] == [50, 50, 100, 100, None]


def test_units_of_a_model_hold_for_departures_by_the_clock():
    """In minutes: 10:00 is 240 after 06:00."""
    changes = {"units": {"time": "min", "seconds": 60}, "fleet.robot.speed": 60, "run.start": "06:00"}
    flow = {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 239}, {"at": 241}]}, "due_at": ["10:00"]}
    run = ring(flow, **changes)
    assert [task.due for task in run.history.tasks.values()] == [240, 240 + 1440]


@pytest.mark.parametrize(
    ("due_at", "told"),
    [
        (["10:00", 50], "expected one of the two"),
        (["24:00"], "from 00:00 to 23:59"),
        (["18:00", "10:00"], "expected the earliest time first"),
        ({"times": []}, "due_at.times"),
        ({"times": ["10:00"], "cut_off": -1}, "cut_off"),
        ("10:00", "should be a list of times"),
    ],
)
def test_departures_that_are_none_are_refused(due_at, told):
    with pytest.raises(ModelError, match=told):
        dw.load(RING, {"tasks.flows": {"flow": {"from": "dock", "to": "pack", "arrivals": ONCE, "due_at": due_at}}})


def test_the_lead_before_a_departure_is_that_of_the_earliest_order_that_missed_it():
    """One robot: 80 for each task; it does those of 0 and 100 by 180, not those of 120 and 130 for 200."""
    schedule = {"schedule": [{"at": time} for time in (0, 100, 120, 130)]}
    flow = {"from": "dock", "to": "pack", "arrivals": schedule, "due_at": [200]}
    run = ring(flow, run__length=400)
    missed = [task for task in run.history.tasks.values() if task.done > 200]
    assert [task.released for task in missed] == [120, 130]
    assert run.kpis["departure_lead"] == run.kpis["departure_lead:flow"] == 80
    assert "Loads that came more than 80 s before a departure were in time for it." in run_words.sentences(run)
    assert ring({**flow, "due_at": [390]}, run__length=400).kpis["departure_lead"] == 0
    assert "departure_lead" not in ring({**flow, "due_at": [500]}, run__length=400).kpis


def test_kinds_of_robots_that_do_a_flow():
    flows = {
        "heavy": {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 0, "tasks": 3}]}, "kinds": ["truck"]},
        "light": {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 0, "tasks": 3}]}},
    }
    kinds = {"truck": {"count": 1, "speed": 0.5}}
    for allocation in ("in-order", "nearest", "hungarian", "earliest-due", "regret"):
        changes = {"tasks.flows": flows, "fleet.size": 3, "fleet.kinds": kinds, "policies.allocation": allocation}
        run = dw.simulate(dw.load(RING, changes))
        robots = {run.history.tasks[one.task].flow: [] for one in run.history.assignments}
        for one in run.history.assignments:
            robots[run.history.tasks[one.task].flow].append(one.robot)
        assert robots["heavy"] == [0, 0, 0], allocation
        assert run.kpis["tasks"] == 6


def test_a_policy_cannot_give_a_task_to_another_kind():
    flows = {"heavy": {"from": "dock", "to": "pack", "arrivals": ONCE, "kinds": ["truck"]}}
    changes = {"tasks.flows": flows, "fleet.size": 2, "fleet.kinds": {"truck": {"count": 1}}}
    steps = dw.steps(dw.load(RING, changes))
    decision = next(steps)
    assert [decision.feasible(robot, decision.tasks[0]) for robot in decision.robots] == [True, False]
    with pytest.raises(dw.PolicyError, match="robot 1 is of no kind that does task 0: truck"):
        steps.tell([(1, 0)])


def test_a_decision_with_a_task_for_another_kind_is_refused_as_a_whole():
    """Robot 0, the truck, could take its load. As robot 1 cannot take the other one, robot 0 stays free."""
    twice = {"schedule": [{"at": 0, "tasks": 2}]}
    flows = {"heavy": {"from": "dock", "to": "pack", "arrivals": twice, "kinds": ["truck"]}}
    changes = {"tasks.flows": flows, "fleet.size": 2, "fleet.kinds": {"truck": {"count": 1}}}
    steps = dw.steps(dw.load(RING, changes))
    next(steps)
    with pytest.raises(dw.PolicyError, match="robot 1 is of no kind that does task 1: truck"):
        steps.tell([(0, 0), (1, 1)])
    steps.tell([(0, 1)])
    assert [task.number for task in next(steps).tasks] == [0]


def test_no_task_for_another_kind_can_be_put_into_the_queue_of_a_robot_at_work():
    flows = {
        "light": {"from": "dock", "to": "pack", "arrivals": ONCE},
        "heavy": {"from": "dock", "to": "pack", "arrivals": ONCE, "kinds": ["truck"]},
    }
    changes = {"tasks.flows": flows, "fleet.size": 2, "fleet.kinds": {"truck": {"count": 1}}}
    steps = dw.steps(dw.load(RING, changes))
    number = {task.flow: task.number for task in next(steps).tasks}
    with pytest.raises(dw.PolicyError, match="robot 1 is of no kind that does task"):
        steps.tell([(1, number["light"]), (1, number["heavy"])])


# Several at once

DAY = {
    "name": "day",
    "layout": {
        "blocks": {"columns": 4, "rows": 2, "block_depth": 4, "goods_size": 1.2, "aisle_width": 2.4},
        "bays": {"charging": {"along": "west", "places": 2}, "parking": {"along": "east", "places": 4, "chargers": 0}},
        "stations": {"dock": {"at": ["B", "D"], "places": 3, "servers": 2}, "pack": {"at": ["L", "N"], "places": 3}},
    },
    "fleet": {"size": 8, "start": ["parking"], "robot": {"radius": 0.4, "speed": 1.5, "margin": 0.1}},
    "tasks": {
        "load_time": {"lognormal": {"mean": 8, "cv": 0.4}},
        "unload_time": {"gamma": {"mean": 10, "cv": 0.5}},
        "flows": {
            "inbound": {"from": "dock", "to": "storage", "arrivals": {"poisson": 40}},
            "outbound": {
                "from": {"popularity": {"classes": [{"share": 0.2, "demand": 0.8}, {"share": 0.8, "demand": 0.2}]}},
                "to": "pack",
                "arrivals": {"profile": {"per_hour": [60, 180, 60]}},
                "due_within": 600,
                "priority": [{"priority": 1, "share": 0.9}, {"priority": 5, "share": 0.1}],
            },
            "restock": {"from": "storage", "to": "storage", "arrivals": {"saturated": 2}, "priority": -1},
        },
    },
    "battery": {"capacity": 1500, "threshold": 300, "consumption": 0.5, "charge_rate": 4},
    "policies": {"allocation": "earliest-due", "charging": "four-thresholds"},
    "run": {"length": 7200, "warm_up": 600},
    "log": "all",
}


def day(changes=(), seed=2):
    return dw.simulate(dw.load(DAY, dict(changes)), seed)


@pytest.fixture(scope="module")
def plain():
    return day()


@pytest.mark.slow
@pytest.mark.parametrize("length", [2400, pytest.param(7200, marks=pytest.mark.long)])
def test_a_run_of_three_flows_is_sound(length):
    run = day({"run.length": length})
    assert {task.flow for task in run.history.delivered} == {"inbound", "outbound", "restock"}
    assert audit(run) == []
    assert faults(run) == []


def test_three_flows_run_at_once(plain):
    assert little.faults(plain) == []  # for each flow, too
    for flow in ("inbound", "outbound", "restock"):
        assert plain.kpis[f"tasks:{flow}"] > 50
    restocked = [task for task in plain.history.tasks.values() if task.flow == "restock"]
    open_at_end = [task for task in restocked if task.number not in {one.task for one in plain.history.assignments}]
    assert len(open_at_end) == 2


def test_indicators_of_flows_are_those_of_their_tasks(plain):
    history, kpis = plain.history, plain.kpis
    counted = [task for task in history.delivered if task.delivered >= 600]
    for flow in ("inbound", "outbound", "restock"):
        mine = [task for task in counted if task.flow == flow]
        times = [task.delivered - task.released for task in mine]
        assert kpis[f"tasks:{flow}"] == len(mine)
        assert kpis[f"throughput_per_hour:{flow}"] == pytest.approx(len(mine) / (6600 / 3600))
        assert kpis[f"cycle_time_mean:{flow}"] == pytest.approx(np.mean(times))
        assert kpis[f"cycle_time_p95:{flow}"] == pytest.approx(np.quantile(times, 0.95))
    mine = [task for task in history.tasks.values() if task.flow == "outbound"]
    falls_due = [task for task in mine if 600 <= task.due <= 7200]
    assert kpis["tasks_due:outbound"] == len(falls_due) > 0
    assert kpis["on_time:outbound"] == pytest.approx(np.mean([task.delivered <= task.due for task in falls_due]))
    assert "on_time:inbound" not in kpis
    assert sum(kpis[f"tasks:{flow}"] for flow in DAY["tasks"]["flows"]) == kpis["tasks"]
    assert sum(kpis[f"backlog:{flow}"] for flow in DAY["tasks"]["flows"]) == kpis["backlog"]


# What is drawn

CHANGES = [
    {"fleet.size": 5},
    {"fleet.size": 12},
    {"fleet.robot.speed": 1},
    {"fleet.kinds": {"slow": {"count": 3, "speed": 0.8}}},
    {"fleet.start_energy": {"uniform": [0.5, 1]}},
    {"fleet.exit_time": 4},
    {"policies.allocation": "nearest"},
    {"policies.allocation": "hungarian"},
    {"policies.routing": "fastest"},
    {"policies.charging": "threshold"},
    {"policies.parking": "nearest"},
    {"battery": None},
    {"traffic.node_time": 1},
    {"traffic.collision_angle": 60},
    {"tasks.station_choice": "random"},
    {"tasks.station_choice": "least-loaded"},
    {"tasks.clear_time": 3},
    {"tasks.flows.more": {"from": "pack", "to": "dock", "arrivals": {"poisson": 30}}},
    {"tasks.flows.restock.arrivals.saturated": 5},
    {"tasks.flows.inbound.arrivals": {"schedule": [{"at": 0, "tasks": 9}]}},
    {"run.warm_up": 0, "log": "tasks"},
    {"fleet.robot.capacity": 3, "policies.batching": "fixed-size"},
    {"fleet.robot.capacity": 3, "policies.batching": {"name": "time-window", "window": 60}},
    {"fleet.robot.acceleration": 0.5},
    {"fleet.robot.breakdowns": {"every": {"exponential": 900}, "repair": {"exponential": 100}}},
    {"fleet.robot.delays": {"share": 0.3, "time": {"exponential": 5}}},
    {"layout.bays.charging.outages": {"every": {"exponential": 900}, "repair": {"exponential": 100}}},
    {"people": {"pickers": {"per_hour": 60, "stay": {"exponential": 30}}}},
    {"calendars.rounds": {"every": 600, "lasts": 500}, "fleet.hours": "rounds", "layout.stations.pack.hours": "rounds"},
    {"tasks.flows.restock.via": ["pack"], "tasks.flows.restock.stop_time": {"lognormal": {"mean": 5, "cv": 1}}},
]


def drawn(run, flow):
    """Of each task of a flow, by its rank: when it came, where from, where to, how urgent, how long it took."""
    tasks = [task for task in run.history.tasks.values() if task.flow == flow]
    rank = {task.number: nth for nth, task in enumerate(tasks)}
    times = {state: {} for state in ("loading", "unloading")}
    for spans in run.history.states:
        for span in spans:
            if span.state in times and span.task in rank and span.end < run.T:
                times[span.state][rank[span.task]] = span.end - span.start
    return [(task.released, task.good, task.due) for task in tasks], times


@pytest.mark.slow
@pytest.mark.parametrize("changes", some(CHANGES, 10), ids=str)
def test_what_a_flow_draws_does_not_depend_on_anything_else(changes, plain):
    """All other flows have the same tasks, each of which takes as long to load and unload."""
    run = day(changes)
    for flow in set(DAY["tasks"]["flows"]) - {key.split(".")[2] for key in changes if key.startswith("tasks.flows.")}:
        tasks, times = drawn(plain, flow)
        others, other_times = drawn(run, flow)
        if flow == "restock":  # as many as are done: the nth is the same, when it comes is not
            tasks, others = ([good for _, good, _ in some] for some in (tasks, others))
            tasks, others = tasks[: len(others)], others[: len(tasks)]
        assert others == tasks
        for state, durations in times.items():
            both = durations.keys() & other_times[state].keys()
            assert len(both) > 60
            assert {nth: other_times[state][nth] for nth in both} == pytest.approx(
                {nth: durations[nth] for nth in both}
            )


def test_of_tasks_that_are_always_open_the_nth_is_the_same(plain):
    def places(run):
        return [task.good for task in run.history.tasks.values() if task.flow == "restock"]

    few = places(day({"fleet.size": 4, "run.length": 3600}))
    assert places(plain)[: len(few)] == few


# When


def arrivals(written, seed=1, until=24 * 3600.0, **changes):
    """The times of a flow's tasks, without the warehouse."""
    model = dw.load(RING, {"tasks.flows": {"f": {"from": "dock", "to": "pack", "arrivals": written}}, **changes})
    flow = _Flow("f", model.tasks.flows["f"], model, build(model.layout), Streams(seed))
    times = []
    for time in flow.arrivals():
        if time >= until:
            return times
        times.append(time)
    return times


LONG = {"run.length": 24 * 3600}
RATES = [20, 60, 0, 200]


@pytest.mark.parametrize("days", [30, pytest.param(60, marks=pytest.mark.long)])
def test_a_profile_keeps_its_rates_hour_by_hour(days):
    counts = np.zeros((days, 24))
    for seed in range(days):
        counts[seed] = np.histogram(arrivals({"profile": {"per_hour": RATES}}, seed, **LONG), 24, (0, 86400))[0]
    for hour in range(24):
        rate = RATES[hour % 4]  # it begins anew
        low, high = stats.poisson.interval(0.99, days * rate)
        assert low <= counts[:, hour].sum() <= high
        if rate:  # as many as their mean: dispersion 1
            dispersion = counts[:, hour].var(ddof=1) / rate * (days - 1)
            assert stats.chi2.ppf(0.0005, days - 1) < dispersion < stats.chi2.ppf(0.9995, days - 1)


@pytest.mark.parametrize("days", [7, pytest.param(20, marks=pytest.mark.long)])
def test_within_a_rate_arrivals_are_even(days):
    times = [
        time % 900
        for seed in range(days)
        for time in arrivals({"profile": {"per_hour": [300], "every": 900}}, seed, **LONG)
    ]
    assert stats.kstest(times, stats.uniform(0, 900).cdf).pvalue > 0.001


def test_the_nth_arrival_of_any_profile_is_the_nth_of_the_other():
    """By inversion: the same chance, at other rates."""
    steady = arrivals({"poisson": 60}, **LONG)
    rates = Rates(Profile(per_hour=(20, 100)), 3600, "00:00")
    varying = arrivals({"profile": {"per_hour": [20, 100]}}, **LONG)
    assert [rates.expected(time) * 60 for time in varying] == pytest.approx(steady[: len(varying)])


def test_demand_multiplies_all_rates():
    plain = arrivals({"profile": {"per_hour": [60, 120]}}, **LONG)
    twice = arrivals({"profile": {"per_hour": [60, 120]}}, **LONG, **{"tasks.demand": 2})
    assert twice == arrivals({"profile": {"per_hour": [120, 240]}}, **LONG)
    assert len(twice) == pytest.approx(2 * len(plain), rel=0.1)
    goods = {"tasks.unload_at": ["D"], "run.length": 7200, "tasks.goods": {"poisson": 100}}
    one, two = dw.load(RING, {**goods, "tasks.demand": 2}), dw.load(RING, {**goods, "tasks.goods": {"poisson": 200}})
    assert [row[:2] for row in dw.simulate(one).record.rows] == [row[:2] for row in dw.simulate(two).record.rows]


def test_demand_multiplies_a_schedule_and_rounds_its_sum():
    schedule = {"schedule": [{"at": 20, "tasks": 2}, {"at": 0}, {"at": 10}]}
    # 1, 2 and 4 by then; 1.5 times as many: 1.5, 3 and 6, of which 2, 3 and 6 are released
    assert arrivals(schedule, **{"tasks.demand": 1.5}) == [0, 0, 10, 20, 20, 20]
    run = ring({**FROM_TO, "arrivals": schedule}, tasks__demand=1.5)
    assert run.kpis["tasks"] == 6


FROM_TO = {"from": "dock", "to": "pack"}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"tasks.flows": {"f": {**FROM_TO, "arrivals": {"saturated": 2}}}, "run.length": 9}, "no rate to multiply"),
        ({"tasks.goods": [0], "tasks.flows": {}, "tasks.unload_at": ["pack"]}, "there is no rate to multiply"),
        (
            {"tasks.flows": {"f": {**FROM_TO, "arrivals": {"orders": {"file": "x.csv"}}}}},
            "or resample: in tasks.flows.f",
        ),
    ],
)
def test_demand_that_multiplies_nothing_is_refused(changes, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.csv").write_text("release\n0\n", encoding="utf-8")
    with pytest.raises(ModelError, match=message):
        dw.load(RING, {**changes, "tasks.demand": 1.2})


def test_a_schedule_comes_as_it_says():
    assert arrivals({"schedule": [{"at": 60, "tasks": 2}, {"at": 5}]}) == [5, 60, 60]


@pytest.mark.parametrize("time", [0, 10, 3600, 5000, 7200, 9000, 10800, 20000])
def test_expected_and_when_are_inverse(time):
    rates = Rates(Profile(per_hour=(60, 0, 120)), 3600, "00:00")
    assert rates.expected(rates.when(rates.expected(time))) == pytest.approx(rates.expected(time))
    steps = [60 * min(time % 10800, 3600) / 3600, 120 * max(time % 10800 - 7200, 0) / 3600]
    assert rates.expected(time) == pytest.approx(180 * (time // 10800) + sum(steps))


# From-to matrix


@pytest.mark.slow
@pytest.mark.parametrize("hours", [8, pytest.param(20, marks=pytest.mark.long)])
def test_a_from_to_matrix_gives_every_pair_its_rate(tmp_path, hours):
    (tmp_path / "from_to.csv").write_text("from,pack,storage\ndock,30,10\nstorage,60,\n", encoding="utf-8")
    written = dict(
        RING, tasks={**RING["tasks"], "flows": {"all": {"from_to": {"file": str(tmp_path / "from_to.csv")}}}}
    )
    model = dw.load(written, {"run.length": hours * 3600, "log": "tasks", "fleet.size": 3})
    assert [(pair.source, pair.per_hour) for pair in model.tasks.flows["all"].from_to][:2] == [
        (("B",), 30),
        (("B",), 10),
    ]
    run = dw.simulate(model)
    ends = Counter(
        ("storage" if task.good >= 0 else "dock", "pack" if row.edge is None else "storage")
        for row in run.history.rows("delivered")
        for task in [run.history.tasks[row.task]]
    )
    arrived = len(run.history.tasks)
    low, high = stats.poisson.interval(0.999, hours * 100)
    assert low <= arrived <= high
    total = sum(ends.values())
    shares = {("dock", "pack"): 0.3, ("dock", "storage"): 0.1, ("storage", "pack"): 0.6}
    assert ends.keys() == shares.keys()
    assert stats.chisquare([ends[key] for key in shares], [share * total for share in shares.values()]).pvalue > 1e-4


def test_a_cell_of_the_matrix_that_is_no_rate_is_named(tmp_path):
    (tmp_path / "from_to.csv").write_text("from,pack,nowhere\ndock,many,2\n", encoding="utf-8")
    flows = {"all": {"from_to": {"file": str(tmp_path / "from_to.csv")}}}
    with pytest.raises(ModelError) as refused:
        dw.load(dict(RING, tasks={**RING["tasks"], "flows": flows}), {"run.length": 3600})
    message = "\n".join(refused.value.problems)
    assert "from_to.csv:2:6: tasks.flows.all.from_to.0.per_hour: should be a number (got 'many')" in message
    assert "from_to.csv:2:11: tasks.flows.all.from_to.1.to.0: no such node or station (got 'nowhere')" in message


def test_what_may_hold_a_day_up_is_asked_of_flows_too(plain):
    reliefs = {suspect.name: suspect.overrides for suspect in suspects(plain)}
    assert reliefs["demand"] == {"tasks.demand": 0.95}
    assert reliefs["handling"]["tasks.load_time"].mean == pytest.approx(8 * 0.9)
    assert {"places of dock", "places of pack"} <= reliefs.keys()
    for change in reliefs.values():
        plain.model.replace(change)


# The clock of a profile

DAY_RATES = [0] * 6 + [200] * 16 + [0] * 2


@pytest.mark.parametrize(
    ("rates", "every", "start", "expected"),
    [
        (DAY_RATES, None, "06:00", 1600),  # a day from midnight: all of the 8 hours from 06:00 at 200
        (DAY_RATES, None, "2026-03-02T20:30", 300),  # until 22:00
        (DAY_RATES, None, "00:00", 400),
        (DAY_RATES[:23], None, "06:00", 400),  # 23 h: no day, so the first rate is that of the start of the run
        ([0, 100], 12, "06:00", 200),  # 24 h, too: 100 an hour from noon to 14:00
        ([0, 100], None, "06:00", 400),
    ],
)
def test_a_profile_of_a_day_goes_by_the_clock_and_any_other_by_the_run(rates, every, start, expected):
    """Of eight hours; by the run the first six of a day have no orders."""
    profile = Profile(per_hour=rates, every=None if every is None else every * 3600)
    demand = Rates(profile, 3600, start)
    assert demand.expected(8 * 3600) == pytest.approx(expected)
    for tasks in (0.5, expected / 2, expected - 0.5, expected + 0.5, 1000.5):
        assert demand.expected(demand.when(tasks)) == pytest.approx(tasks)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rates", "length", "ending"),
    [
        ([10] * 24, "8 h", "begin at midnight, and the run starts at 06:00: the rate of that hour comes first"),
        ([10] * 24, "24 h", "begin at midnight, and the run starts at 06:00: the rate of that hour comes first"),
        ([10] * 8, "24 h", "the first holds from the start of the run on, and the run starts at 06:00"),
        ([0] * 6 + [10] * 18, "16 h", None),  # the first orders of the day come as the run starts
        ([10] * 16, "16 h", None),  # as many hours as the run has: there is nothing to mistake
    ],
)
def test_check_says_by_which_clock_a_profile_goes(rates, length, ending):
    over = {
        "tasks.goods": dw.UNSET,
        "tasks.unload_at": dw.UNSET,
        "tasks.station_choice": dw.UNSET,
        "tasks.flows": {"o": {"from": "storage", "to": "packing", "arrivals": {"profile": {"per_hour": rates}}}},
        "run": {"start": "06:00", "length": length},
    }
    texts = [
        item.text for item in dw.check(dw.load("models/people.yaml", over)).findings if item.code == "PROFILE_CLOCK"
    ]
    assert len(texts) == (ending is not None)
    assert all(text.endswith(str(ending)) for text in texts)
