"""Before a process of a study imports much: no threads of numerical libraries, and modules found safely.

For the command line and the worker processes of studies.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager


def alone() -> None:
    """Keep numerical libraries imported later from starting threads, which cost more than they save."""
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")


_SAFE = "PYTHONSAFEPATH"


@contextmanager
def safe_path() -> Iterator[None]:
    """Have Python processes started meanwhile leave the working directory out of their path (as by `python -P`).

    `multiprocessing` starts `python -c`, which would look for its first modules there. It then gives the process our
    own path and working directory, so policies of model files find what they find in this process.
    """
    before = os.environ.get(_SAFE)
    os.environ[_SAFE] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[_SAFE]
        else:
            os.environ[_SAFE] = before
