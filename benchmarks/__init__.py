"""Measurements: how fast, how large, how well; each module has `report()`, a line of figures."""

from desim_warehouse.world.traffic.events import Arrival, Clock

GROUPS = (
    (11, 8, 39, 28, 53, 1, 69, 42, 79, 6),
    (74, 50, 62, 15, 49, 34, 14, 72, 31, 37),
    (68, 79, 56, 47, 48, 75, 23, 50, 76, 16),
    (59, 6, 74, 2, 67, 49, 53, 28, 25, 79),
    (14, 65, 41, 75, 22, 36, 54, 74, 9, 48),
)
"""The goods of the paper's five groups (Table III)."""


def up_to(clock: Clock, time: float) -> None:
    """Simulate up to a time with the loop that runs use: SimPy's own takes a call more for each event."""
    clock.run_to(Arrival(clock, time))
