"""The indicators that a study can look at: those of `desim_warehouse.metrics`."""

from __future__ import annotations

import math

from desim_warehouse.metrics import STATES

INDICATORS = (
    "T",
    "S",
    "C",
    "tasks",
    "moves",
    "distance",
    "energy",
    "waiting",
    "cost",
    "rear_ends",
    "crossings",
    "rotations",
    "throughput_per_hour",
    "cycle_time_mean",
    "cycle_time_median",
    "cycle_time_p95",
    "backlog",
    "tardiness_mean",
    "on_time",
    *(f"share_{state}" for state in STATES),
)
"""`tardiness_mean` and `on_time` only where tasks have due times."""


def within(indicator: str) -> tuple[float, float]:
    """What an indicator of ours can be: a share 0 to 1, any other at least 0."""
    if indicator not in INDICATORS:
        return -math.inf, math.inf
    return 0.0, 1.0 if indicator.startswith("share_") or indicator == "on_time" else math.inf
