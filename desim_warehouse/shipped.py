"""Files that people copy and that the source tree shows where they look for them: models/gallery, reports."""

from __future__ import annotations

from pathlib import Path

PLACES = {"gallery": "models/gallery", "notebooks": "reports"}
"""A folder of the installed package, and where it is in the source tree; pyproject.toml says the same to the wheel."""


def shipped(kind: str) -> Path:
    """The folder with files of a kind: in the installed package, or in the source tree."""
    home = Path(__file__).parent
    installed = home / kind
    return installed if installed.is_dir() else home.parent / PLACES[kind]


def gallery() -> dict[str, Path]:
    """The model files of the gallery, by name."""
    return {path.stem: path for path in sorted(shipped("gallery").glob("*.yaml"))}
