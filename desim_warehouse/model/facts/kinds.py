"""Robots by what they draw and where they charge: kinds with batteries, charging policies or chargers of their own."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from desim_warehouse.values.fields import FrozenMap

if TYPE_CHECKING:
    from desim_warehouse.model.schema import Model


def charge_alike(model: Model) -> bool:
    """Whether all robots have the same battery, charging policy and chargers, or none has a battery."""
    if model.battery is None:
        return True
    own = any(kind.battery is not None or kind.charging is not None for kind in model.fleet.kinds.values())
    return not own and not any(bay.kinds for bay in model.layout.bays.values())


@lru_cache(maxsize=64)
def as_kind(model: Model, kind: str) -> Model:
    """The model as if all its robots had the battery, the charging policy and the chargers of a kind ("": ordinary).

    All else is as before: robots start where they do, with their sizes and speeds.
    """
    own = model.fleet.kinds.get(kind)
    battery = model.battery if own is None or own.battery is None else own.battery
    charging = model.policies.charging if own is None or own.charging is None else own.charging
    homes = tuple(model.fleet.homes(model.floor.bays))
    none = {"chargers": 0, "total_chargers": None, "outages": None, "kinds": ()}
    kinds = {
        name: item.model_copy(update={"battery": None, "charging": None}) for name, item in model.fleet.kinds.items()
    }
    bays = {
        name: bay.model_copy(update={"kinds": ()} if not bay.kinds or kind in bay.kinds else none)
        for name, bay in model.layout.bays.items()
    }
    return model.model_copy(
        update={
            "battery": battery,
            "policies": model.policies.model_copy(update={"charging": charging}),
            "fleet": model.fleet.model_copy(update={"kinds": FrozenMap(kinds), "start": homes}),
            "layout": model.layout.model_copy(update={"bays": FrozenMap(bays)}),
        }
    )


def by_kind(model: Model) -> dict[str, Model]:
    """For each kind that has robots ("": ordinary ones) the model `as_kind`: itself where all robots charge alike."""
    kinds = dict.fromkeys(model.fleet.kinds_of_robots(), model)
    return kinds if charge_alike(model) else {kind: as_kind(model, kind) for kind in kinds}


def shares(model: Model) -> dict[str, float]:
    """The part of the fleet that is of each kind that has robots."""
    kinds = model.fleet.kinds_of_robots()
    return {kind: kinds.count(kind) / len(kinds) for kind in dict.fromkeys(kinds)}


def said(kind: str) -> str:
    """The robots of a kind, at the beginning of a line."""
    return f"kind {kind}" if kind else "other robots"
