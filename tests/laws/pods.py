"""Pods for random models, which keep their floor, fleet and policies, and get lines to pick."""

import random

import networkx as nx

from tests.laws.random_models import lasting
from tests.laws.tours import names_of
from tests.policies.ours import every

OF_PODS = {kind: every(kind) for kind in ("pod", "storage", "order_station", "put")}


def with_pods(mapping, number):
    """Return a model whose robots carry pods to one to three stations; in half of them bundles are put onto pods."""
    draw = random.Random(f"pods {number}")
    layout, tasks, policies = mapping["layout"], mapping["tasks"], mapping.setdefault("policies", {})
    places = _places(layout)
    policies |= {kind: draw.choice(some) for kind, some in OF_PODS.items()} | {"batching": "single"}
    count, per_pod = draw.randint(1, places), draw.randint(1, 4)
    pods = {
        "count": count,
        "per_pod": per_pod,
        "items": draw.randint(per_pod, count * per_pod),
        "orders": draw.choice((0, 1, 3, 12)),
        "change_time": draw.choice((0, 5)),
    }
    nodes = _open_nodes(layout)
    stations = {
        f"picking{rank}": {"at": [node], "places": draw.choice((1, 2, 4)), "servers": 1}
        for rank, node in enumerate(draw.sample(nodes, min(len(nodes), draw.randint(1, 3))))
    }
    for station in stations.values() if draw.random() < 0.5 else ():
        if hours := draw.choice([None, *(name for name in mapping.get("calendars", {}) if name.startswith("h"))]):
            station |= {"hours": hours, "at_close": draw.choice(("finish", "pause"))}
    layout["stations"] = stations
    goods = tasks["goods"]
    forever = isinstance(goods, dict) and "random" not in goods
    arrivals = {"schedule": sorted([{"at": draw.uniform(0, 50), "tasks": draw.randint(1, 6)}] * 2, key=str)}
    if forever:
        arrivals = draw.choice(({"saturated": draw.randint(1, 30)}, {"poisson": 3600 / draw.uniform(5, 100)}))
    time = draw.choice((2, 2, {"exponential": 3}))
    lines = draw.choice((1, 1, 2, [1, 4]))
    flows = {"picks": {"from": "storage", "to": [*stations], "arrivals": arrivals, "stop_time": time, "lines": lines}}
    if draw.random() < 0.5:
        some = {"schedule": [{"at": draw.uniform(0, 50), "tasks": draw.randint(1, 6)}]}
        flows["bundles"] = {"from": draw.choice([*stations]), "to": "storage", "arrivals": some, "stop_time": 3}
        pods |= {"stock": 100, "bundle": draw.randint(1, 5)}
        if forever:
            flows["bundles"]["arrivals"] = {"poisson": 3600 / draw.uniform(20, 100)}
    if draw.random() < 0.3:
        pods["popularity"] = {"weights": [draw.choice((1, 1, 5)) for _ in range(pods["items"])]}
    if draw.random() < 0.3:
        pods["holds"] = _held(draw, pods, places)
    mapping["pods"] = pods
    mapping["battery"] = lasting(mapping["battery"], 20)
    stale = {"goods", "unload_at", "station_choice", "flows"}
    mapping["tasks"] = {**{key: it for key, it in tasks.items() if key not in stale}, "flows": flows}
    return mapping


def _open_nodes(layout):
    """Return nodes for stations, without those that a robot parked in a lane occupies or cuts off."""
    names = names_of(layout)
    lanes = {node for bay in layout["bays"].values() if bay.get("in_lane") for node in bay["at"]}
    if not lanes:
        return names
    ends = [edge[:2] if isinstance(edge, list) else (edge["from"], edge["to"]) for edge in layout["edges"]]
    rest = nx.DiGraph(pair for pair in ends if not lanes & {*pair})
    main = max(nx.strongly_connected_components(rest), key=len)
    return [node for node in names if node in main]


def _held(draw, pods, places):
    """Return the content of pods as from a file: some items on each pod, and every item on at least one."""
    count, items = pods["count"], pods["items"]
    rows = [(item % count, item) for item in range(items)]
    rows += [(draw.randrange(count), draw.randrange(items)) for _ in range(count)]
    rows.append((count - 1, 0))
    held = {"names": [f"item {n}" for n in range(items)], "pod": [p for p, _ in rows], "item": [i for _, i in rows]}
    if pods.pop("stock", None):
        held["units"] = [100] * len(rows)
    return held | ({"places": draw.sample(range(places), count)} if draw.random() < 0.5 else {})


def _places(layout):
    """Return the number of storage places of a layout."""
    if "blocks" not in layout:
        return len(layout["storage"])
    blocks = layout["blocks"]
    return min(blocks["block_width"], 2) * blocks["columns"] * blocks["rows"] * blocks["block_depth"]
