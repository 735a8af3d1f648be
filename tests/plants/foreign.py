"""Layouts that others drew: not part of this project, read from a folder of the user's; and what is said of plants."""

import math
import os
from pathlib import Path

import pytest

from desim_warehouse.questions.check import check

FOLDER = os.environ.get("DESIM_PLANTS")

needs_plants = pytest.mark.skipif(FOLDER is None, reason="DESIM_PLANTS names no folder with layouts of others")


def plant_file(name):
    return Path(FOLDER) / name


def with_enough_chargers(model):
    """The same with half as many chargers again as check asks for, at least, where it says that they are too few."""
    report = check(model)
    if "CHARGERS_SHORT" not in {finding.code for finding in report.findings}:
        return model
    return model.replace({"layout.bays.chargers.chargers": math.ceil(1.5 * report.calculation.power.needed)})


def remarks(made, what):
    """What is said of a plant under one heading: kind, and names."""
    return {(remark.kind, remark.names) for remark in made.remarks if remark.what == what}
