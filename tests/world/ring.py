"""A ring A > B > C > D > A of four edges of 10, for robots of speed 1 and D = 1; goods at a node and on an edge."""

RING = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [10, 10], "D": [0, 10]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"node": "B"}, {"edge": ["C", "D"], "offset": 5}],
        "bays": {"home": {"at": ["A"]}},
        "stations": {"pack": {"at": ["D"]}},
    },
    "fleet": {"size": 2, "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {"goods": [0], "unload_at": ["pack"], "load_time": 5, "unload_time": 3},
}
