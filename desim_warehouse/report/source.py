"""The former home of `report.study_parts.read`, for notebooks that were kept from version 0.1.0."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

from desim_warehouse.report.study_parts import read

if TYPE_CHECKING:
    from pathlib import Path

    from desim_warehouse.study.results import Results


def read_study(folder: str | Path) -> Results:
    """As `report.study_parts.read`."""
    text = "report.source.read_study is now report.study_parts.read; the old name will be removed in version 0.3"
    warnings.warn(text, DeprecationWarning, stacklevel=2)
    return read(folder)
