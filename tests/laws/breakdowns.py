"""Breakdowns of robots, failures of chargers, and delays at nodes, for random models."""

import random

WITH_CHANCE = "exponential"


def with_breakdowns(mapping, number):
    """Return the model with frequent breakdowns of robots, failures of chargers, and delays at nodes."""
    draw = random.Random(f"breakdowns {number}")
    fleet = {**mapping["fleet"], "robot": dict(mapping["fleet"]["robot"]), "kinds": {}}
    for name, kind in mapping["fleet"].get("kinds", {}).items():
        fleet["kinds"][name] = {**kind, **({"breakdowns": failures(draw)} if draw.random() < 0.3 else {})}
    if draw.random() < 0.8:
        fleet["robot"]["breakdowns"] = failures(draw)
    if draw.random() < 0.5:
        fleet["robot"]["delays"] = {"share": draw.choice((0.1, 0.5, 1.0)), "time": varying(draw, draw.choice((0.5, 5)))}
    layout = {**mapping["layout"], "bays": {name: dict(bay) for name, bay in mapping["layout"]["bays"].items()}}
    for bay in layout["bays"].values():
        if bay.get("chargers") != 0 and draw.random() < 0.6:
            bay["outages"] = {
                "every": varying(draw, draw.choice((20, 200))),
                "repair": varying(draw, draw.choice((5, 50))),
            }
    battery = mapping.get("battery")
    if battery:  # no estimate includes the energy drawn during repairs and delays
        battery = {**battery, "reserve": 1e12}
        if any("outages" in bay for bay in layout["bays"].values()):
            fleet["start_energy"] = 1  # deep in reserve, a fleet whose chargers fail would never recover
    return {**mapping, "fleet": fleet, "layout": layout, "battery": battery}


def share_working(every, repair):
    """Return the part of the time in which something that fails and is repaired works."""
    up, down = (mean[WITH_CHANCE] if isinstance(mean, dict) else mean for mean in (every, repair))
    return up / (up + down)


def failures(draw):
    """Return a section `breakdowns`; in half of them robots are cleared off the lanes, some of them at once."""
    section = {"every": varying(draw, draw.choice((15, 60, 300))), "repair": varying(draw, draw.choice((0, 3, 30)))}
    if draw.random() < 0.5:
        section["clear"] = varying(draw, draw.choice((0, 2, 10)))
    return section


def varying(draw, mean):
    return {WITH_CHANCE: mean} if mean and draw.random() < 0.7 else mean
