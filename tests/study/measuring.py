"""Functions that tests send to other processes: an indicator of the user's own, and a run as a row."""

from pathlib import Path

import desim_warehouse as dw

MODEL = dw.load(Path(__file__).parents[2] / "models" / "tutorial.yaml")


def per_task(run: dw.Run) -> float:
    assert isinstance(run, dw.Run)
    return float(run.robots["distance"].sum() / run.kpis["tasks"])


def row_of(size, seed):
    return dw.simulate(MODEL.replace({"fleet.size": size}), seed=seed).table
