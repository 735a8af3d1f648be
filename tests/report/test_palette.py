"""Colours of the floor of a replay: whatever says something alone is seen on everything that it lies on."""

import itertools

import pytest

from desim_warehouse.look.palette import GROUND, HEAT, PALETTES
from desim_warehouse.states import STATES

GROUNDS = ("floor", "cell", "none", "bay", "out")
"""What robots and their marks lie on: the floor, cells of a grid and those with storage, bays, stations."""
MARKS = {state.role for state in STATES.values()} | {"wait", "ring", "good", "person", "shut"}
LEGIBLE, SEEN = 4.5, 3.0
"""The least contrast of text, and of marks (WCAG 2.2, success criteria 1.4.3 and 1.4.11)."""
FLOORS = list(itertools.product(PALETTES, GROUND))


def light_of(colour):
    """Relative luminance, as WCAG defines it."""
    parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one, other):
    darker, lighter = sorted((light_of(one), light_of(other)))
    return (lighter + 0.05) / (darker + 0.05)


def test_contrast_is_that_of_the_standard():
    assert contrast("#000000", "#ffffff") == pytest.approx(21)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.005)


@pytest.mark.parametrize(("palette", "theme"), FLOORS)
def test_robots_rings_goods_and_closures_are_seen_on_everything_they_lie_on(palette, theme):
    colours = GROUND[theme] | PALETTES[palette][theme]
    faint = {
        (mark, ground): round(ratio, 2)
        for mark, ground in itertools.product(sorted(MARKS), GROUNDS)
        if (ratio := contrast(colours[mark], colours[ground])) < SEEN
    }
    assert not faint


@pytest.mark.parametrize(("palette", "theme"), FLOORS)
def test_the_dot_of_a_waiting_robot_is_seen_on_it(palette, theme):
    """Its rim on every robot that moves, itself on its rim."""
    colours = GROUND[theme] | PALETTES[palette][theme]
    assert min(contrast(colours["label"], colours[mark]) for mark in ("empty", "loaded", "wait")) >= SEEN


@pytest.mark.parametrize("theme", GROUND)
def test_words_are_legible_and_waiting_is_seen_on_the_floor(theme):
    colours = GROUND[theme] | PALETTES["safe"][theme]
    words = itertools.product(("ink", "soft"), (*GROUNDS, "back"))
    assert min(contrast(colours[one], colours[ground]) for one, ground in words) >= LEGIBLE
    assert min(contrast(step, colours["floor"]) for step in HEAT[theme]) >= SEEN
