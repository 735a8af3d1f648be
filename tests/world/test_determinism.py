"""The same model and seed give the same log, whatever runs it; what is counted does not depend on what is logged."""

import math
import os
import subprocess
import sys
from collections import Counter, defaultdict

import pytest

import desim_warehouse as dw
from tests.auditor import audit

BUSY = {
    "name": "busy",
    "layout": {
        "blocks": {"columns": 3, "rows": 2, "block_depth": 2, "goods_size": 2, "aisle_width": 2},
        "bays": {"home": {"along": "north"}},
        "stations": {"pack": {"at": ["J"], "places": 2, "servers": 1}},
    },
    "fleet": {"size": 9, "robot": {"radius": 0.4, "speed": 1, "margin": 0.1}, "exit_time": 1},
    "tasks": {"goods": {"random": 60}, "unload_at": ["J", "K"], "load_time": 2, "unload_time": 4, "clear_time": 0.5},
    "battery": {"capacity": 400, "threshold": 150, "consumption": 1, "charge_rate": 5},
    "traffic": {"node_time": 0.5},
}
BUSY["tasks"]["station_choice"] = "nearest"
LIFELONG = {"tasks.goods": {"poisson": 600}, "run.length": 1500, "run.warm_up": 300}


def busy(**changes):
    return dw.load(BUSY, {key.replace("__", "."): value for key, value in changes.items()})


PROGRAM = """
import hashlib, json, sys
import desim_warehouse as dw
from tests.world.test_determinism import BUSY, LIFELONG
for changes in ({}, LIFELONG, {"policies.allocation": "hungarian", "policies.routing": "congestion-aware"}):
    run = dw.simulate(dw.load(BUSY, changes), seed=7)
    rows = json.dumps([list(row) for row in run.record.rows])
    print(hashlib.sha256(rows.encode()).hexdigest(), json.dumps(run.kpis))
"""


@pytest.mark.slow
def test_same_seed_same_log_whatever_the_hash_seed():
    said = []
    for hash_seed in ("0", "1", "4242"):
        environment = {**os.environ, "PYTHONHASHSEED": hash_seed}
        done = subprocess.run([sys.executable, "-c", PROGRAM], env=environment, capture_output=True, check=True)
        said.append(done.stdout)
    assert len(said[0].splitlines()) == 3
    assert said[0] == said[1] == said[2]


def test_a_run_is_the_same_again_in_the_same_process():
    one, two = dw.simulate(busy(), seed=3), dw.simulate(busy(), seed=3)
    assert one.record.rows == two.record.rows
    assert one.kpis == two.kpis
    assert one.log.equals(two.log)


def test_another_seed_gives_another_run():
    assert dw.simulate(busy(), seed=3).record.rows != dw.simulate(busy(), seed=4).record.rows


def test_a_run_leaves_its_model_as_it_was():
    for changes in ({}, {key.replace(".", "__"): value for key, value in LIFELONG.items()}):
        model = busy(**changes)
        before, digest = model.content(), model.digest()
        first = dw.simulate(model, seed=1)
        assert (model.content(), model.digest()) == (before, digest)
        assert dw.simulate(model, seed=1).record.rows == first.record.rows


@pytest.mark.parametrize("changes", [{}, LIFELONG], ids=["finite", "lifelong"])
def test_indicators_do_not_depend_on_how_much_is_logged(changes):
    runs = {level: dw.simulate(dw.load(BUSY, {**changes, "log": level}), seed=5) for level in ("all", "moves", "tasks")}
    everything = runs["all"]
    assert everything.S > 20
    for run in runs.values():
        assert run.kpis == everything.kpis
        assert run.robots.equals(everything.robots)
        assert run.edges.equals(everything.edges)
        assert run.nodes.equals(everything.nodes)
    kinds = {level: {row[1] for row in run.record.rows} for level, run in runs.items()}
    assert kinds["all"] - kinds["moves"] == {"drive", "collision"}
    assert kinds["moves"] - kinds["tasks"] == {"enter"}
    # a level leaves rows out and changes none
    fewer = [row for row in everything.record.rows if row[1] in kinds["tasks"]]
    assert runs["tasks"].record.rows == fewer


