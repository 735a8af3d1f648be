"""Making the folders that results are written to."""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

_DEEPEST = 200
"""Folders inside one another; `Path.mkdir` takes a call for each, and Python allows some hundred."""


def make_folder(folder: Path, mode: int = 0o777) -> None:
    """Make a folder, and those above it, unless they are there. `mode`: who may use it, less the process's umask.

    Raises:
        OSError: where that cannot be.
    """
    if len(folder.parts) > _DEEPEST:
        raise OSError(errno.ENAMETOOLONG, f"more than {_DEEPEST} folders inside one another", str(folder))
    folder.mkdir(mode, parents=True, exist_ok=True)
