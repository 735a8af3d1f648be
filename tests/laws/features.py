"""Random warehouses by number, with any features; a number and its features always give an identical model.

`warehouse(17)` is one of `random_models`; `warehouse(17, "tours breakdowns")` has tours and robots that break down;
`warehouse(17, "zones", "tree")` is made on a network with two-way lanes. `python -m tests.laws.features 17 tours grid`
looks for faults in one model alone, with `200-300` in place of 17 in each of a hundred.
"""

import random
import sys

from tests.laws import random_models, two_way
from tests.laws.aisles import with_wide_aisles
from tests.laws.breakdowns import share_working, with_breakdowns
from tests.laws.closures import with_closures
from tests.laws.hours import with_hours
from tests.laws.kinds import with_kinds
from tests.laws.lifts import with_lifts
from tests.laws.moving import moving
from tests.laws.pickers import with_pickers
from tests.laws.pods import with_pods
from tests.laws.tours import with_tours
from tests.laws.wider import wider
from tests.laws.zones import with_zones
from tests.policies.ours import completed, every

ONE_WAY = "one-way"
EVERYTHING = "kinds tours closures hours moving breakdowns"
MOST_TURNS = 6
"""Robots that take turns at a charger, each as long as the drive there, while a fifth of a small battery lasts."""
POLICIES = {
    "allocation": completed(
        "allocation",
        [
            "in-order",
            "nearest",
            {"name": "nearest", "candidates": 2},
            "nearest-aging",
            "earliest-due",
            "hungarian",
            "regret",
            {"name": "regret", "objective": "total", "depth": 2, "commit": True},
            "auction",
            {"name": "auction", "objective": "makespan", "robots": 1, "candidates": 3},
            {"name": "auction", "commit": True},
            "cost-aware",
        ],
    ),
    "routing": every("routing"),
    "charging": completed(
        "charging",
        [
            {"name": "reach-aware", "margin": 0.25},
            {"name": "opportunity", "margin": 0.25},
            {"name": "four-thresholds", "margin": 0.25},
            {"name": "swap", "time": 20, "margin": 0.25},
            {"name": "reach-aware", "margin": 0.25, "charger": "least-loaded"},
            {"name": "opportunity", "margin": 0.25, "charger": "own"},
            "threshold",
        ],
    ),
    "parking": every("parking"),
}


def with_policies(mapping, key):
    """Return the model with a random combination of our policies."""
    draw = random.Random(f"policies {key}")
    chosen = {kind: draw.choice(some) for kind, some in POLICIES.items()}
    return {**mapping, "policies": {**mapping["policies"], **chosen}}


def capped(mapping, key):
    """Return the model with at most half of the robots under way."""
    most = random.Random(f"capped {key}").randint(1, max(mapping["fleet"]["size"] // 2, 1))
    return {**mapping, "traffic": {**mapping["traffic"], "most_out": most}}


def dwelling(mapping, key):
    """Return the model in which robots rest where they put their load down, with work rare enough for that."""
    draw = random.Random(f"dwelling {key}")
    tasks, policies = mapping["tasks"], {**mapping["policies"], "parking": "where-it-is"}
    goods = tasks.get("goods")
    # With a threshold near a full battery, no robot may leave for a distant good while others occupy the way.
    tight = mapping.get("battery") and policies["charging"] == "threshold"
    if isinstance(goods, dict) and "random" in goods and "storage" in mapping["layout"] and not tight:
        places, pause = len(mapping["layout"]["storage"]), draw.choice((5, 20, 60))
        goods = [
            {"good": draw.randrange(places), "release": draw.uniform(0, pause * goods["random"])}
            for _ in range(goods["random"])
        ]
        tasks = {**tasks, "goods": goods}
    return {**mapping, "tasks": tasks, "policies": policies}


def restless(mapping, key):
    """Return the model with random detours, robots of several sizes, stations of their own, and early recalls."""
    draw = random.Random(f"restless {key}")
    fleet, battery, policies = mapping["fleet"], mapping["battery"], mapping["policies"]
    detours = draw.randint(1, 4)
    wanderer = {"name": "tests.laws.wanderer:Wanderer", "seed": draw.randint(0, 9), "detours": detours}
    policies = {**policies, "routing": draw.choice((wanderer, wanderer, "congestion-aware"))}
    kinds = {
        name: {**kind, "radius": fleet["robot"]["radius"] * draw.choice((1, 0.6))}
        for name, kind in fleet.get("kinds", {}).items()
    }
    if battery:
        battery = {**battery, "threshold": battery["capacity"] * draw.choice((0.5, 0.7, 0.8))}
        draws = battery["consumption"]
        most = max(draws.values()) if isinstance(draws, dict) else draws
        battery["charge_rate"] = max(battery["charge_rate"], 2 * fleet["size"] * most)  # else work may never end
        bays = mapping["layout"]["bays"]
        turns = fleet["size"] / random_models.chargers_of(bays, fleet["size"])
        working = min((share_working(**bay["outages"]) for bay in bays.values() if "outages" in bay), default=1)
        battery = random_models.lasting(battery, max(turns / MOST_TURNS, 1) / working)  # nor if turns outlast a charge
        policies["charging"] = draw.choice(("threshold", {"name": "reach-aware", "margin": draw.uniform(0.1, 0.6)}))
    tasks, unload = mapping["tasks"], mapping["tasks"]["unload_at"]
    if len(unload) > 1 and draw.random() < 0.5:
        each = [unload[rank % len(unload)] for rank in range(fleet["size"])]
        tasks = {**tasks, "unload_at": each, "station_choice": "each"}
    fleet = {**fleet, "kinds": kinds}
    return {**mapping, "fleet": fleet, "tasks": tasks, "battery": battery, "policies": policies}


FEATURES = {
    "aisles": with_wide_aisles,
    "capped": capped,
    "wider": wider,
    "moving": moving,
    "closures": with_closures,
    "dwelling": dwelling,
    "breakdowns": with_breakdowns,
    "hours": with_hours,
    "kinds": with_kinds,
    "lifts": with_lifts,
    "pickers": with_pickers,
    "pods": with_pods,
    "policies": with_policies,
    "restless": restless,
    "tours": with_tours,
    "zones": with_zones,
}


def warehouse(number, features="", ground=ONE_WAY):
    """Return the model of a number as a mapping; features are added in the order in which they are named."""
    made = random_models.model(number) if ground == ONE_WAY else two_way.model(ground, number)
    for feature in features.split():
        made = FEATURES[feature](made, number if ground == ONE_WAY else f"{ground} {number}")
    return made


if __name__ == "__main__":
    from tests.laws.faults import faults_of

    arguments = sys.argv[1:]
    numbers, features, ground = (*arguments, *("", ONE_WAY)[len(arguments) - 1 :])
    first, _, last = numbers.partition("-")
    for number in range(int(first), int(last or int(first) + 1)):
        for fault in faults_of(warehouse(number, features, ground), number):
            print(number, fault, flush=True)  # noqa: T201 - a tool
