"""The battery of a robot: what it holds, what each state draws, how it is charged."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator

from desim_warehouse.errors import got
from desim_warehouse.values.fields import (
    NUMBER,
    SECTION,
    Forms,
    Fraction,
    NotNegative,
    Part,
    Positive,
    by_type,
    form,
    wrong,
)


class Consumption(Part):
    """Energy per time unit by state."""

    standing: NotNegative = Field(description="waiting or idle")
    empty: NotNegative = Field(description="driving without a good")
    loaded: NotNegative = Field(description="driving with a good")
    handling: NotNegative = Field(description="loading and unloading")


class Taper(Part):
    """A charge curve: full rate up to `start`, then falling linearly to `end_rate` when full."""

    start: Fraction = Field(description="fraction of capacity")
    end_rate: Fraction = Field(0.1, description="fraction of charge_rate at full")


class BatterySpec(Part):
    """The battery of every robot."""

    capacity: Positive = Field(description="energy of a full battery")
    threshold: NotNegative = Field(description="level at which the threshold policy sends a robot home")
    consumption: Annotated[
        Annotated[NotNegative, form("number")] | Annotated[Consumption, form("states")],
        Forms(
            "a number of at least 0, or a section with standing, empty, loaded and handling",
            pick=by_type(number=NUMBER, states=SECTION),
        ),
    ] = Field(description="energy per time unit outside the charging zone")
    charge_rate: Positive = Field(description="energy per time unit at a charger")
    taper: Taper | None = Field(None, description="default: full rate until the battery is full")
    # The paper's program lets batteries fall below 0; beyond the reserve that is an error here, not a statistic
    reserve: NotNegative = Field(
        0.0, description="energy below 0 that a robot may still draw; beyond that it is flat, an error"
    )

    @field_validator("threshold")
    @classmethod
    def _below_capacity(cls, threshold: float, info: ValidationInfo) -> float:
        capacity = info.data.get("capacity", math.inf)
        if threshold >= capacity:
            expected = f"a level below battery.capacity, {got(capacity)}"
            raise wrong(f"too large (got {got(threshold)}), expected {expected}")
        return threshold

    @property
    def draws(self) -> Consumption:
        """Energy per time unit in every state, also where the file has one number for all."""
        one = self.consumption
        if isinstance(one, Consumption):
            return one
        return Consumption(standing=one, empty=one, loaded=one, handling=one)
