"""What keeps robots from work at times, how much of it a model has, and what the quick estimate leaves out of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.model.facts.disturbances import closures, disturbances

if TYPE_CHECKING:
    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model

UNKNOWN = "; estimates do not know of it"


def left_out(model: Model, layout: Layout) -> list[str]:
    """A line for each thing that keeps robots or chargers from work at times, and for what estimates leave out."""
    found = [*disturbances(model, layout), *(f"{text}{UNKNOWN}" for text in closures(model))]
    if model.fleet.breaks_down:
        found.append(f"robots draw on while they are broken, and begin again what they did{UNKNOWN}")
    if model.fleet.has_hours or model.layout.has_hours:
        found.append(f"robots finish their tasks and charge when their hours, or those of stations, are over{UNKNOWN}")
    found += [
        f"{name} is a policy of your own: the first of its kind is tried{UNKNOWN}" for name in model.policies.own()
    ]
    return found
