"""How many robots are under way, and a cap on them: a floor that holds too many does less than one that holds fewer.

A robot is under way from being given a task in its bay, or leaving it for another reason, until it is parked again.
With the cap reached robots in bays are given no task, until one is parked. Robots under way go from task to task
without permission. Robots that leave for the sake of a battery, to a charger or from one, count but do not wait, so
none runs flat for the cap. It could hold back work for ever only if no robot came home, and one always does or works on
(docs/why.md, "Never stalled").
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from desim_warehouse.world.robots.duty import Duty


class Departures:
    """The robots under way, by number, and the most that may be under way to take up work (None: no cap)."""

    def __init__(self, most: int | None, duty: Duty) -> None:
        self.most = most
        self.duty = duty
        self.under_way: set[int] = set()

    @property
    def is_full(self) -> bool:
        """Whether no robot may leave its bay for a task now."""
        return self.most is not None and len(self.under_way) >= self.most

    def may_work(self, number: int) -> bool:
        """Whether a robot may be given a task: in its hours, if it is under way, or may set out."""
        return (number in self.under_way or not self.is_full) and self.duty.has(number)
