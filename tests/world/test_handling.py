"""Handling times that vary: one draw for each task and purpose, whoever does it and whatever else happens."""

import numpy as np
import pytest
from scipy import stats

import desim_warehouse as dw
from desim_warehouse.questions.check import check

pytestmark = pytest.mark.usefixtures("brief_probes")
FLOOR = {
    "name": "handling",
    "layout": {
        "blocks": {"columns": 5, "rows": 2, "block_depth": 5, "goods_size": 2, "aisle_width": 2},
        "bays": {"home": {"along": "north"}},
        "stations": {"pack": {"at": ["P"], "places": 20, "servers": 20}},
    },
    "fleet": {"size": 6, "robot": {"radius": 0.4, "speed": 2}},
    "tasks": {
        "goods": {"random": 60},
        "unload_at": ["P"],
        "load_time": {"lognormal": {"mean": 8, "cv": 0.4}},
        "unload_time": {"uniform": [5, 15]},
    },
    "battery": {"capacity": 400, "threshold": 120, "consumption": 1, "charge_rate": 5},
}


def simulated(changes, seed=3):
    return dw.simulate(dw.load(FLOOR, changes), seed)


def times(run, state):
    """How long each task was in a state of a robot."""
    return {span.task: span.end - span.start for robot in run.history.states for span in robot if span.state == state}


@pytest.fixture(scope="module")
def plain():
    return simulated({})


def test_handling_takes_as_long_as_is_drawn(plain):
    loading, unloading = times(plain, "loading"), times(plain, "unloading")
    assert sorted(loading) == sorted(unloading) == list(range(60))
    sigma = np.sqrt(np.log1p(0.16))
    lognormal = stats.lognorm(sigma, scale=8 / np.exp(sigma**2 / 2))
    assert stats.kstest(list(loading.values()), lognormal.cdf).pvalue > 0.001
    assert stats.kstest(list(unloading.values()), stats.uniform(5, 10).cdf).pvalue > 0.001
    assert abs(np.corrcoef([loading[n] for n in loading], [unloading[n] for n in loading])[0, 1]) < 0.4


def test_another_seed_draws_other_times(plain):
    other = times(simulated({}, seed=4), "loading")
    assert all(other[task] != pytest.approx(time) for task, time in times(plain, "loading").items())


def test_a_list_of_goods_is_not_deterministic_then():
    listed = {"tasks.goods": [0, 1, 2], "tasks.unload_time": 5}
    assert not dw.load(FLOOR, listed).is_deterministic
    assert not simulated(listed).deterministic
    assert dw.load(FLOOR, {**listed, "tasks.load_time": {"constant": 8}}).is_deterministic
    assert simulated({**listed, "tasks.load_time": 8}).deterministic


@pytest.mark.slow
def test_check_says_what_varies_and_measures_its_mean():
    report = check(dw.load(FLOOR))
    assert "loading varies: lognormal, mean 8 s, cv 0.4" in report.facts
    assert "unloading varies: uniform from 5 to 15 s, mean 10 s, cv 0.2887" in report.facts
    same = check(dw.load(FLOOR, {"tasks.load_time": 8, "tasks.unload_time": 10}))
    assert report.calculation.cycle.time == pytest.approx(same.calculation.cycle.time, rel=0.01)
