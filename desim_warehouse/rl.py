"""The former path of `learn.rl`; forwards to it until version 0.4."""

from __future__ import annotations

import warnings

from desim_warehouse.learn.rl import AllocationEnv

__all__ = ["AllocationEnv"]

warnings.warn("desim_warehouse.rl is now desim_warehouse.learn.rl", DeprecationWarning, stacklevel=2)
