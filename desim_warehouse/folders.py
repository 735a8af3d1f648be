"""Folders: those that results are written to, and those with files that people copy (models/gallery, reports)."""

from __future__ import annotations

import errno
import os
from pathlib import Path

_DEEPEST = 200
"""Folders inside one another; `Path.mkdir` takes a call for each, and Python allows some hundred."""
PLACES = {"gallery": "models/gallery", "notebooks": "reports"}
"""A folder of the installed package, and where it is in the source tree; pyproject.toml says the same to the wheel."""
ANSWER = "answer.json"
"""The answer to a question, in the folder of its runs."""


def make_folder(folder: Path, mode: int = 0o777) -> None:
    """Make a folder, and those above it, unless they are there. `mode`: who may use it, less the process's umask.

    Raises:
        OSError: where that cannot be.
    """
    if len(folder.parts) > _DEEPEST:
        raise OSError(errno.ENAMETOOLONG, f"more than {_DEEPEST} folders inside one another", str(folder))
    folder.mkdir(mode, parents=True, exist_ok=True)


def shipped(kind: str) -> Path:
    """The folder with files of a kind: in the installed package, or in the source tree."""
    home = Path(__file__).parent
    installed = home / kind
    return installed if installed.is_dir() else home.parent / PLACES[kind]


def gallery() -> dict[str, Path]:
    """The model files of the gallery, by name."""
    return {path.stem: path for path in sorted(shipped("gallery").glob("*.yaml"))}


OLDEST = (0, 3)
"""The oldest version whose folders are read."""


def too_old(version: str) -> str | None:
    """Say why folders of a version are not read, and which version reads them; None where they are."""
    made = tuple(int(part) for part in version.split(".")[:2] if part.isdecimal())
    return None if made >= OLDEST else f"of version {version}, expected 0.3 or later; desim-warehouse 0.3.0 reads it"


def write_whole(path: Path, text: str) -> None:
    """Write a file atomically."""
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    partial.write_text(text, encoding="utf-8")
    partial.replace(path)
