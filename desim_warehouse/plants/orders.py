"""Transport orders of openTCS: XML beside a plant model.

For `desim import`, which adds them to the model of the plant.
"""

from __future__ import annotations

from pathlib import Path

from desim_warehouse.errors import got
from desim_warehouse.plants.plant import Plant, Transport
from desim_warehouse.plants.xml import read_xml

EXPECTED = "transport orders of openTCS (XML)"
_DUE = {
    "MINUS_FIVE_MINUTES": -300,
    "MINUS_HALF_HOUR": -1800,
    "PLUS_FIVE_MINUTES": 300,
    "PLUS_HALF_HOUR": 1800,
    "PLUS_ONE_HOUR": 3600,
    "PLUS_TWO_HOURS": 7200,
}
"""Deadlines in seconds from the start of a run."""


def read(path: Path, content: bytes, plant: Plant) -> None:
    """Add the tasks of a file to a plant.

    Raises:
        ModelError: a file that cannot be read, with the line.
    """
    root = read_xml(path, content, EXPECTED)
    if root.tag != "transportOrders":
        root.refuse(f"not transport orders, expected {EXPECTED} with the root element transportOrders")
    places = {*plant.points, *(location.name for location in plant.locations)}
    gone: dict[str, str] = {}
    wanted: list[str] = []
    for rank, order in enumerate(root.all("transportOrder"), 1):
        name = order.attributes.get("name") or f"order {rank}"
        stops = [(item.text("locationName"), item.text("vehicleOperation")) for item in order.all("driveOrder")]
        deadline = order.attributes.get("deadline", "")
        if deadline and deadline not in _DUE:
            order.refuse(f"deadline: not known (got {got(deadline)}), expected one of {', '.join(_DUE)}")
        due = max(_DUE[deadline], 0) if deadline else None
        if order.attributes.get("intendedVehicle"):
            wanted.append(name)
        if strange := next((place for place, _ in stops if place not in places), None):
            gone[name] = strange
        else:
            plant.transports.append(Transport(name, tuple(stops), 0.0, due, f"{path.name}, {order.position}"))
    if not plant.transports:
        lost = f"; {next(iter(gone))} is to {got(next(iter(gone.values())))}" if gone else ""
        root.refuse(f"no order that the plant has all locations of, expected one transportOrder at least{lost}")
    plant.note("left out", "transport order", gone, "to a location that the plant does not have, or that is left out")
    plant.note("left out", "intended vehicle", wanted, "any robot carries out a task")
