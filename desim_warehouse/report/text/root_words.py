"""What robots waited for in the end, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.states import SHOWN

if TYPE_CHECKING:
    from desim_warehouse.model import Model
    from desim_warehouse.outcome.chains import Root

_ROOTS = {
    "crossing": "at the crossing {}",
    "lane": "behind others on {}",
    "two_way_lane": "for the two-way lane {}",
    "ring": "in rings of robots at {}",
    "queueing_server": "for a server of {}",
    "queueing_charger": "for a charger of {}",
    "closed": "for {} to open",
    "waiting_closed": "for {}, which was closed",
    "waiting_person": "for people in {}",
}
"""What robots wait for where a chain of waits ends (see `outcome.chains`); of other roots, what the last one does."""


def root(of: Root, model: Model) -> str:
    """What robots waited for in the end: `for a server of packing (R)`, `at the crossing V`."""
    zones = {node: item.zone for of_kind in (model.floor.bays, model.floor.stations) for node, item in of_kind.items()}
    place = f"{zones[of.at]} ({of.at})" if of.at in zones and of.cause in SHOWN else of.at
    if of.cause in _ROOTS:
        return _ROOTS[of.cause].format(place)
    return f"for robots {SHOWN[of.cause].doing} at {place}"
