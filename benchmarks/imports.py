"""Which modules of the package import each other in a circle? `python -m benchmarks.imports`.

A cycle is a group of modules each of which reaches every other through imports, wherever these stand: those inside
functions count. Printed are the cycles of all imports, and those that are left at run time, without what only type
checkers import (`if TYPE_CHECKING`). That importing a module runs the packages around it does not count.
"""

import ast
from pathlib import Path
from typing import NamedTuple

import networkx as nx

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = "desim_warehouse"


class Imports(NamedTuple):
    """Own modules that a module imports, by their dotted names: at run time, and for type checkers alone."""

    at_run_time: set[str]
    for_typing: set[str]


def modules(folder: Path) -> dict[str, Path]:
    """Every module below a folder of the source tree, by its dotted name."""
    paths = sorted(folder.rglob("*.py"))
    names = [".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__") for path in paths]
    return dict(zip(names, paths, strict=True))


def imported(path: Path, own: dict[str, Path]) -> Imports:
    """The modules among `own` that a file imports."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    checks = [node for node in ast.walk(tree) if isinstance(node, ast.If) and _for_typing(node.test)]
    guarded = {node for check in checks for statement in check.body for node in ast.walk(statement)}
    at_run_time: set[str] = set()
    for_typing: set[str] = set()
    for node in ast.walk(tree):
        names: set[str] = set()
        if isinstance(node, ast.ImportFrom) and node.module is not None:
            parts = [f"{node.module}.{alias.name}" for alias in node.names]
            names = {part if part in own else node.module for part in parts}
        elif isinstance(node, ast.Import):
            names = {alias.name for alias in node.names}
        (for_typing if node in guarded else at_run_time).update(names & own.keys())
    return Imports(at_run_time, for_typing - at_run_time)


def _for_typing(test: ast.expr) -> bool:
    return isinstance(test, ast.Name) and test.id == "TYPE_CHECKING"


def package() -> dict[str, Imports]:
    """What each module of the package imports of it."""
    own = modules(ROOT / PACKAGE)
    return {name: imported(path, own) for name, path in own.items()}


def cycles(imports: dict[str, set[str]]) -> list[list[str]]:
    """Groups of modules that import each other, each sorted, the largest first; one that imports itself is a group."""
    graph = nx.DiGraph(imports)
    groups = [sorted(group) for group in nx.strongly_connected_components(graph)]
    return sorted((group for group in groups if len(group) > 1 or graph.has_edge(group[0], group[0])), key=_order)


def _order(group: list[str]) -> tuple[int, list[str]]:
    return -len(group), group


def main() -> None:
    """Print how many own imports there are, and the cycles."""
    own = package()
    for_typing = sum(len(each.for_typing) for each in own.values())
    number = for_typing + sum(len(each.at_run_time) for each in own.values())
    print(f"{len(own)} modules, {number} own imports, {for_typing} of them for typing only")
    everything = {name: each.at_run_time | each.for_typing for name, each in own.items()}
    at_run_time = {name: each.at_run_time for name, each in own.items()}
    for kind, imports in (("with those for typing", everything), ("at run time", at_run_time)):
        groups = cycles(imports)
        print(f"cycles {kind}: {len(groups)}")
        for group in groups:
            print(f"  {len(group)} modules: " + ", ".join(name.removeprefix(f"{PACKAGE}.") for name in group))


if __name__ == "__main__":
    main()
