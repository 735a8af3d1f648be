"""Random warehouses by number, whose batteries begin settled: drafts with other batteries, bays and policies."""

import random

from ruamel.yaml import YAML

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft

POLICIES = ("threshold", "reach-aware", "opportunity", "four-thresholds", {"name": "swap", "time": 60})
HOURS = 4


def model(number, policy):
    """Return a warehouse of two to seven robots that keep up, with batteries for two to six hours of work.

    A fleet that hardly kept up would have queues for hours, and battery levels would follow the queue.
    """
    draw = random.Random(number)
    orders = draw.choice((30, 50, 70))
    robots = max(2, round(orders / draw.uniform(10, 20)))
    hours, charges = draw.uniform(2, 6), draw.uniform(3, 6)
    drive = 100 / (hours * 3600)
    standing = draw.choice((1.0, 0.5, 0.1)) * drive
    chargers = max(1, round(robots / (1 + charges) + draw.uniform(0.3, 1)))
    size = draw.choice(((16, 14), (20, 20), (30, 20)))
    content = YAML(typ="safe").load(draft(Draft(size=size, orders=orders, robots=robots, chargers=chargers)))
    states = {"standing": standing, "empty": drive, "loaded": drive * draw.uniform(1, 1.5), "handling": drive}
    battery = {"capacity": 100, "threshold": 30, "consumption": states, "charge_rate": charges * drive}
    if draw.random() < 0.25:
        battery["taper"] = {"start": 0.8, "end_rate": 0.3}
    changes = {"battery": battery, "policies.charging": policy, "run": {"length": f"{HOURS} h"}, "log": "tasks"}
    if draw.random() < 0.4:  # robots rest where they charge, fewer chargers than slots
        node = content["layout"]["bays"]["charging"]["at"][:1]
        changes["layout.bays"] = {"charging": {"at": node, "places": robots + 1, "chargers": chargers}}
        changes["fleet.start"] = ["charging"]
    return dw.load(content, changes)
