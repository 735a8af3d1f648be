"""The keys of LIF 1.0 files, as the guideline's JSON schema has them, and two of 2.0: station type, length of an edge.

Source: VDMA, Layout Interchange Format (LIF), version 1.0.0, 2024; keys not listed here are allowed there, too.
"""

from __future__ import annotations

from desim_warehouse.plants.keyed import Each, Flag, Number, Text, section

_TURNS = Text(("NONE", "CCW", "CW", "BOTH"))

ACTION = section(
    {
        "actionType": Text(),
        "actionDescription": Text(),
        "requirementType": Text(("REQUIRED", "CONDITIONAL", "OPTIONAL")),
        "blockingType": Text(("NONE", "SOFT", "HARD")),
        "actionParameters": Each(section({"key": Text(), "value": Text()}, "key value")),
    },
    "actionType blockingType",
)
TRAJECTORY = section(
    {
        "degree": Number(least=1),
        "knotVector": Each(Number(least=0, most=1)),
        "controlPoints": Each(section({"x": Number(), "y": Number(), "weight": Number(least=1)}, "x y")),
    },
    "knotVector controlPoints",
)
ON_EDGE = section(
    {
        "vehicleTypeId": Text(),
        "vehicleOrientation": Number(),
        "orientationType": Text(("GLOBAL", "TANGENTIAL")),
        "rotationAllowed": Flag(),
        "rotationAtStartNodeAllowed": _TURNS,
        "rotationAtEndNodeAllowed": _TURNS,
        "maxSpeed": Number(),
        "maxRotationSpeed": Number(),
        "minHeight": Number(),
        "maxHeight": Number(),
        "loadRestriction": section(
            {"unloaded": Flag(), "loaded": Flag(), "loadSetNames": Each(Text())}, "unloaded loaded"
        ),
        "actions": Each(ACTION),
        "trajectory": TRAJECTORY,
        "physicalLineGuidedProperty": section({"direction": Text(), "length": Number(least=0)}),
        "reentryAllowed": Flag(),
    },
    "vehicleTypeId rotationAllowed",
)
ON_NODE = section({"vehicleTypeId": Text(), "theta": Number(), "actions": Each(ACTION)}, "vehicleTypeId")
NODE = section(
    {
        "nodeId": Text(),
        "nodeName": Text(),
        "nodeDescription": Text(),
        "mapId": Text(),
        "nodePosition": section({"x": Number(), "y": Number()}, "x y", "x y"),
        "vehicleTypeNodeProperties": Each(ON_NODE),
    },
    "nodeId nodePosition vehicleTypeNodeProperties",
    "nodeId nodePosition",
)
EDGE = section(
    {
        "edgeId": Text(),
        "edgeName": Text(),
        "edgeDescription": Text(),
        "startNodeId": Text(),
        "endNodeId": Text(),
        "vehicleTypeEdgeProperties": Each(ON_EDGE),
    },
    "edgeId startNodeId endNodeId vehicleTypeEdgeProperties",
    "startNodeId endNodeId",
)
STATION = section(
    {
        "stationId": Text(),
        "interactionNodeIds": Each(Text()),
        "stationName": Text(),
        "stationType": Text(),
        "stationDescription": Text(),
        "stationHeight": Number(least=0),
        "stationPosition": section({"x": Number(), "y": Number(), "theta": Number()}, "x y"),
    },
    "stationId interactionNodeIds",
    "stationId",
)
LAYOUT = section(
    {
        "layoutId": Text(),
        "layoutName": Text(),
        "layoutVersion": Text(),
        "layoutLevelId": Text(),
        "layoutDescription": Text(),
        "nodes": Each(NODE),
        "edges": Each(EDGE),
        "stations": Each(STATION),
    },
    "layoutId layoutVersion nodes edges stations",
    "nodes",
)
META = section(
    {"projectIdentification": Text(), "creator": Text(), "exportTimestamp": Text(), "lifVersion": Text()},
    "projectIdentification creator exportTimestamp lifVersion",
)
FILE = section({"metaInformation": META, "layouts": Each(LAYOUT)}, "metaInformation layouts", "layouts")
