"""Goods to person beside RAWSim-O: lines an hour of one floor, by the same rules, with 1 to 20 robots.

What RAWSim-O did was read off its own statistics, three runs each. docs/dev/validation.md describes the floor;
2.5 s for a turn round are 0.625 s for a quarter here.
"""

from statistics import fmean

import desim_warehouse as dw
from tests.world.test_pods import HALL

RULES = {
    "most lines, own place": ("most-lines", "own", 0.05),
    "nearest pod, nearest place": ("nearest", "nearest", 0.07),
}
"""The pod that comes, where it goes back, and how near lines an hour must come."""
LINES = {
    1: (169.8, 80.8),
    2: (333.3, 168.8),
    4: (565.3, 365.0),
    6: (643.7, 489.5),
    10: (630.5, 590.4),
    14: (619.2, 610.7),
    20: (613.5, 610.5),
}
"""What RAWSim-O does in an hour, by robots, for each of the rules."""
SEEDS = range(3)


def model():
    """The same floor, with the stations at the end of the hall."""
    floor = dw.load(HALL).floor
    nodes = {name: [data["x"], data["y"]] for name, data in floor.graph.nodes(data=True)}
    edges = [list(edge) for edge in floor.graph.edges]
    south = max(y for _, y in nodes.values())
    for name, (enters, leaves) in {"P1": ("r5c1", "r5c2"), "P2": ("r5c3", "r5c4")}.items():
        nodes[name] = [(nodes[enters][0] + nodes[leaves][0]) / 2, south + 10]
        edges += [[enters, name], [name, leaves]]
    layout = {
        "nodes": nodes,
        "edges": edges,
        "storage": [{"edge": list(place.edge), "offset": place.offset} for place in floor.storage],
        "bays": {"parking": {"at": [f"r0c{n}" for n in range(6)], "chargers": 0, "places": 20}},
        "stations": {"picking": {"at": ["P1", "P2"], "places": 9, "servers": 1}},
    }
    run = {"length": "2.5 h", "warm_up": "0.5 h"}
    robots = {"fleet.robot.acceleration": 1, "traffic.turn_time": 0.625, "pods.change_time": 5.3}
    return dw.load({**HALL, "layout": layout, "run": run}, {**robots, "policies.allocation": "nearest"})


def lines_an_hour(rule, robots):
    """The mean of a few runs."""
    pod, storage, _ = RULES[rule]
    changed = model().replace({"fleet.size": robots, "policies.pod": pod, "policies.storage": storage})
    return fmean(dw.simulate(changed, seed).kpis["throughput_per_hour"] for seed in SEEDS)
