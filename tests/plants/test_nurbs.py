"""Lengths of rational B-splines: circles and parabolas exactly, others as version 0.2.0 had them."""

import math

import pytest

from desim_warehouse.plants.lif import arc_length

CURVES = {
    "cubic": ((3, [0, 0, 0, 0, 1, 1, 1, 1], [(0, 0), (1, 2), (3, 2), (4, 0)], [1, 1, 1, 1]), 5.268365543018513),
    "rational cubic": (
        (3, [0, 0, 0, 0, 1, 1, 1, 1], [(0, 0), (1, 2), (3, 2), (4, 0)], [1, 0.3, 2.5, 1]),
        5.388780614690754,
    ),
    "knots inside": (
        (3, [0, 0, 0, 0, 1, 2.5, 4, 4, 4, 4], [(0, 0), (1, 2), (3, 2), (4, 0), (6, 1), (7, -3)], [1, 1, 1, 1, 1, 1]),
        10.500282713082838,
    ),
    "rational, knots inside": (
        (
            3,
            [0, 0, 0, 0, 1, 2.5, 4, 4, 4, 4],
            [(0, 0), (1, 2), (3, 2), (4, 0), (6, 1), (7, -3)],
            [1, 2, 0.5, 3, 1, 0.2],
        ),
        10.732592445421753,
    ),
    "knots at one place, a corner": (
        (2, [0, 0, 0, 1, 1, 3, 3, 3], [(0, 0), (1, 2), (3, 2), (4, 0), (6, 1)], [1, 2, 1, 0.5, 1]),
        7.356765909098545,
    ),
    "knots at one place, a jump": (
        (2, [0, 0, 0, 1, 1, 1, 3, 3, 3], [(0, 0), (1, 2), (3, 2), (4, 0), (6, 1), (6, 5)], [1, 2, 1, 0.5, 1, 1]),
        9.692133170731065,
    ),
    "ends free": (
        (2, [0, 0.4, 1, 2, 2.2, 3.5, 4, 5.5], [(0, 0), (1, 2), (3, 2), (4, 0), (6, 1)], [1, 1, 2, 1, 1]),
        6.097294725201493,
    ),
    "a cusp": ((3, [0, 0, 0, 0, 1, 1, 1, 1], [(0, 0), (1, 1), (0, 1), (1, 0)], [1, 1, 1, 1]), 1.8284271247461898),
    "there and back": (
        (3, [0, 0, 0, 0, 1, 1, 1, 1], [(0, 0), (10, 0), (-9, 0), (1, 0)], [1, 1, 1, 1]),
        11.027548261420254,
    ),
    "degree 5": (
        (
            5,
            [0, 0, 0, 0, 0, 0, 0.3, 1, 1, 1, 1, 1, 1],
            [(0, 0), (1, 2), (3, 2), (4, 0), (6, 1), (7, -3), (2, -2)],
            [1, 2, 0.5, 3, 1, 0.2, 1],
        ),
        9.855766379508024,
    ),
    "thousandths": (
        (3, [0, 0, 0, 0, 1, 1, 1, 1], [(0, 0), (0.001, 0.002), (0.003, 0.002), (0.004, 0)], [1, 0.3, 2.5, 1]),
        0.005388780614690754,
    ),
}
"""Degree, knots, control points and weights, and the length by de Boor's algorithm in version 0.2.0."""


@pytest.mark.parametrize(("curve", "length"), CURVES.values(), ids=CURVES)
def test_a_curve_is_as_long_as_version_0_2_0_found_it(curve, length):
    assert arc_length(*curve) == pytest.approx(length, rel=1e-9)


def test_a_quarter_of_a_circle_is_exact():
    points, weights = [(1, 0), (1, 1), (0, 1)], [1, math.sqrt(0.5), 1]
    assert arc_length(2, [0, 0, 0, 1, 1, 1], points, weights) == pytest.approx(math.pi / 2, rel=1e-12)


def test_a_parabola_is_exact():
    """y = x^2 from 0 to 1."""
    exact = math.sqrt(5) / 2 + math.asinh(2) / 4
    assert arc_length(2, [0, 0, 0, 1, 1, 1], [(0, 0), (0.5, 0), (1, 1)], [1, 1, 1]) == pytest.approx(exact, rel=1e-12)


def test_a_degree_of_one_is_a_line_through_the_points():
    assert arc_length(1, [0, 0, 1, 2, 2], [(0, 0), (3, 4), (3, 6)], [1, 7, 1]) == 7


@pytest.mark.parametrize(
    ("changed", "fault"),
    [
        ({"degree": 31}, "of degree 31"),
        ({"knots": [0, 0, 0, 1, 1]}, "3 control points and 5 knots for degree 2"),
        ({"knots": [0, 0, 1, 0, 1, 1]}, "knots that fall"),
        ({"knots": [0, 0, 1, 1, 2, 2]}, "all the same"),
        ({"weights": [1, 0, 1]}, "weights that are not above 0"),
    ],
)
def test_what_is_no_curve_is_refused(changed, fault):
    curve = {"degree": 2, "knots": [0, 0, 0, 1, 1, 1], "points": [(0, 0), (1, 1), (2, 0)], "weights": [1, 1, 1]}
    with pytest.raises(ValueError, match=fault):
        arc_length(**(curve | changed))
