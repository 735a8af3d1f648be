"""The battery of a robot: what it holds, what each state draws, how it is charged."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import Field, ValidationInfo, field_validator

from desim_warehouse.errors import got
from desim_warehouse.values.fields import (
    NUMBER,
    SECTION,
    Energy,
    Forms,
    Fraction,
    Part,
    Positive,
    Power,
    Unit,
    by_type,
    form,
    wrong,
)


class Consumption(Part):
    """Energy per time unit by state."""

    standing: Power = Field(title="consumption standing", description="waiting or idle")
    empty: Power = Field(title="consumption without a load", description="driving without a good")
    loaded: Power = Field(title="consumption with a load", description="driving with a good")
    handling: Power = Field(title="consumption in handling", description="loading and unloading")


class Taper(Part):
    """A charge curve: full rate up to `start`, then falling linearly to `end_rate` when full."""

    start: Fraction = Field(title="level at which charging slows down", description="fraction of capacity")
    end_rate: Fraction = Field(0.1, title="charge rate when full", description="fraction of charge_rate at full")


class BatterySpec(Part):
    """The battery of every robot."""

    capacity: Annotated[Positive, Unit("energy")] = Field(
        title="battery capacity", description="energy of a full battery"
    )
    threshold: Energy = Field(
        0.0,
        title="charging threshold",
        description="level at which the threshold policy sends a robot home; must be given with it, others have their "
        "own levels",
    )
    consumption: Annotated[
        Annotated[Power, form("number")] | Annotated[Consumption, form("states")],
        Forms(
            "a number of at least 0, or a section with standing, empty, loaded and handling",
            pick=by_type(number=NUMBER, states=SECTION),
        ),
    ] = Field(
        description="energy per time unit; nothing is drawn from a battery that is charged, or at rest in a bay with a "
        "charger for each slot"
    )
    charge_rate: Annotated[Positive, Unit("power")] = Field(description="energy per time unit at a charger")
    taper: Taper | None = Field(None, description="default: full rate until the battery is full")
    # The paper's program lets batteries fall below 0; beyond the reserve that is an error here, not a statistic
    reserve: Energy = Field(
        0.0,
        title="energy reserve",
        description="energy below 0 that a robot may still draw; beyond that it is flat, an error",
    )

    @field_validator("threshold")
    @classmethod
    def _below_capacity(cls, threshold: float, info: ValidationInfo) -> float:
        capacity = info.data.get("capacity", math.inf)
        if threshold >= capacity:
            expected = f"a level below battery.capacity, {got(capacity)}"
            raise wrong(f"too large (got {got(threshold)}), expected {expected}")
        return threshold

    def content(self) -> Any:
        """As of any section; a threshold that is not given is left out, as a policy may ask for it."""
        found: dict[str, Any] = super().content()
        return found if "threshold" in self.model_fields_set else {k: v for k, v in found.items() if k != "threshold"}

    @property
    def draws(self) -> Consumption:
        """Energy per time unit in every state, also where the file has one number for all."""
        one = self.consumption
        if isinstance(one, Consumption):
            return one
        return Consumption(standing=one, empty=one, loaded=one, handling=one)
