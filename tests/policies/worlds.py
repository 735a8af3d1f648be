"""Random small warehouses with batteries that last for a few tasks: chargers may be scarce, stations small."""

from hypothesis import strategies as st

POLICIES = {
    "allocation": [
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
    "routing": ["highways", "shortest", "fastest", "congestion-aware"],
    "charging": [
        {"name": "reach-aware", "margin": 0.25},
        {"name": "opportunity", "margin": 0.25},
        {"name": "four-thresholds", "margin": 0.25},
        {"name": "swap", "time": 20, "margin": 0.25},
        {"name": "reach-aware", "margin": 0.25, "charger": "least-loaded"},
        {"name": "opportunity", "margin": 0.25, "charger": "own"},
        "threshold",
    ],
    "parking": ["home", "stay", "nearest", "spread"],
}


@st.composite
def worlds(draw):
    columns, rows, depth = draw(st.integers(1, 3)), draw(st.integers(1, 2)), draw(st.integers(2, 3))
    names = [chr(65 + i) for i in range((columns + 1) * (rows + 1))]
    size = draw(st.integers(1, 5))
    side = 2 * depth + 2
    around = 2 * (columns * 6 + rows * side)  # once around the floor
    rate = draw(st.sampled_from([1.0, {"standing": 0.1, "empty": 1.0, "loaded": 1.5, "handling": 0.5}]))
    scarce = draw(st.booleans())
    count = draw(st.integers(1, 12))
    goods = st.integers(0, columns * rows * depth * 2 - 1)
    listed = [
        {
            "good": draw(goods),
            "release": draw(st.integers(0, 200)),
            "priority": draw(st.integers(0, 2)),
        }
        for _ in range(count)
    ]
    bays = {"chargers": {"at": ["A"], "places": size, "chargers": draw(st.integers(1, size))}}
    start = ["A"]
    if scarce:
        bays["chargers"] |= {"places": 1, "chargers": 1}
        bays["parking"] = {"at": [names[-1]], "places": size, "chargers": 0}
        start = [names[-1]]
    stations = draw(st.lists(st.sampled_from(names[1:-1]), min_size=1, max_size=2, unique=True))
    inside = {"pack": {"at": stations, "places": draw(st.integers(1, 2))}} if draw(st.booleans()) else {}
    battery = {
        "capacity": 24 * around,
        "threshold": 10 * around,
        "consumption": rate,
        "charge_rate": draw(st.sampled_from([5, 50])),
    }
    if draw(st.booleans()):
        battery["taper"] = {"start": 0.8, "end_rate": 0.2}
    return {
        "layout": {
            "blocks": {"columns": columns, "rows": rows, "block_depth": depth, "goods_size": 2, "aisle_width": 2},
            "bays": bays,
            "stations": inside,
        },
        "fleet": {
            "size": size,
            "start": start,
            "robot": {"radius": 0.4, "speed": 1},
            "exit_time": 1,
        },
        "tasks": {
            "goods": listed,
            "unload_at": stations,
            "station_choice": draw(st.sampled_from(["nearest", "least-loaded", "random"])),
            "load_time": 2,
            "unload_time": 3,
            "clear_time": 1,
        },
        "battery": battery,
        "policies": {kind: draw(st.sampled_from(some)) for kind, some in POLICIES.items()}
        | {"interval": draw(st.sampled_from([0, 0, 7]))},
    }
