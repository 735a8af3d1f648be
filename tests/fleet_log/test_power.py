"""How soon wrong models are refuted: the share of samples of so many days that refute each, printed with `-s`."""

import numpy as np
import pytest

import desim_warehouse as dw
from desim_warehouse.fleet_log.measures import measured, parts_of
from desim_warehouse.fleet_log.ranks import LEVEL, ranked
from desim_warehouse.fleet_log.runs import from_run
from tests.fleet_log import plants

TRUE = {
    "layout.bays.charging.chargers": 2,
    "fleet.robot.speed": 1.3,
    "fleet.robot.speed_loaded": 1.1,
    "traffic.node_time": 1.5,
    "tasks.load_time": {"lognormal": {"mean": 12.0, "cv": 0.5}},
    "tasks.unload_time": {"gamma": {"mean": 25.0, "cv": 0.4}},
    "tasks.goods.poisson": 110,
    "fleet.size": 8,
    "battery.consumption": 0.012,
    "log": "all",
}
WRONG = {
    "speed 10 % higher": {"fleet.robot.speed": 1.43, "fleet.robot.speed_loaded": 1.21},
    "unloading takes 20 % longer": {"tasks.unload_time": {"gamma": {"mean": 30.0, "cv": 0.4}}},
    "a charger fewer": {"layout.bays.charging.chargers": 1},
    "in order for nearest": {"policies.allocation": "in-order"},
    "no slow aisle": {"traffic.slow": {}},
    "no people": {"people": {}},
}
ALSO_TRUE = {
    "no slow aisle": {"traffic.slow": {"aisle": {"members": [["B", "I"]], "speed": 0.5}}},
    "no people": {"people": {"pickers": {"per_hour": 30, "stay": 120}}},
}
HOURS, EVERY = 4, 2.0
REAL, POOL, RUNS, SAMPLES = 40, 80, 40, 300
DAYS = (1, 2, 5, 10)


def figures(model, seeds):
    """A row of measures for each simulated day."""
    logs = (from_run(dw.simulate(model, seed), EVERY) for seed in seeds)
    return np.array([list(measured(model, log, parts_of(model, log)).figures.values()) for log in logs])


def power(real, pool, days):
    """The share of samples of so many real days that refute a model, given days of the fleet and of the model.

    Where both are the same days, those that are real are none of the simulated ones.
    """
    rng = np.random.default_rng(days)
    finite = np.isfinite(real).all(axis=0) & np.isfinite(pool).all(axis=0)
    refuted = 0
    for _ in range(SAMPLES):
        chosen = np.array([rng.permutation(len(pool))[: RUNS + 1] for _ in range(days)])
        ours = pool[chosen[:, 0]] if pool is real else real[rng.choice(len(real), days, replace=False)]
        refuted += ranked(ours[:, finite], pool[chosen[:, 1:]][:, :, finite]).p_value <= LEVEL
    return refuted / SAMPLES


@pytest.fixture(scope="module")
def sheet(tmp_path_factory):
    path = tmp_path_factory.mktemp("power") / "sheet.yaml"
    path.write_text(plants.sheet(np.random.default_rng(4), HOURS), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def fleet(sheet):
    """Days of the fleet as it is."""
    return figures(dw.load(sheet, TRUE), range(1000, 1000 + POOL))


def shown(name, shares):
    print(f"{name:30}" + "".join(f"{share:8.0%}" for share in shares))  # noqa: T201 - the table


@pytest.mark.long
def test_the_right_model_is_refuted_by_hardly_any_days(fleet):
    shares = [power(fleet, fleet, days) for days in DAYS]
    shown("the right model", shares)
    assert max(shares) <= 0.09  # 5 %, and three standard errors of 300 samples


@pytest.mark.long
@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_model_is_refuted_within_days(sheet, fleet, name):
    changes = WRONG[name]
    true = TRUE | ALSO_TRUE.get(name, {})
    real = fleet if true == TRUE else figures(dw.load(sheet, true), range(2000, 2000 + REAL))
    pool = figures(dw.load(sheet, true | changes), range(POOL))
    shares = [power(real, pool, days) for days in DAYS]
    shown(name, shares)
    assert shares[DAYS.index(5)] >= 0.75
    assert shares[DAYS.index(10)] >= 0.95
