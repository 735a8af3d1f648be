"""What the hand calculation leaves out, and how much of it a model has, as `desim check` says beside it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.model.facts.disturbances import disturbances

if TYPE_CHECKING:
    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model


def left_out(model: Model, layout: Layout) -> list[str]:
    """A line for each thing that keeps robots or chargers from work at times, for what never does, for two-way lanes.

    Estimates of tasks do not choose the end of a lane at which a robot begins: which is nearer depends on where it is.
    """
    found = [f"{text}; estimates do not know of it" for text in disturbances(model, layout)]
    two_way = sum(len(layout.approaches(place.edge, place.offset)) > 1 for place in layout.storage)
    if two_way:
        found.append(
            f"{two_way} of {len(layout.storage)} storage places are on two-way lanes; robots come to them from the "
            "nearer end, estimates assume the end named first, so tasks may take less time"
        )
    return found
