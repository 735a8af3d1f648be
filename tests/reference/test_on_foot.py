"""Pick-assist in wide aisles beside a program without lanes: with pickers scarce, and with pickers to spare."""

from statistics import fmean

import pytest

import desim_warehouse as dw
from tests.reference.on_foot import Hall

HALL = {
    "layout": {
        "blocks": {
            "columns": 8,
            "rows": 2,
            "block_width": 2,
            "block_depth": 10,
            "goods_size": 1,
            "aisle_width": 2.4,
        },
        "aisles": "wide",
        "bays": {"west": {"along": "west", "places": 40}},
        "stations": {"packing": {"at": ["r2c3", "r2c5"], "places": 20, "servers": 2}},
    },
    "fleet": {"size": 6, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1.5, "capacity": 6}},
    "tasks": {
        "load_time": 12,
        "unload_time": 3,
        "flows": {"picks": {"from": "storage", "to": "packing", "arrivals": {"saturated": 60}, "lines": [1, 4]}},
    },
    "pickers": {"count": 3, "speed": 1},
    "policies": {"allocation": "nearest", "routing": "fastest", "batching": "by-order"},
    "run": {"length": 7200, "warm_up": 900},
    "log": "tasks",
}
SETTINGS = [(robots, pickers) for robots in (6, 12, 18, 24) for pickers in (3, 6, 9)]


@pytest.mark.long
@pytest.mark.parametrize(("robots", "pickers"), SETTINGS)
def test_lines_an_hour_are_those_of_a_program_without_lanes(robots, pickers):
    """Within 3 %, in all settings of docs/how-to/people-who-pick.md."""
    model = dw.load(HALL, {"fleet.size": robots, "pickers.count": pickers})
    here = fmean(dw.simulate(model, seed).kpis["throughput_per_hour"] for seed in range(3))
    apart = 3600 * fmean(Hall(model, seed).run(900, 7200) for seed in range(6))
    assert here == pytest.approx(apart, rel=0.03)


def test_a_single_robot_and_a_picker_take_the_same_time_for_a_line():
    """Nobody is in anybody's way here, whichever program."""
    model = dw.load(HALL, {"fleet.size": 1, "pickers.count": 1, "run.length": 40_000})
    here = fmean(dw.simulate(model, seed).kpis["throughput_per_hour"] for seed in range(3))
    apart = 3600 * fmean(Hall(model, seed).run(900, 120_000) for seed in range(2))
    assert here == pytest.approx(apart, rel=0.05)
