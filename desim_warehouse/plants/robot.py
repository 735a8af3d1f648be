"""What drawings do not say of the robots, from a file with the keys of a model: `robot` and `battery`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from desim_warehouse.model.messages import Outline
from desim_warehouse.model.parse import from_file, valid
from desim_warehouse.model.sections.fleet import BatterySpec, RobotSpec
from desim_warehouse.values.fields import Part


class RobotFile(Part):
    """A robot and its battery; what is not there is as drawn, or assumed."""

    robot: RobotSpec | None = None
    battery: BatterySpec | None = None


_OUTLINE = Outline(RobotFile)


def read_robot(path: str | Path) -> dict[str, Any]:
    """The sections of a file about a robot, as they stand in it.

    Args:
        path: a YAML file with `robot` as below `fleet`, `battery`, or both, in metres and seconds or with units.

    Raises:
        ModelError: with every problem of the file, in its order.
    """
    document = from_file(Path(path), str(path), "a robot with robot or battery", _OUTLINE)
    valid(document, RobotFile, _OUTLINE)
    return {key: value for key, value in document.data.items() if value is not None}
