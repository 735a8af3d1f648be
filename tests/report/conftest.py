from pathlib import Path

import pandas as pd
import pytest

import desim_warehouse as dw
from desim_warehouse.questions.study import Study

MULTIBOTS = Path(__file__).parents[2] / "models" / "multibots.yaml"


@pytest.fixture(scope="session")
def model():
    return dw.load(MULTIBOTS)


@pytest.fixture(scope="session")
def run(model):
    return dw.simulate(model)


@pytest.fixture(scope="session")
def lifelong(model):
    """Tasks without end, batteries that run low, and other rates for standing than for driving."""
    rates = {"standing": 0.002, "empty": 0.005, "loaded": 0.006, "handling": 0.003}
    changes = {
        "tasks.goods": {"saturated": 12},
        "run.length": 6000,
        "battery.consumption": rates,
        "battery.taper": {"start": 0.8},
    }
    return dw.simulate(model.replace(changes), seed=1)


@pytest.fixture(scope="session")
def study_folder(model, tmp_path_factory):
    """A random study with names that no page and no figure may take for anything but names."""
    folder = tmp_path_factory.mktemp("study")
    hostile = {'<script>alert("1")</script>': [11, 8, 39], "$\\frac{مستودع}$ 'x' & <b>": {"random": 8}}
    study = Study(
        model,
        {"fleet.size": [1, 3, 6], "tasks.goods": {"named": hostile}},
        replications=3,
        seed=5,
        indicators=["T", "S", "throughput_per_hour", "waiting"],
        name="<script>alert(1)</script> & “quotes” مستودع $x$",
    )
    study.run(out=folder)
    return folder


@pytest.fixture(scope="session")
def runs():
    """Two factors, three replications, numbers that can be checked by hand."""
    rows = [
        {"fleet.size": size, "battery.threshold": threshold, "replication": r, "T": 100 * size + threshold + r}
        for threshold in (2.0, 5.0)
        for size in (1, 2, 4)
        for r in range(3)
    ]
    return pd.DataFrame(rows)
