"""Robots at rest share their chargers: no robot runs flat in two days if chargers give a quarter more than is drawn.

A charger gives nothing while robots change places, which is allowed for by turns of a tenth of a battery. The quarter
covers shorter turns, and the energy that robots draw on the way. Half of the fleets rest in one bay, with more slots
than chargers.
"""

import math
import random

import pytest
from ruamel.yaml import YAML

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.world import World
from desim_warehouse.world.orders.demand import NoOrders

pytestmark = pytest.mark.usefixtures("brief_probes")

MORE = 1.25
TURN = 0.1
"""Share of the capacity that is charged before robots change places."""
POLICIES = {
    "threshold": {"policies.charging": "threshold"},
    "reach-aware": {"policies.charging": "reach-aware"},
    "opportunity": {"policies.charging": "opportunity"},
    "four-thresholds": {"policies.charging": "four-thresholds"},
    "swap": {"policies.charging": {"name": "swap", "time": 300}},
}


def fleet_at_rest(seed, policy, shared):
    """Return up to 30 robots with just enough chargers, whose batteries last for 4 to 12 h of rest."""
    chance = random.Random(f"{policy} {seed}")
    robots, capacity = chance.randint(4, 30), chance.choice([50, 100, 400])
    drawn = capacity / (chance.uniform(4, 12) * 3600)
    rate = drawn * chance.uniform(3, 12)
    size = (chance.randint(24, 60), chance.randint(20, 50))
    turn, change = TURN * capacity / rate, 0.0 if shared else float(sum(size))  # at a metre a second, turns included
    gives = rate * turn / (turn + change) / MORE
    chargers = math.ceil(robots * drawn / (gives + drawn))
    words = Draft(size=size, orders=10, robots=robots, chargers=robots)
    low, high = sorted((chance.uniform(0.3, 1), chance.uniform(0.3, 1)))
    content = YAML(typ="safe").load(draft(words))
    bays = {
        "layout.bays.charging.total_chargers": chargers,
        "layout.bays.parking.places": robots,
        "fleet.start": ["parking"],
    }
    if shared:
        node = content["layout"]["bays"]["charging"]["at"][:1]
        bays = {
            "layout.bays": {"charging": {"at": node, "places": robots + 1, "chargers": chargers}},
            "fleet.start": ["charging"],
        }
    return dw.load(
        content,
        {
            **bays,
            "fleet.start_energy": {"uniform": [low, high]},
            "battery": {"capacity": capacity, "threshold": 0.25 * capacity, "consumption": drawn, "charge_rate": rate},
            "battery.taper": {"start": 0.8, "end_rate": 0.1} if seed % 2 else None,
            **POLICIES[policy],
            "run": {"length": "48 h", "warm_up": 0},
        },
    )


FLEETS = [
    pytest.param(seed, shared, marks=[pytest.mark.long] if seed > 1 or shared != (seed == 1) else [])
    for seed in range(40)
    for shared in (False, True)
]
"""Every day one in bays of its own, which charges evenly, and one in a bay that it shares, which tapers."""


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize(("seed", "shared"), FLEETS)
def test_no_robot_at_rest_runs_flat_in_two_days(policy, seed, shared):
    model = fleet_at_rest(seed, policy, shared)
    world = World(model, seed, demand=NoOrders).run()
    assert min(robot.charge_left() for robot in world.robots) > 0
