"""Tours for random models: robots that carry several loads, batches, stations with one slot, and stops on the way.

A model keeps its floor, fleet, batteries and policies, and gets other work.
"""

import random

from tests.laws.random_models import lasting
from tests.policies.ours import completed

BATCHING = completed(
    "batching",
    [
        {"name": "fixed-size"},
        {"name": "fixed-size", "size": 2},
        {"name": "time-window", "window": 30},
        {"name": "time-window", "window": 200, "size": 3},
        {"name": "by-order"},
        {"name": "single"},
    ],
)


def with_tours(mapping, number):
    """Return a model whose robots carry up to four loads; most models get flows from and to anywhere, over stations."""
    draw = random.Random(f"tours {number}")
    fleet, most = mapping["fleet"], draw.randint(2, 4)
    fleet["robot"]["capacity"] = most
    for kind in fleet.get("kinds", {}).values():
        kind["capacity"] = draw.randint(1, most)
    mapping.setdefault("policies", {})["batching"] = draw.choice(BATCHING)
    mapping["battery"] = lasting(mapping["battery"], 2 * most + 4)
    if draw.random() < 0.6:
        _flows(mapping, draw)
    return mapping


def names_of(layout):
    """Return the nodes of a layout."""
    if "blocks" not in layout:
        return list(layout["nodes"])
    blocks = layout["blocks"]
    return [chr(ord("A") + i) for i in range((blocks["columns"] + 1) * (blocks["rows"] + 1))]


def _flows(mapping, draw):
    """Replace the work by flows between nodes, stations with few slots, and storage, which end if the work did."""
    layout, tasks = mapping["layout"], mapping["tasks"]
    nodes = names_of(layout)
    stations = {
        f"s{rank}": {"at": [node], "places": draw.choice((1, 1, 2)), "servers": 1}
        for rank, node in enumerate(draw.sample(nodes, min(len(nodes), draw.randint(1, 3))))
    }
    layout["stations"] = stations
    ends = ["storage", "storage", *stations, *stations, *draw.sample(nodes, min(2, len(nodes)))]
    forever = "random" not in tasks["goods"] if isinstance(tasks["goods"], dict) else False
    flows = {}
    for rank in range(draw.randint(1, 3)):
        source = draw.choice(ends)
        of = {name: station["at"][0] for name, station in stations.items()}
        here = {source, of.get(source, source)}  # a node may share its name with a station elsewhere
        others = [end for end in ends if end == "storage" or here.isdisjoint({end, of.get(end, end)})]
        target = draw.choice([*others, "storage"])
        via = [draw.choice([*stations, *nodes[:3]]) for _ in range(draw.choice((0, 0, 1, 2)))]
        arrivals = {"schedule": sorted([{"at": draw.uniform(0, 50), "tasks": draw.randint(1, 4)}] * 2, key=str)}
        if forever:
            arrivals = draw.choice(({"saturated": draw.randint(1, 6)}, {"poisson": 3600 / draw.uniform(20, 200)}))
        flow = {"from": source, "to": target, "via": via, "arrivals": arrivals, "stop_time": draw.choice((0, 2))}
        flows[f"f{rank}"] = flow
    stale = {"goods", "unload_at", "station_choice"}
    mapping["tasks"] = {key: value for key, value in tasks.items() if key not in stale}
    mapping["tasks"]["flows"] = flows
    mapping["tasks"]["station_choice"] = draw.choice(("nearest", "least-loaded", "random"))
