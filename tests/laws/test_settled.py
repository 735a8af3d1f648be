"""Settled batteries stay settled: the mean level of a fleet neither falls nor rises from the start."""

from statistics import fmean, stdev

import pytest

import desim_warehouse as dw
from tests.laws.settling import POLICIES, model

MOST = 0.01
"""Largest drift, as a share of the capacity per hour."""
MOST_OF_ONE = 0.0125
"""Largest drift of any of twenty models; it is larger, as all runs of a model share the chance of its settling run."""
MODELS = 20


def drifts(warehouse, seeds):
    return [dw.simulate(warehouse, seed).kpis["energy_drift_per_hour"] for seed in seeds]


def moves(values):
    """Return by how much the mean drift exceeds two standard errors."""
    return abs(fmean(values)) - 2 * stdev(values) / len(values) ** 0.5


def ring(policy, load):
    """Return eight robots on a ring with four chargers where they rest; levels once rose by 5 to 17 % an hour there."""
    content = {
        "layout": {
            "nodes": {"A": [0, 0], "B": [100, 0], "C": [100, 50], "E": [0, 50]},
            "edges": [["A", "B"], ["B", "C"], ["C", "E"], ["E", "A"]],
            "storage": [{"edge": ["A", "B"], "offset": 30}],
            "bays": {"bay": {"at": ["C"], "places": 9, "chargers": 4}},
            "stations": {"packing": {"at": ["C"], "places": 60, "servers": 8}},
        },
        "fleet": {"size": 8, "robot": {"radius": 0.01, "speed": 2}, "start_energy": "settled"},
        "tasks": {
            "goods": {"poisson": 8 * load * 0.75 * 3600 / 170},
            "unload_at": ["C"],
            "load_time": 0,
            "unload_time": 20,
        },
        "battery": {"capacity": 100, "threshold": 30, "consumption": 0.01, "charge_rate": 0.03},
        "policies": {"charging": policy, "parking": "nearest"},
        "run": {"length": 4 * 3600},
        "log": "tasks",
    }
    return dw.load(content)


@pytest.mark.parametrize("policy", ["reach-aware", "four-thresholds"])
def test_on_a_ring_the_level_stays(policy):
    assert moves(drifts(ring(policy, 0.4), range(5))) < MOST


@pytest.mark.long
@pytest.mark.parametrize("policy", POLICIES, ids=str)
@pytest.mark.parametrize("load", [0.4, 0.8])
def test_on_a_ring_the_level_stays_under_any_load(policy, load):
    assert moves(drifts(ring(policy, load), range(10))) < MOST


@pytest.mark.long
@pytest.mark.parametrize("policy", POLICIES, ids=str)
def test_in_random_warehouses_the_level_stays(policy):
    by_model = [drifts(model(number, policy), range(16)) for number in range(MODELS)]
    assert moves([fmean(values) for values in by_model]) < MOST
    assert max(moves(values) for values in by_model) < MOST_OF_ONE
