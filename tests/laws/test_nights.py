"""Robots at rest share their chargers: nobody runs flat in two days where chargers give a quarter more than is drawn.

The quarter is for the time in which robots change places at a charger, and for what they draw on the way.
"""

import math
import random

import pytest
import yaml

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.world import World

MORE = 1.25
POLICIES = {
    "threshold": {"policies.charging": "threshold"},
    "reach-aware": {"policies.charging": "reach-aware"},
    "opportunity": {"policies.charging": "opportunity"},
    "four-thresholds": {"policies.charging": "four-thresholds"},
    "swap": {"policies.charging": {"name": "swap", "time": 300}},
}


def fleet_at_rest(seed, policy):
    """Up to 30 robots with just enough chargers, at one to four nodes; their batteries last 4 to 12 h of rest."""
    chance = random.Random(f"{policy} {seed}")
    robots, capacity = chance.randint(4, 30), chance.choice([50, 100, 400])
    drawn = capacity / (chance.uniform(4, 12) * 3600)
    rate = drawn * chance.uniform(3, 12)
    chargers = math.ceil(robots * drawn / (rate / MORE + drawn))
    size = (chance.randint(24, 60), chance.randint(20, 50))
    words = Draft(size=size, orders=10, robots=robots, chargers=robots)
    low, high = sorted((chance.uniform(0.3, 1), chance.uniform(0.3, 1)))
    return dw.load(
        yaml.safe_load(draft(words)),
        {
            "layout.bays.charging.total_chargers": chargers,
            "layout.bays.parking.places": robots,
            "fleet.start": ["parking"],
            "fleet.start_energy": {"uniform": [low, high]},
            "battery": {"capacity": capacity, "threshold": 0.25 * capacity, "consumption": drawn, "charge_rate": rate},
            "battery.taper": {"start": 0.8, "end_rate": 0.1} if seed % 2 else None,
            **POLICIES[policy],
            "run": {"length": "48 h", "warm_up": 0},
        },
    )


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize("seed", [*range(2), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(2, 40))])
def test_nobody_at_rest_runs_flat_in_two_days(policy, seed):
    model = fleet_at_rest(seed, policy)
    world = World(model, seed, orders=False).run()
    assert min(robot.charge_left() for robot in world.robots) > 0
