"""Short probes of some tests leave nothing behind that another test would be given."""

import importlib
import pkgutil

import desim_warehouse.questions
import desim_warehouse.run
import desim_warehouse.study
from tests.brief import KEPT

PROBING = (desim_warehouse.run, desim_warehouse.study, desim_warehouse.questions)
"""Packages that probe a model before its runs, or ask those that do."""
UNPROBED = {
    ("desim_warehouse.study.plan", "run_seed"),
    ("desim_warehouse.study.execution.cache", "program"),
    ("desim_warehouse.study.execution.cache", "_versions_of_packages"),
}
"""What they keep and no probe measures."""


def test_all_that_keeps_a_measurement_of_a_probe_has_a_memory_of_its_own_in_brief_tests():
    """Otherwise the quick estimate of a model would be the short one in whichever test comes second."""
    names = [
        module.name for package in PROBING for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    ]
    keeping = {
        (module, name)
        for module in names
        for name, value in vars(importlib.import_module(module)).items()
        if hasattr(value, "cache_info") and value.__module__ == module
    }
    assert keeping - UNPROBED == {(module.__name__, name) for module, name in KEPT}
