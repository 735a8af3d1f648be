"""Kinds of robots with their own batteries, charging policies and chargers, for random models with batteries."""

import random


def with_kinds(mapping, seed):
    """Return the model in which kinds may have a larger battery, another unit of energy, policy or chargers."""
    battery, fleet = mapping["battery"], mapping["fleet"]
    if battery is None or not fleet.get("kinds"):
        return mapping
    draw = random.Random(f"kinds {seed}")
    kinds = {name: {**kind, **drawn(draw, battery)} for name, kind in fleet["kinds"].items()}
    layout = mapping["layout"]
    return {
        **mapping,
        "fleet": {**fleet, "kinds": kinds},
        "layout": {**layout, "bays": reserved(draw, layout["bays"], list(kinds))},
    }


def drawn(draw, battery):
    """Return some keys of a kind for its battery, which lasts at least as long as the others', and for charging."""
    keys = {}
    if draw.random() < 0.6:
        unit, more = draw.choice((0.5, 1, 3)), draw.choice((1, 1.5, 4))
        spent = battery["consumption"]
        scaled = {key: battery[key] * unit * more for key in ("capacity", "threshold")}
        per_state = {key: value * unit for key, value in spent.items()} if isinstance(spent, dict) else spent * unit
        rate = battery["charge_rate"] * unit * draw.choice((0.7, 1, 5))
        reserve = {"reserve": battery["reserve"] * unit} if "reserve" in battery else {}
        keys["battery"] = {**battery, **scaled, **reserve, "consumption": per_state, "charge_rate": rate}
    if draw.random() < 0.5:
        swap = {"name": "swap", "time": draw.choice((1, 20)), "level": draw.choice((0.3, 0.6))}
        keys["charging"] = draw.choice(("threshold", {"name": "reach-aware", "margin": 0.1}, swap))
    return keys


def reserved(draw, bays, kinds):
    """Return bays of which one, of several with chargers, may be reserved for some kinds."""
    charging = [name for name, bay in bays.items() if bay.get("chargers") != 0 and not bay.get("in_lane")]
    if len(charging) < 2 or draw.random() < 0.4:
        return bays
    name = draw.choice(charging[1:])
    return {**bays, name: {**bays[name], "kinds": draw.sample(kinds, draw.randint(1, len(kinds)))}}
