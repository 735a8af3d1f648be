"""A routing policy that knows no closures: a robot waits before them, as all did on fixed routes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.policies import Roads


@dataclass(frozen=True)
class Stubborn:
    """The shortest route, whatever is closed."""

    cost: ClassVar[str] = "length"
    fixed: ClassVar[bool] = True

    def route(self, origin: str, goal: str, roads: Roads) -> Sequence[str]:
        """The nodes from origin to goal."""
        return roads.oracle("length").way(origin, goal)
