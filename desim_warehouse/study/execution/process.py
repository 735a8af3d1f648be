"""Preparation of a process before its imports: no threads of numerical libraries, and a safe module path.

For the command line and the worker processes of studies.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager


def alone() -> None:
    """Keep numerical libraries that are imported later from starting threads, which cost more than they save."""
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")


_SAFE = "PYTHONSAFEPATH"


@contextmanager
def safe_path() -> Iterator[None]:
    """Leave the working directory out of the path of Python processes started within this block (as `python -P`).

    `multiprocessing` starts `python -c`, which would look for its first modules there. It then passes our own path and
    working directory to the process, so that policies of model files find the same modules as in this process.
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