def test_tallies_are_a_recount_of_the_rows():
    run = dw.simulate(busy(), seed=5)
    rows = run.record.rows
    count = defaultdict(Counter)
    waited = Counter()
    for _, kind, robot, _, node, edge, value, _, _ in rows:
        count[robot][kind] += 1
        if kind == "collision":
            waited[robot] += value
            count[robot]["crossings" if node is not None else "rear_ends"] += 1
            count["waits"][node or edge] += 1
        if kind == "enter":
            count["passages"][edge] += 1
    for number, robot in enumerate(run.record.robots):
        assert robot["moves"] == count[number]["enter"]
        assert robot["delivered"] == count[number]["delivered"]
        assert robot["recharged"] == count[number]["recharged"]
        assert robot["rear_ends"] == count[number]["rear_ends"]
        assert robot["crossings"] == count[number]["crossings"]
        assert robot["waiting"] == pytest.approx(waited[number])
    for edge in run.record.edges:
        key = tuple(edge["edge"].split(">"))
        assert (edge["passages"], edge["waits"]) == (count["passages"][key], count["waits"][key])
    for node in run.record.nodes:
        names = node["node"].split("+")
        assert node["waits"] == sum(count["waits"][name] for name in names)
    assert run.kpis["T"] == rows[-1][0]
    assert sum(1 for row in rows if row[1] == "collision") == run.S
    assert sum(1 for row in rows if row[1] == "recharged") == run.C
    assert run.kpis["rotations"] == sum(1 for row in rows if row[1] == "rotation")


def test_distance_is_the_length_of_the_edges_driven():
    run = dw.simulate(busy(), seed=5)
    driven = Counter()
    for row in run.record.rows:
        if row[1] == "enter":
            driven[row[2]] += run.layout.graph.edges[row[5]]["length"]
    # all robots are home, so every edge was driven to its end
    assert run.robots["distance"].tolist() == [pytest.approx(driven[robot]) for robot in range(9)]


def test_states_and_waiting_add_up_to_the_time_and_the_energy_to_the_time_awake():
    run = dw.simulate(busy(), seed=5)
    states = ["idle", "empty", "loading", "loaded", "unloading", "returning", "charging", "waiting"]
    assert (run.robots[states].sum(axis=1) - run.T).abs().max() < 1e-6
    assert sum(run.kpis[f"share_{state}"] for state in states) == pytest.approx(1)
    assert run.kpis["share_loading"] * run.T * 9 == pytest.approx(60 * 2)
    assert run.kpis["share_unloading"] * run.T * 9 == pytest.approx(60 * 4)


def test_the_cost_is_the_weighted_sum_of_the_paper_s_outlook():
    run = dw.simulate(busy(cost={"distance": 2, "time": 3, "collisions": 5}), seed=5)
    assert run.kpis["cost"] == pytest.approx(2 * run.kpis["distance"] + 3 * run.T + 5 * run.S)


def test_waits_say_who_waited_for_whom_where_and_when():
    run = dw.simulate(busy(), seed=5)
    waits = run.waits
    assert len(waits) == run.S
    assert (waits["end"] > waits["start"]).all()
    assert (waits["start"] >= 0).all()
    assert (waits["end"] <= run.T).all()
    assert (waits["robot"] != waits["other"]).all()
    assert waits["other"].between(0, 8).all()
    assert (waits["node"].isna() != waits["edge"].isna()).all()
    # one thing at a time
    for _, mine in waits.sort_values("start").groupby("robot"):
        assert (mine["start"].iloc[1:].to_numpy() >= mine["end"].iloc[:-1].to_numpy() - 1e-9).all()


def test_the_busy_warehouse_is_sound():
    run = dw.simulate(busy(), seed=5)
    assert audit(run) == []
    assert run.kpis["tasks"] == 60
    assert not math.isnan(run.kpis["cycle_time_mean"])
