"""Buildings of several levels for Open-RMF, drawn for these tests: a hotel and a clinic of the shape of rmf_demos'.

Levels lie over each other, 20 pixels a metre, y downwards. A vertex is `name: (x, y, about)` in metres.
"""

import json

PIXELS = 20


def text(value):
    return [1, value]


YES = [4, True]
CHARGER = {"is_charger": YES, "is_parking_spot": YES, "spawn_robot_type": text("Small")}


def cabin(lift):
    return {"lift_cabin": text(lift)}


def level(elevation, vertices, lanes, others=()):
    """A level of a map; `lanes` are of graph 0, `others` of graph 1, each "a b" and two-way."""
    rank = {name: number for number, name in enumerate(vertices)}
    drawn = []
    for graph, pairs in enumerate((lanes, others)):
        for pair in pairs:
            a, b = pair.split()
            drawn.append([rank[a], rank[b], {"bidirectional": YES, "graph_idx": [2, graph]}])
    corners = len(vertices)
    return {
        "elevation": elevation,
        "doors": [[corners, corners + 1, {"name": text(f"door {elevation}"), "type": text("hinged")}]],
        "lanes": drawn,
        "measurements": [[corners, corners + 1, {"distance": [3, 10]}]],
        "vertices": [
            *(
                [x * PIXELS, y * PIXELS, 0, "" if name.startswith("v") else name, about]
                for name, (x, y, about) in vertices.items()
            ),
            [0, 0, 0, ""],
            [10 * PIXELS, 0, 0, ""],
        ],
    }


def building(name, levels, lifts):
    cars = {lift: {"depth": 2.5} for lift in lifts}
    return {"coordinate_system": "reference_image", "levels": levels, "lifts": cars, "name": name}


def hotel():
    """A ground floor with a lobby, a restaurant and a charger, two floors of rooms, and two lifts to all of them."""
    ground = {
        "v0": (4, 10, {}),
        "v1": (14, 10, {}),
        "v2": (24, 10, {}),
        "vA": (14, 4, cabin("Lift1")),
        "vB": (24, 4, cabin("Lift2")),
        "lobby": (4, 16, {}),
        "restaurant": (24, 16, {"pickup_dispenser": text("kitchen")}),
        "charger": (14, 16, {**CHARGER, "spawn_robot_name": text("tinybot_1")}),
        "v3": (4, 4, {}),
    }
    lanes = ["v0 v1", "v1 v2", "v1 vA", "v2 vB", "v0 lobby", "v2 restaurant", "v1 charger"]
    levels = {"L1": level(0, ground, lanes, ["v3 v0", "v0 v1"])}
    for floor in (2, 3):
        rooms = {
            "v0": (4, 10, {}),
            "v1": (14, 10, {}),
            "v2": (24, 10, {}),
            "vA": (14, 4, cabin("Lift1")),
            "vB": (24, 4, cabin("Lift2")),
            f"L{floor}_room1": (4, 4, {"dropoff_ingestor": text(f"room {floor}01")}),
            f"L{floor}_room15": (4, 16, {"dropoff_ingestor": text(f"room {floor}15")}),
            f"L{floor}_master_suite": (24, 16, {"dropoff_ingestor": text(f"suite {floor}")}),
        }
        lanes = ["v0 v1", "v1 v2", "v1 vA", "v2 vB", f"v0 L{floor}_room1", f"v0 L{floor}_room15"]
        levels[f"L{floor}"] = level(4 * (floor - 1), rooms, [*lanes, f"v2 L{floor}_master_suite"])
    return building("hotel", levels, ("Lift1", "Lift2"))


def clinic():
    """Two floors of treatment rooms; one lift has lanes through its cabin, and the other is too near to the corridor.

    There is a lift for people, too, to which no lane leads.
    """
    levels = {}
    for floor, dock in ((2, "v9"), (1, "charger")):
        vertices = {
            "v0": (5, 5, {}),
            "v1": (15, 5, {}),
            "v2": (25, 5, {}),
            "v3": (25, 15, {}),
            "v4": (5, 15, {}),
            "vA": (15, 15, cabin("lift_25")),
            "vB": (26.5, 15, cabin("lift_1")),
            f"L{floor}_treatment_1": (5, 1, {"dropoff_ingestor": text(f"treatment {floor}")}),
            f"L{floor}_pharmacy": (25, 1, {"pickup_dispenser": text(f"pharmacy {floor}")}),
            dock: (1, 15, {**CHARGER, "spawn_robot_name": text("caddy")} if floor == 1 else {}),
        }
        lanes = ["v0 v1", "v1 v2", "v2 v3", "v3 vA", "vA v4", "v4 v0", "v3 vB", f"v4 {dock}"]
        levels[f"L{floor}"] = level(3 * floor, vertices, [*lanes, f"v0 L{floor}_treatment_1", f"v2 L{floor}_pharmacy"])
    return building("clinic", levels, ("lift_25", "lift_1", "visitors"))


def write(folder, made):
    path = folder / f"{made['name']}.building.yaml"
    path.write_text(json.dumps(made))
    return path
