"""Something that may hold a warehouse up, with the model without it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

DOSE = 0.1
"""The part of a capacity, or of the work, by which gains are compared."""
MOST_UNTAKEN = 0.1
"""Part of their time that tasks may wait to be taken up without robots being scarce."""


@dataclass(frozen=True)
class Suspect:
    """Something that may hold the warehouse up: its name, the relief in words and in keys of the model.

    `waited`: the part of the fleet's time that robots waited there, in the run that was looked at, None where robots do
    not wait for it, such as handling. `dose`: the relief as a part of what is there, 1 for one server beside another;
    None where something in the way is taken away as a whole. `beside`: it is no resource but the work itself, less of
    which always gains: it stands beside the contest. Of one name there may be several, such as other policies.
    """

    name: str
    relief: str
    overrides: Mapping[str, Any]
    waited: float | None = None
    dose: float | None = None
    beside: bool = False

    @property
    def scale(self) -> float:
        """What makes its gain into that of an equal dose: a tenth of a capacity or of the work, or all of the rest."""
        return 1.0 if self.dose is None else DOSE / abs(self.dose)
