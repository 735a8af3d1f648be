"""Charge rate and consumption from levels that are rounded, of batteries drawn by hand: no simulation is asked."""

import numpy as np
import pandas as pd
import pytest

import desim_warehouse as dw
from desim_warehouse.fleet_log.calibrate import energy
from desim_warehouse.fleet_log.floor import lay_over
from desim_warehouse.fleet_log.table import CHARGE, NOTHING, FleetLog, Notes
from tests.daily import some
from tests.fleet_log import plants

ROUNDINGS = {
    "whole per cents": np.round,
    "whole per cents, cut off": np.floor,
    "tenths": lambda level: np.round(level, 1),
    "as they are": lambda level: level,
}


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    path = tmp_path_factory.mktemp("sheet") / "sheet.yaml"
    path.write_text(plants.sheet(np.random.default_rng(0)), encoding="utf-8")
    return dw.load(path)


def day(seed, rounding, hours=6.0, robots=3):
    """The log of a day, and what is true: robots drive between B and C, and charge at B from low to high levels."""
    rng = np.random.default_rng(seed)
    rate, use = rng.uniform(0.015, 0.08), rng.uniform(0.004, 0.01)
    columns = []
    for robot in range(robots):
        time = np.sort(np.arange(0.0, hours * 3600) + rng.normal(0, 0.05, int(hours * 3600)))
        corners, levels, at = [0.0], [rng.uniform(30, 90)], 0.0
        while at < hours * 3600:
            for goal, slope in ((rng.uniform(20, 40), -use), (rng.choice([50, 70, 95.0]), rate)):
                at += (goal - levels[-1]) / slope if (goal - levels[-1]) / slope > 0 else 0.0
                corners.append(at)
                levels.append(goal)
        level = np.interp(time, corners, levels)
        charges = np.searchsorted(corners, time, side="right") % 2 == 0
        part = np.where(charges, 0.0, time % 8)
        columns.append(
            pd.DataFrame({
                "time": time, "robot": robot, "x": np.nan, "y": np.nan, "node": np.where(part > 4, 1, 0),
                "driving": ~charges, "load": False, "action": np.where(charges, CHARGE, NOTHING),
                "charge": ROUNDINGS[rounding](level).astype(np.float32), "fault": False,
            })[rng.random(len(time)) > 0.01]
        )  # fmt: skip
    table = pd.concat(columns, ignore_index=True)
    log = FleetLog("day", table, tuple(f"R{n}" for n in range(robots)), ("B", "C"), 0.0, 1.0, Notes())
    return log, {"battery.charge_rate": rate, "battery.consumption.empty": use}


def held(model, seeds, rounding):
    """Of each figure whether its interval holds what is true, by how much its mean is off, and its half-width."""
    checks = {}
    for seed in seeds:
        log, truth = day(seed, rounding)
        for one in energy(lay_over(model, [log])):
            if one.key in truth and one.identified:
                true = truth[one.key]
                row = one.low <= true <= one.high, one.mean / true - 1, (one.high - one.low) / 2 / true
                checks.setdefault(one.key, []).append(row)
    return {key: np.array(rows, float) for key, rows in checks.items()}


@pytest.mark.parametrize("rounding", some(ROUNDINGS, 4))
def test_intervals_hold_what_is_true_however_levels_are_rounded(model, rounding):
    """95 % of 12 are 11.4 on average; fewer than 10 are seen once in 51 times."""
    for key, rows in held(model, range(12), rounding).items():
        assert len(rows) == 12
        assert rows[:, 0].sum() >= 10, key
        assert abs(rows[:, 1].mean()) < 0.0005, key
        assert rows[:, 2].max() < 0.005, key


@pytest.mark.long
@pytest.mark.parametrize("rounding", some(ROUNDINGS, 3))
def test_95_of_100_intervals_hold_what_is_true(model, rounding):
    for key, rows in held(model, range(100, 300), rounding).items():
        assert rows[:, 0].mean() >= 0.91, key  # 95 %, and two and a half standard errors
