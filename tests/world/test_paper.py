"""MultiBots, the paper's warehouse: its worked route, its goods, its 30 cells, and the stepped reference beside it."""

import random
import statistics
from pathlib import Path

import pytest

import desim_warehouse as dw
from tests.reference import stepped
from tests.reference.paper import CELLS, GROUPS, changes, settings


@pytest.fixture(scope="module")
def multibots():
    return dw.load(Path(__file__).parents[2] / "models" / "multibots.yaml")


def run(multibots, robots, goods, **changes):
    return dw.simulate(multibots.replace({"fleet.size": robots, "tasks.goods": list(goods), **changes}))


def test_the_worked_route_of_the_paper(multibots):
    """From A to good 40 on O>I: A B C D J P O, then with it I J P O N M; home by G. All by hand, in steps."""
    outcome = run(multibots, 1, [40])
    driven = [row[5] for row in outcome.record.rows if row[1] == "enter"]
    assert "".join(edge[0] for edge in driven) + driven[-1][1] == "ABCDJPO" + "IJPON" + "MGA"
    row, column = 150 / 4 + 1.5, 250 / 4 + 1.5
    # out of the zone; A B C D; D J P; P O; 200 px up O>I; loading
    loaded = 11 + 3 * row + 2 * column + row + 200 / 4 + 10
    # the other 50 px to I; I J; J P; P O N M
    at_m = loaded + 50 / 4 + 1.5 + row + column + 3 * row
    # unloading, clearing, M G A
    home = at_m + 20 + 3 + 2 * column
    assert outcome.kpis["T"] == pytest.approx(home)
    assert (outcome.S, outcome.C, outcome.kpis["moves"]) == (0, 0, 14)


@pytest.mark.parametrize(
    ("good", "edge", "offset", "centre"),
    [
        # block column 0 is between the aisles at x = 25 and x = 175: left goods at x = 75, right ones at 125
        (0, "GA", 200, (75, 75)),  # 50 below A; the aisle runs up from G: 250 - 50
        (1, "BH", 50, (125, 75)),  # 50 below B, the aisle runs down
        (6, "GA", 50, (75, 225)),  # 200 below A
        (7, "BH", 200, (125, 225)),
        (8, "MG", 200, (75, 325)),  # the block below: 50 below G
        (9, "HN", 50, (125, 325)),
        (16, "BH", 50, (225, 75)),  # block column 1, left: from the aisle of B again
        (17, "IC", 200, (275, 75)),  # right: the aisle of C runs up
        (40, "OI", 200, (375, 325)),  # block column 2, lower, left
        (37, "DJ", 150, (425, 175)),  # block column 2, upper, right, third row
        (79, "LR", 200, (725, 475)),  # the last: block column 4, lower, right, fourth row
    ],
)
def test_goods_are_numbered_down_block_columns_and_along_their_rows(multibots, good, edge, offset, centre):
    place = dw.simulate(multibots.replace({"fleet.size": 1, "tasks.goods": [0]})).layout.storage[good]
    assert (place.number, "".join(place.edge), place.offset, (place.x, place.y)) == (good, edge, offset, centre)


@pytest.mark.slow
def test_the_stepped_reference_picks_all_goods_at_the_same_places(multibots):
    layout = run(multibots, 1, [0]).layout
    assert len(layout.storage) == 80
    for place in layout.storage:
        source, target, point = stepped.place_of(place.number)
        assert (place.edge, layout.position(place.edge, place.offset)) == ((source, target), pytest.approx(point))


def test_the_30_cells_against_the_authors_program(multibots):
    """T within 1 % in at least 29 cells and the median within 0.2 %, C equal, S within 2 a cell.

    For S as a whole there is no bound from theory: docs/dev/validation.md says why. Golden: 70 here, 65 there.
    """
    errors, stops = [], 0
    for cell in CELLS:
        outcome = run(multibots, int(cell["robots"]), GROUPS[int(cell["group"])])
        errors.append(abs(outcome.T / cell["T_steps_program"] - 1))
        stops += outcome.S
        assert cell["C_program"] == outcome.C, cell
        assert abs(outcome.S - cell["S_program"]) <= 2, cell
        assert outcome.kpis["tasks"] == 10
    assert len(errors) == 30
    assert sum(error <= 0.01 for error in errors) >= 29
    assert statistics.median(errors) <= 0.002
    assert (stops, sum(cell["S_program"] for cell in CELLS)) == (70, 65)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "count", "margin", "more_stops"),
    [
        (2, 10, 8.0, 0.15),
        *(
            pytest.param(*each, marks=pytest.mark.long)
            for each in [(1, 60, 8.0, 0.08), (2, 60, 8.0, 0.08), (3, 60, 0.0, 0.25)]
        ),
    ],
)
def test_random_experiments_against_the_stepped_reference(multibots, seed, count, margin, more_stops):
    """Goods, robots, unloading letter and battery at random; margin 0 is the distance in the paper's text.

    Two robots that just miss each other are too close for a short way only. The reference's steps of 4 px jump over
    that more often when D is 25 px than when it is 33, so with margin 0 it counts fewer stops.
    """
    close = same = stops = expected_stops = 0
    for setting, expected in settings(random.Random(seed), count, margin=margin):
        outcome = dw.simulate(multibots.replace(changes(setting)))
        close += abs(outcome.T / expected.T - 1) <= 0.01
        same += expected.C == outcome.C
        stops += outcome.S
        expected_stops += expected.S
        assert outcome.kpis["tasks"] == expected.delivered
    assert close >= 0.9 * count
    assert same >= 0.98 * count
    assert -0.08 <= stops / expected_stops - 1 <= more_stops


def test_one_robot_alone_never_waits_and_agrees_to_the_rounding_of_steps(multibots):
    """Alone the two models differ only by rounding a drive up to whole steps: at most one step a drive."""
    for group, goods in GROUPS.items():
        outcome, expected = run(multibots, 1, goods), stepped.simulate(stepped.Setting(1, goods))
        assert (outcome.S, outcome.C) == (0, expected.C), group
        assert abs(outcome.T - expected.T) <= outcome.kpis["moves"] + 2 * 10
