"""A hall whose orders an ERP exports."""

import json

import pytest

FLOOR = {
    "name": "hall",
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 10], "D": [0, 10]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"edge": ["A", "B"], "offset": 5.0 + number} for number in range(8)],
        "bays": {"home": {"at": ["D"]}},
        "stations": {"pack": {"at": ["C"]}},
    },
    "fleet": {"size": 2, "robot": {"radius": 0.4, "speed": 1.0}},
    "tasks": {
        "load_time": 5,
        "unload_time": 5,
        "flows": {"day": {"from": "storage", "to": "pack", "arrivals": {"orders": {"file": "orders.parquet"}}}},
    },
    "run": {"start": "06:00"},
}


@pytest.fixture
def hall(tmp_path):
    """A model whose orders are not there yet."""
    path = tmp_path / "hall.yaml"
    path.write_text(json.dumps(FLOOR))
    return path
