"""Robots that gather speed and brake, and are slower or faster with a load, for random models."""

import random

from tests.laws.random_models import lasting
from tests.laws.wider import with_room_to_start

RATES = (0.05, 0.3, 1.0, 4.0, 1e3)
LARGER = 8
"""Factor for the life of batteries, so that they last for any task with all its stops, at rates of at least 1."""


def moving(mapping, seed):
    """Return the model with robots that take time to start and stop, some slower or faster with a load.

    In some models robots keep their braking distance.
    """
    draw = random.Random(f"moving {seed}")
    fleet, battery = mapping["fleet"], mapping["battery"]
    rates = [rate for rate in RATES if rate >= 1 or battery is None]
    kinds = {name: {**kind, **drawn(draw, rates, kind.get("speed"))} for name, kind in fleet.get("kinds", {}).items()}
    robot = {**fleet["robot"], **drawn(draw, rates, fleet["robot"]["speed"])}
    if not any("acceleration" in one or "deceleration" in one for one in (robot, *kinds.values())):
        robot["acceleration"] = draw.choice(rates)
    if draw.random() < 0.3 and ("acceleration" in robot or "deceleration" in robot):
        robot["keeps"] = "braking"
    moved = {**mapping, "battery": lasting(battery, LARGER), "fleet": {**fleet, "robot": robot, "kinds": kinds}}
    return with_room_to_start(moved)  # robots that keep their braking distance need more room


def drawn(draw, rates, speed):
    """Return some keys of a kind for its motion."""
    keys = {key: draw.choice(rates) for key in ("acceleration", "deceleration") if draw.random() < 0.6}
    if speed is not None and draw.random() < 0.5:
        keys["speed_loaded"] = speed * draw.choice((0.5, 0.8, 1.25))
    return keys
