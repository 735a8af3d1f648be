"""Random closures on a ring with a bypass: routes that know closures are never slower than routes that wait."""

import random

import pytest

import desim_warehouse as dw
from tests.auditor import audit

DAILY, LONG = 10, 2010
WAITS = "tests.laws.stubborn:Stubborn"


def ring(number, *, robots=1):
    """Return a ring with the street S>A>B>T, its bypass S>U>V>T, and the way back T>E>S; A>B or another edge closes."""
    draw = random.Random(f"ring {number}")
    wide, deep = draw.uniform(20, 60), draw.uniform(5, 40)
    nodes = {"S": [0, 0], "A": [wide / 3, 0], "B": [2 * wide / 3, 0], "T": [wide, 0]}
    nodes |= {"U": [0, deep], "V": [wide, deep], "E": [wide / 2, -20]}
    edges = [list(pair) for pair in ("SA", "AB", "BT", "SU", "UV", "VT", "TE", "ES")]
    lasts = draw.uniform(5, 150)
    calendar = draw.choice(
        (
            {"between": [[begin, begin + lasts] for begin in sorted(draw.uniform(0, 600) for _ in range(3))]},
            {"every": lasts * draw.uniform(1.1, 4), "lasts": lasts, "first": draw.uniform(0, 100)},
        )
    )
    shut = [["A", "B"], *([draw.choice(edges[3:])] if draw.random() < 0.3 else [])]
    return {
        "layout": {
            "nodes": nodes,
            "edges": edges,
            "storage": [{"edge": ["T", "E"], "offset": 5}, {"edge": ["V", "T"], "offset": deep / 2}],
            "bays": {"home": {"at": ["S"], "places": robots}},
        },
        "fleet": {"size": robots, "robot": {"radius": 0.5, "speed": 1}},
        "tasks": {
            "goods": [draw.choice((0, 0, 1)) for _ in range(6)],
            "unload_at": ["S"],
            "load_time": draw.choice((0, 7)),
            "unload_time": 3,
        },
        "calendars": {"c": calendar},
        "traffic": {"closures": {"works": {"members": shut, "hours": "c", "tasks": "go"}}},
        "policies": {"routing": "shortest"},
    }


@pytest.mark.parametrize(
    "numbers",
    [range(DAILY), *(pytest.param(range(n, n + 200), marks=pytest.mark.long) for n in range(DAILY, LONG, 200))],
)
def test_a_single_robot_is_never_later_for_taking_a_bypass(numbers):
    sooner = 0
    for number in numbers:
        model = dw.load(ring(number))
        waits = dw.simulate(model.replace({"policies.routing": WAITS}))
        for routing in ("highways", "shortest", "fastest"):
            knows = dw.simulate(model.replace({"policies.routing": routing}))
            assert knows.T <= waits.T + 1e-6, (number, routing)
            assert audit(knows) == [], number
        sooner += knows.T < waits.T - 1
    assert sooner > len(numbers) / 5  # else the law is nearly trivial


@pytest.mark.parametrize("number", range(6))
def test_without_closures_routes_are_equal_to_the_last_digit(number):
    """The model has a calendar that closes nothing."""
    model = dw.load({**ring(number, robots=4), "traffic": {}})
    knows, waits = dw.simulate(model), dw.simulate(model.replace({"policies.routing": WAITS}))
    assert knows.record.rows == waits.record.rows


@pytest.mark.parametrize("number", range(8))
def test_several_robots_end_their_work_and_break_no_rule(number):
    for routing in ("highways", {"name": "shortest", "spread": 2}, "congestion-aware"):
        run = dw.simulate(dw.load(ring(number, robots=4)).replace({"policies.routing": routing}))
        assert run.kpis["tasks"] == 6
        assert audit(run) == [], (number, routing)
