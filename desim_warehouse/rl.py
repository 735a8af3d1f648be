"""The former path of `learn.rl`; forwards to it until version 0.4."""

from __future__ import annotations

import warnings

from desim_warehouse.learn.rl import AllocationEnv

__all__ = ["AllocationEnv"]

_SAID = "desim_warehouse.rl is now desim_warehouse.learn.rl; the old path will be removed in version 0.4"
warnings.warn(_SAID, DeprecationWarning, stacklevel=2)
