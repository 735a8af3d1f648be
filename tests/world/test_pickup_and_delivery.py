"""Pickup and delivery as in multi-agent research: every task has its own origin, destination and release."""

import random
from collections import defaultdict
from itertools import pairwise

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import desim_warehouse as dw
from desim_warehouse.layout.travel import travel_on
from tests.auditor import audit

pytestmark = pytest.mark.slow
SIDE = 6


def grid():
    """A one-way grid with alternating streets, 10 apart, and a bay at every corner."""
    nodes = {f"n{x}{y}": [10 * x, 10 * y] for x in range(SIDE) for y in range(SIDE)}
    edges = []
    for i in range(SIDE):
        for a in range(SIDE - 1):
            b = a + 1
            east = i % 2 == 0
            edges.append([f"n{a}{i}", f"n{b}{i}"] if east else [f"n{b}{i}", f"n{a}{i}"])
            edges.append([f"n{i}{b}", f"n{i}{a}"] if i % 2 == 0 else [f"n{i}{a}", f"n{i}{b}"])
    corners = [f"n{x}{y}" for x in (0, SIDE - 1) for y in (0, SIDE - 1)]
    return {
        "nodes": nodes,
        "edges": edges,
        "storage": [{"node": "n22"}],
        "bays": {"corners": {"at": corners, "places": 4}},
    }


def instance(seed, path, count=40):
    """Tasks from anywhere to anywhere else, one every 5 on average."""
    rng = random.Random(seed)
    inner = [f"n{x}{y}" for x in range(1, SIDE - 1) for y in range(1, SIDE - 1)]
    release, rows = 0.0, []
    for _ in range(count):
        start, goal = rng.sample(inner, 2)
        rows.append((round(release, 3), start, goal))
        release += rng.expovariate(1 / 5)
    path.write_text("release,from,to\n" + "".join(f"{r},{a},{b}\n" for r, a, b in rows), encoding="utf-8")
    return rows


def solved(seed, path, robots, allocation):
    rows = instance(seed, path)
    flow = {"from": "storage", "to": "n33", "arrivals": {"orders": {"file": str(path)}}}
    model = dw.load(
        {
            "layout": grid(),
            "fleet": {"size": robots, "robot": {"radius": 0.5, "speed": 1}},
            "tasks": {"flows": {"mapd": flow}, "load_time": 0, "unload_time": 0},
            "policies": {"allocation": allocation, "routing": "fastest"},
        }
    )
    return rows, dw.simulate(model)


@pytest.mark.parametrize("allocation", ["in-order", "nearest", "hungarian"])
@pytest.mark.parametrize("seed", range(3))
def test_every_task_goes_from_its_origin_to_its_destination(seed, allocation, tmp_path):
    rows, run = solved(seed, tmp_path / "mapd.csv", 6, allocation)
    assert audit(run) == []
    assert run.kpis["tasks"] == len(rows)
    at = {(row.kind, row.task): row.node for row in run.history.rows("loaded", "delivered")}
    for number, (release, start, goal) in enumerate(rows):
        task = run.history.tasks[number]
        assert (at["loaded", number], at["delivered", number]) == (start, goal)
        assert release == task.released <= task.loaded < task.delivered


def test_in_order_takes_the_tasks_in_the_order_of_their_release(tmp_path):
    _, run = solved(1, tmp_path / "mapd.csv", 2, "in-order")
    assert [one.task for one in run.history.assignments] == sorted(one.task for one in run.history.assignments)


def simulated(rows, path, robots, **changes):
    """A run of tasks (release, stops in order) on the grid, without handling times; robots start at the corners."""
    lines = [f"{release},{stops[0]},{' > '.join(stops[1:-1])},{stops[-1]}" for release, stops in rows]
    path.write_text("release,from,via,to\n" + "\n".join(lines) + "\n", encoding="utf-8")
    flow = {"from": "storage", "to": "n33", "arrivals": {"orders": {"file": str(path)}}}
    model = {
        "layout": grid(),
        "fleet": {"size": robots, "robot": {"radius": 0.5, "speed": 1}},
        "tasks": {"flows": {"mapd": flow}, "load_time": 0, "unload_time": 0},
        "policies": {"allocation": "nearest", "routing": "fastest"},
    }
    return dw.simulate(dw.load(model, {key.replace("__", "."): value for key, value in changes.items()}))


