"""Modules import each other in circles only where a whole makes its parts, and these know it by type."""

import tomllib

import pytest

from benchmarks.imports import PACKAGE, ROOT, Imports, cycles, imported, modules

ROBOT = {"battery", "charging", "closings", "dwelling", "forecast", "robot", "surroundings", "tour"}
LANES = {"body", "drive", "intersection", "lane", "motion", "rulebook", "zones"}
WHOLES = [
    {f"desim_warehouse.world.robots.{part}" for part in ROBOT},
    {f"desim_warehouse.world.traffic.{part}" for part in LANES},
]
"""CONTRIBUTING names them, too. A new one is rather cut by a Protocol, or by moving what both need below them."""


@pytest.fixture(scope="module")
def imports():
    own = modules(ROOT / PACKAGE)
    return {name: imported(path, own) for name, path in own.items()}


def test_imports_at_run_time_and_for_typing_are_told_apart(tmp_path):
    own = {name: tmp_path / name for name in ("p", "p.a", "p.b", "p.c", "p.d", "p.e", "p.f")}
    path = tmp_path / "some.py"
    path.write_text(
        "from typing import TYPE_CHECKING\n"
        "from p import a, thing\n"
        "if TYPE_CHECKING:\n"
        "    import simpy\n"
        "    from p.b import B\n"
        "    from p.f import F\n"
        "else:\n"
        "    import p.c\n"
        "def late():\n"
        "    from p.d import D\n"
        "    if True:\n"
        "        import p.f\n"
    )
    assert imported(path, own) == Imports({"p", "p.a", "p.c", "p.d", "p.f"}, {"p.b"})


def test_cycles_are_groups_and_modules_that_import_themselves():
    graph = {"a": {"b"}, "b": {"c", "d"}, "c": {"a"}, "d": {"d", "e"}, "e": set()}
    assert cycles(graph) == [["a", "b", "c"], ["d"]]


def test_at_run_time_no_module_imports_another_in_a_circle(imports):
    assert cycles({name: each.at_run_time for name, each in imports.items()}) == []


def test_only_wholes_and_their_parts_know_each_other_by_type(imports):
    groups = cycles({name: each.at_run_time | each.for_typing for name, each in imports.items()})
    assert [set(group) for group in groups] == WHOLES


def test_the_layers_have_no_exceptions():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    assert contracts
    assert [contract["name"] for contract in contracts if "ignore_imports" in contract] == []
