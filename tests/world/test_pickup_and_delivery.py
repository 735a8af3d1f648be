"""Pickup and delivery as in multi-agent research: every task has its own origin, destination and release."""

import random

import pytest

import desim_warehouse as dw
from tests.auditor import audit

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


@pytest.mark.parametrize("robots", [1, 3, 8])
def test_the_makespan_lies_above_its_bounds_and_not_far(robots, tmp_path):
    """No task is done before its own drive is, and no fleet drives its loads faster than all robots all the time."""
    rows, run = solved(2, tmp_path / "mapd.csv", robots, "nearest")
    from desim_warehouse.layout import build
    from desim_warehouse.layout.travel import travel_on

    travel = travel_on(build(run.model.layout), 1.0, 0.0, "time", ())
    loaded = [travel.time(start, goal) for _, start, goal in rows]
    makespan = max(task.delivered for task in run.history.delivered)
    bound = max(sum(loaded) / robots, *(row[0] + time for row, time in zip(rows, loaded, strict=True)))
    assert bound <= makespan <= 3 * bound
