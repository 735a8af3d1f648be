"""Chargers as repairmen: robots that break down when their batteries run low, and what n chargers can give."""

import math

import pytest

from desim_warehouse.log import STATES
from tests.theory.estimate import agrees, means
from tests.theory.test_queues import robots_that_serve

PETALS = 40
SPEED = 1000.0


def petals(mean):
    """Rings of two nodes at A; the times round them are about exponential: the means of equal parts of that law."""
    nodes, edges, storage = {"A": [0.0, 0.0]}, [], []
    for i in range(PETALS):
        low, high = (-math.log(1 - part) if part < 1 else math.inf for part in (i / PETALS, (i + 1) / PETALS))
        upper = (high + 1) * math.exp(-high) if math.isfinite(high) else 0.0
        time = PETALS * ((low + 1) * math.exp(-low) - upper) * mean
        angle, half = 2 * math.pi * i / PETALS, time * SPEED / 2
        nodes[f"P{i}"] = [half * math.cos(angle), half * math.sin(angle)]
        ends = ("A", f"P{i}"), (f"P{i}", "A")
        edges += [{"from": a, "to": b, "side_by_side": True} for a, b in ends]
        storage.append({"edge": ["A", f"P{i}"], "offset": half / 2})
    return {"nodes": nodes, "edges": edges, "storage": storage}


def repairman(machines, up, repair):
    """Part of the time that one repairman is busy; up times exponential, repair constant (Takacs, M/G/1//N)."""
    product, total = 1.0, 1.0
    for i in range(1, machines):
        product *= math.exp(i * repair / up) - 1  # (1 - f) / f, with f the transform of a constant
        total += math.comb(machines - 1, i) * product
    return 1 - 1 / (1 + machines * repair / up * total)


def test_the_formula_for_one_machine_is_a_renewal_process():
    assert repairman(1, 30.0, 10.0) == pytest.approx(10 / 40)


def fleet_with_one_charger(robots, up, swap, rounds):
    """After every task a robot needs a new battery; one is swapped at a time."""
    length = rounds * (up + swap)
    layout = petals(up)
    layout["bays"] = {"home": {"at": ["A"], "chargers": 1}}
    return {
        "layout": layout,
        "fleet": {"size": robots, "robot": {"radius": 0.05, "speed": SPEED}},
        "tasks": {"goods": {"saturated": robots}, "unload_at": ["A"], "load_time": 0, "unload_time": 0},
        "battery": {"capacity": 1e4, "threshold": 0, "consumption": 1, "charge_rate": 1},
        "policies": {"charging": {"name": "swap", "time": swap, "level": 1 - 2e-6}},
        "run": {"length": length, "warm_up": length / 10},
        "log": "tasks",
    }


@pytest.mark.parametrize(("robots", "up", "swap"), [(1, 100.0, 50.0), (4, 100.0, 30.0)])
def test_the_machine_repairman(robots, up, swap):
    model = fleet_with_one_charger(robots, up, swap, rounds=500)
    busy = repairman(robots, up, swap)
    runs = means(model, lambda run: run.kpis, runs=10)
    agrees([robots * kpis["share_charging"] for kpis in runs], busy)
    agrees([kpis["throughput_per_hour"] for kpis in runs], 3600 * busy / swap)


ROUND = 100 + 50 * math.sqrt(2)


def fleet_on(chargers, robots, consumption, charge_rate):
    """Robots that always have work, and a battery that lasts for some dozen rounds of it."""
    length = 1e5
    return {
        "layout": {
            "nodes": {"A": [0, 0], "B": [50, 0], "C": [50, 50]},
            "edges": [["A", "B"], ["B", "C"], ["C", "A"]],
            "storage": [{"edge": ["A", "B"], "offset": 25}],
            "bays": {"home": {"at": ["A"], "chargers": chargers}},
        },
        "fleet": {"size": robots, "robot": {"radius": 0.05, "speed": 100}},
        "tasks": {"goods": {"saturated": robots}, "unload_at": ["A"], "load_time": 28, "unload_time": 0},
        "battery": {"capacity": 1000, "threshold": 300, "consumption": consumption, "charge_rate": charge_rate},
        "run": {"length": length, "warm_up": length / 5},
        "log": "tasks",
    }


@pytest.mark.parametrize(("chargers", "robots"), [(1, 1), (4, 4), (3, 6), (2, 6), (1, 6)])
def test_a_fleet_draws_what_its_chargers_give(chargers, robots):
    """Power in is power out: robots at work draw p, a charger gives r.

    With a charger for each, a robot works r of every p + r. With few they are always busy and carry k r / p robots.
    """
    p, r = 0.5, 1.0
    run = means(fleet_on(chargers, robots, p, r), lambda run: run, runs=1)[0]
    at_work = min(robots * r / (p + r), chargers * r / p)
    hours = (run.T - run.model.run.warm_up) / 3600
    kpis = run.kpis
    resting = kpis["share_charging"] + kpis["share_queueing"] + kpis["share_idle"]
    assert robots * (1 - resting) == pytest.approx(at_work, rel=0.03)
    assert kpis["energy"] / hours / 3600 == pytest.approx(p * at_work, rel=0.03)
    assert robots * kpis["share_charging"] == pytest.approx(p * at_work / r, rel=0.03)
    if chargers * r / p < robots * r / (p + r):
        assert robots * kpis["share_charging"] == pytest.approx(chargers, rel=0.01)


def test_random_work_draws_its_part_and_is_charged_that_much():
    """Tasks at random, load of the robots without charging 0.4: in work they draw p, and chargers give it back at r."""
    p, r, load, robots = 0.5, 1.0, 0.4, 3
    model = robots_that_serve(load, 1000.0, robots, tasks=1500)
    model["battery"] = {"capacity": 5000, "threshold": 1000, "consumption": p, "charge_rate": r}
    counted = model["run"]["length"] - model["run"]["warm_up"]
    runs = means(model, lambda run: run.kpis)
    agrees([kpis["energy"] / counted for kpis in runs], load * robots * p)
    agrees([robots * kpis["share_charging"] for kpis in runs], load * robots * p / r)


def test_no_energy_is_lost():
    """What was drawn is what was charged and what is missing from the batteries at the end."""
    model = fleet_on(2, 6, 0.5, 1.0)
    model["run"] = {"length": 3e4}
    run = means(model, lambda run: run, runs=1)[0]
    rows = [row for row in run.record.rows if row[1] != "released" and row[6] is not None]
    left = {row[2]: (row[0], row[6]) for row in rows}
    state = {row[2]: row[1] for row in rows if row[1] in STATES}
    now = 0.0
    for robot, (time, level) in left.items():
        rate = {"charging": 1.0, "idle": 0.0, "queueing": 0.0}.get(state[robot], -0.5)
        now += min(level + rate * (run.T - time), 1000)
    charged = sum(robot["charging"] for robot in run.record.robots) * 1.0
    assert 6 * 1000 + charged - run.kpis["energy"] == pytest.approx(now, rel=1e-6)
