"""Layouts that others drew: not part of this project, read from a folder of the user's."""

import os
from pathlib import Path

import pytest

FOLDER = os.environ.get("DESIM_PLANTS")

needs_plants = pytest.mark.skipif(FOLDER is None, reason="DESIM_PLANTS names no folder with layouts of others")


def plant_file(name):
    return Path(FOLDER) / name
