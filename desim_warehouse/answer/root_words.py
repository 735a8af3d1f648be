"""Roots of waits (the ends of chains of waiting robots) in words.

For the answers of `desim run` and `desim why`, and for the replay.
"""

from __future__ import annotations

from desim_warehouse.model import Model
from desim_warehouse.model.facts.workers import staff
from desim_warehouse.outcome.chains import ANYWHERE, CROSSING, LANE, RING, TWO_WAY, Root
from desim_warehouse.states import APART, IN_LIFT, OPENING, PACKING, PICKER, SERVER, SHOWN, TOO_LOW, Phase

_PLACES = {
    CROSSING: "at the crossing {}",
    LANE: "behind others on {}",
    TWO_WAY: "for the two-way lane {}",
    RING: "in rings of robots at {}",
}
"""Roots that are places (see `outcome.chains`)."""
_HANDLING = (Phase.LOADING, Phase.UNLOADING)
"""Phases of robots at nodes and in stations, not in the bays beside them."""


def root(origin: Root, model: Model) -> str:
    """Name the root of a wait: `for a packer at R`, `at the crossing V`, `for robots loading on B>E`."""
    if origin.cause in _PLACES:
        return _PLACES[origin.cause].format(_with_names(origin.at, model))
    if origin.cause in ANYWHERE:
        return "for a free charger, too low to work" if origin.cause in TOO_LOW else f"for {PICKER.what}"
    if origin.cause in APART:
        return _apart(origin, model)
    floor = model.floor
    kinds = (floor.stations,) if SHOWN[origin.cause].phase in _HANDLING else (floor.bays, floor.stations)
    zones = {node: item.zone for of_kind in kinds for node, item in of_kind.items()}
    place = f"{zones[origin.at]} ({origin.at})" if origin.at in zones else _with_names(origin.at, model)
    state = SHOWN[origin.cause]
    if state.queue is None:
        return f"for robots {state.doing} {'on' if '>' in origin.at else 'at'} {place}"
    if state.queue == OPENING:
        return f"for {place} to open"
    is_packing = state.queue == SERVER and zones.get(origin.at) == PACKING
    return f"for a {staff(model, PACKING)} at {origin.at}" if is_packing else f"for {state.queue.what} at {place}"


def _apart(origin: Root, model: Model) -> str:
    """Name a root other than a robot: a closed lane, a person, or a lift with its name."""
    what, place = APART[origin.cause].doing.removeprefix("waiting "), _with_names(origin.at, model)
    if origin.cause == IN_LIFT:
        return f"{what.replace('a lift', f'lift {_lift_at(origin.at, model)}')} ({place})"
    return what.replace("a lane", place) if "a lane" in what else f"{what} on {place}"


def _lift_at(place: str, model: Model) -> str:
    """Return the name of the lift at a node, or of the lift to or from which an edge leads."""
    return next(
        lift.name
        for lift in model.floor.lifts
        for node in lift.nodes
        if place == node or place.endswith(f">{node}") or place.startswith(f"{node}>")
    )


def _with_names(place: str, model: Model) -> str:
    """Return a node or lane with the names of its storage places: `A>B (R-01-01 to R-01-08)`."""
    names = model.floor.names_at.get(place, ())
    ends = dict.fromkeys((names[0], names[-1])) if names else ()
    return f"{place} ({' to '.join(ends)})" if ends else place
