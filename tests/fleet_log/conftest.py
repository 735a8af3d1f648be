from types import SimpleNamespace

import numpy as np
import pytest

import desim_warehouse as dw
from tests.fleet_log import messages, plants


def plant(folder, seed, hours=2.0, **changes):
    """A random plant: its sheet, what is true of its fleet, a run of that, and the messages of its robots."""
    rng = np.random.default_rng(seed)
    sheet = folder / "sheet.yaml"
    sheet.write_text(plants.sheet(rng, hours), encoding="utf-8")
    base = dw.load(sheet)
    truth = plants.real(rng, base.fleet.size, list(base.floor.graph.edges)) | changes
    run = dw.simulate(dw.load(sheet, truth), seed)
    log = messages.write(run, folder / "day.jsonl", seed)
    return SimpleNamespace(sheet=sheet, base=base, truth=truth, run=run, log=log)


@pytest.fixture(scope="session")
def a_plant(tmp_path_factory):
    """A small one, whose robots break down often."""
    faults = {"every": {"exponential": 800.0}, "repair": {"lognormal": {"mean": 90.0, "cv": 0.5}}}
    return plant(tmp_path_factory.mktemp("plant"), 4, hours=1.0, **{"fleet.robot.breakdowns": faults})
