"""The same model and seed give the same log; what is counted does not depend on what is logged."""

import pytest

import desim_warehouse as dw
from tests.laws.features import EVERYTHING, warehouse

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


@pytest.mark.parametrize("features", ["", "tours", "pods", EVERYTHING])
@pytest.mark.parametrize("count", [2, pytest.param(3, marks=pytest.mark.long)])
def test_indicators_of_no_warehouse_depend_on_how_much_is_logged(features, count):
    for number in range(count):
        model = dw.load(warehouse(number, features))
        runs = [dw.simulate(model.replace({"log": level}), number) for level in ("all", "moves", "tasks")]
        for run in runs[1:]:
            assert repr(run.kpis) == repr(runs[0].kpis), number


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
