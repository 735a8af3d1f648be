"""A hall of two rows of blocks with wide aisles, in which people pick orders of 1 to 4 lines into robots."""


def hall(columns, parking, packing, saturated, run):
    """The model of a hall; `packing`: the station, `saturated`: lines that are always open."""
    picks = {"from": "storage", "to": "packing", "arrivals": {"saturated": saturated}, "lines": [1, 4]}
    blocks = {"rows": 2, "block_width": 2, "block_depth": 10, "goods_size": 1, "aisle_width": 2.4}
    return {
        "name": "hall",
        "layout": {
            "blocks": {"columns": columns, **blocks},
            "aisles": "wide",
            "bays": {"west": {"along": "west", "places": parking}},
            "stations": {"packing": {**packing, "servers": 2}},
        },
        "fleet": {"size": 6, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1.5, "capacity": 6}},
        "tasks": {"load_time": 12, "unload_time": 3, "flows": {"picks": picks}},
        "pickers": {"count": 3, "speed": 1},
        "policies": {"allocation": "nearest", "routing": "fastest", "batching": "by-order"},
        "run": run,
        "log": "tasks",
    }
