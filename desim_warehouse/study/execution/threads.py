"""Numerical libraries start no threads of their own where this is called before they are imported."""

from __future__ import annotations

import os


def alone() -> None:
    """Starting them costs more than they save here; what users set is kept."""
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