def bounds(run, rows):
    """What no makespan is below, whatever is decided, for robots that carry so many loads.

    A task is done no sooner than some robot can have come to it, or it is known, and then drives from stop to stop; and
    the drives of all tasks together are shared by all robots, each with as many loads on board as it carries.
    """
    travel = travel_on(run.layout, 1.0, 0.0, "time", ())
    starts = run.model.fleet.homes(run.layout.bays)
    drives = [sum(travel.time(a, b) for a, b in pairwise(stops)) for _, stops in rows]
    comes = [max(release, min(travel.time(start, stops[0]) for start in starts)) for release, stops in rows]
    alone = max(come + drive for come, drive in zip(comes, drives, strict=True))
    return alone, sum(drives) / sum(robot.capacity for robot in run.model.fleet.robots())


def makespan(run):
    return max(task.delivered for task in run.history.delivered)


def test_bounds_and_makespan_worked_out_by_hand(tmp_path):
    rows = [(0, ("n11", "n31")), (100, ("n22", "n23"))]
    run = simulated(rows, tmp_path / "mapd.csv", 1)
    # From the corner n00 to n11 20; row 1 leads west, so by n01, n00, n30 to n31 60: done at 80. To n23 it is 30 from
    # n22, as column 2 leads the other way, and the task is known at 100: 130. All drives together 90, for one robot.
    assert bounds(run, rows) == (130, 90)
    assert run.history.delivered[0].delivered == 80
    assert makespan(run) >= 130
    # With the second one known from the start nothing but its own order holds the robot up: from n31 by n21, n11, n12
    # to n22 40, and 30
    rows = [(0, ("n11", "n31")), (0, ("n22", "n23"))]
    assert makespan(simulated(rows, tmp_path / "mapd.csv", 1, policies__allocation="in-order")) == 80 + 40 + 30


def test_a_chain_is_driven_in_the_given_order(tmp_path):
    rows = [(0, ("n11", "n31", "n11", "n12"))]
    run = simulated(rows, tmp_path / "mapd.csv", 1)
    # 20 to n11; 60 to n31; 20 back along row 1; 10 down column 1: 110, which is its bound
    assert [row.node for row in run.history.rows("loading", "unloading")] == ["n11", "n31", "n11", "n12"]
    assert bounds(run, rows)[0] == makespan(run) == 110


@pytest.mark.parametrize("robots", [1, 3, 8])
def test_the_makespan_lies_above_its_bounds_and_not_far(robots, tmp_path):
    rows, run = solved(2, tmp_path / "mapd.csv", robots, "nearest")
    tasks = [(release, (start, goal)) for release, start, goal in rows]
    assert max(bounds(run, tasks)) <= makespan(run) <= 3 * max(bounds(run, tasks))


INNER = [f"n{x}{y}" for x in range(1, SIDE - 1) for y in range(1, SIDE - 1)]
CHAINS = st.lists(st.sampled_from(INNER), min_size=2, max_size=4).filter(
    lambda stops: all(a != b for a, b in pairwise(stops)) and stops[0] != stops[-1]
)


@given(
    st.lists(st.tuples(st.integers(0, 60), CHAINS.map(tuple)), min_size=1, max_size=12),
    st.integers(1, 5),
    st.integers(1, 3),
    st.sampled_from(["single", "fixed-size", {"name": "time-window", "window": 20}]),
)
@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25)
def test_of_any_instance_the_stops_are_served_in_order_and_the_makespan_is_above_its_bounds(
    tmp_path, rows, robots, loads, batching
):
    rows = sorted(rows)
    path = tmp_path / "mapd.csv"
    run = simulated(rows, path, robots, fleet__robot__capacity=loads, policies__batching=batching)
    assert audit(run) == []
    served = defaultdict(list)
    for row in run.history.rows("loading", "unloading"):
        served[row.task].append(row.node)
    assert [tuple(served[number]) for number in range(len(rows))] == [stops for _, stops in rows]
    assert all(task.loaded >= release for task, (release, _) in zip(run.history.tasks.values(), rows, strict=True))
    assert makespan(run) >= max(bounds(run, rows)) - 1e-6
