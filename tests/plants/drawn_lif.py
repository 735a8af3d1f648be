"""A dock in LIF, drawn for these tests and worked out by hand.

A one-way ring A-B-C-D of 12 m by 8 m; a spur from B to the rack, 5 m, two-way, backwards out of it; one from C to the
belt; one from D to the charger. A tall truck may use the ring and the rack only.

    D --- C --- belt
    |     |
    A --- B --- rack          (the charger left of D)
"""

import copy
import json

PI = 3.141592653589793


def node(name, x, y, *actions, types=("forklift", "tall truck")):
    doing = [{"actionType": one, "blockingType": "HARD", "requirementType": "CONDITIONAL"} for one in actions]
    about = [{"vehicleTypeId": one, **({"actions": doing} if doing else {})} for one in types]
    return {"nodeId": name, "mapId": "1", "nodePosition": {"x": x, "y": y}, "vehicleTypeNodeProperties": about}


def edge(start, end, types=("forklift", "tall truck"), **about):
    properties = [{"vehicleTypeId": one, "rotationAllowed": False, **about} for one in types]
    return {"edgeId": f"{start}-{end}", "startNodeId": start, "endNodeId": end, "vehicleTypeEdgeProperties": properties}


def station(name, *nodes, **about):
    return {"stationId": name, "interactionNodeIds": list(nodes), "stationHeight": 0.0, **about}


FORKLIFT = ("forklift",)
DOCK = {
    "metaInformation": {
        "projectIdentification": "dock",
        "creator": "these tests",
        "exportTimestamp": "2026-03-02T06:00:00.00Z",
        "lifVersion": "1.0.0",
    },
    "layouts": [
        {
            "layoutId": "ground",
            "layoutName": "Ground floor",
            "layoutVersion": "1",
            "layoutLevelId": "0",
            "nodes": [
                node("A", 0.0, 0.0),
                node("B", 12.0, 0.0),
                node("C", 12.0, 8.0),
                node("D", 0.0, 8.0),
                node("rack", 17.0, 0.0, "pick"),
                node("belt", 17.0, 8.0, "drop", types=FORKLIFT),
                node("plug", -4.0, 8.0, "startCharging", "stopCharging", types=FORKLIFT),
            ],
            "edges": [
                edge("A", "B", maxSpeed=1.5),
                edge("B", "C"),
                edge("C", "D", maxSpeed=1.0),
                edge("D", "A"),
                edge("B", "rack", maxSpeed=0.5),
                edge("rack", "B", maxSpeed=0.5, orientationType="TANGENTIAL", vehicleOrientation=PI),
                edge("C", "belt", FORKLIFT),
                edge("belt", "C", FORKLIFT, vehicleOrientation=PI),
                edge("D", "plug", FORKLIFT, loadRestriction={"unloaded": True, "loaded": False}),
                edge("plug", "D", FORKLIFT, loadRestriction={"unloaded": True, "loaded": False}),
            ],
            "stations": [station("racks", "rack"), station("belts", "belt"), station("chargers", "plug")],
        }
    ],
}


def dock(change=None):
    """The dock; `change` gets it and its only layout to change."""
    made = copy.deepcopy(DOCK)
    if change is not None:
        change(made, made["layouts"][0])
    return made


def write(path, content):
    path.write_text(json.dumps(content, indent=1))
    return path
