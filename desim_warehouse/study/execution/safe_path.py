"""Python processes find their modules where this one does, never in a working directory that somebody filled."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

_SAFE = "PYTHONSAFEPATH"


@contextmanager
def safe_path() -> Iterator[None]:
    """Python started meanwhile begins without the working directory in its path (as by `python -P`).

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
