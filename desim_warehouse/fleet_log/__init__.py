"""What a real fleet did: its log read, a model calibrated from it, a model held against it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from desim_warehouse.fleet_log.table import FleetLog

__all__ = ["read_log"]


def read_log(path: str | Path) -> FleetLog:
    """The log of a fleet: the folder of a run, a CSV file of trips, or messages of VDA 5050 as JSON lines.

    Raises:
        ReportError: what cannot be read, or has no good row.
    """
    from desim_warehouse.fleet_log.runs import from_run
    from desim_warehouse.fleet_log.trips import read_trips
    from desim_warehouse.fleet_log.vda5050 import read_messages
    from desim_warehouse.run.folder import load_run

    path = Path(path)
    if path.is_dir():
        return from_run(load_run(path))
    return read_trips(path) if path.suffix.lower() == ".csv" else read_messages(path)
