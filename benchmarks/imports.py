"""Which modules of the package import each other in a circle? `python -m benchmarks.imports`.

A cycle is a group of modules each of which reaches every other through imports, wherever these stand: those inside
functions count. Printed are the cycles of all imports, and those that are left at run time, without what only type
checkers import (`if TYPE_CHECKING`). Packages around a module, which are imported with it, do not count, nor does what
`importlib` loads by its name.
"""

import ast
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import networkx as nx

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = "desim_warehouse"


class Imports(NamedTuple):
    """Modules that one imports, by their dotted names: at run time, and for type checkers alone."""

    at_run_time: set[str]
    for_typing: set[str]


def modules(folder: Path) -> dict[str, Path]:
    """Every module below a folder of the source tree, by its dotted name."""
    paths = sorted(folder.rglob("*.py"))
    names = [".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__") for path in paths]
    return dict(zip(names, paths, strict=True))


def imported(path: Path, own: dict[str, Path]) -> Imports:
    """The modules among `own` that a file imports, wherever the import stands."""
    return imports_in(ast.parse(path.read_text(encoding="utf-8")), own)


def imports_in(tree: ast.Module, own: dict[str, Path]) -> Imports:
    """The modules among `own` that a parsed file imports, wherever the import stands."""
    imports = Imports(set(), set())
    for node, for_typing in _imports(tree.body):
        names: set[str] = set()
        if isinstance(node, ast.Import):
            names = {alias.name for alias in node.names}
        elif node.module is not None:
            parts = [f"{node.module}.{alias.name}" for alias in node.names]
            names = {part if part in own else node.module for part in parts}
        imports[for_typing].update(names & own.keys())
    return Imports(imports.at_run_time, imports.for_typing - imports.at_run_time)


def _imports(
    statements: Iterable[ast.AST], *, for_typing: bool = False
) -> Iterator[tuple[ast.Import | ast.ImportFrom, bool]]:
    """Every import among some statements and within them, and whether it is for type checkers alone."""
    for node in statements:
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield node, for_typing
        guards = isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
        for part in ("body", "orelse", "finalbody", "handlers", "cases"):
            yield from _imports(getattr(node, part, ()), for_typing=for_typing or (guards and part == "body"))


def cycles(imports: dict[str, set[str]]) -> list[list[str]]:
    """Groups of modules that import each other, the largest first; a module that imports itself is a group, too."""
    graph = nx.DiGraph(imports)
    groups = [sorted(group) for group in nx.strongly_connected_components(graph)]
    return sorted((group for group in groups if len(group) > 1 or group[0] in graph[group[0]]), key=len, reverse=True)


def main() -> None:
    """Print how many imports of own modules there are, and the cycles."""
    own = modules(ROOT / PACKAGE)
    imports = {name: imported(path, own) for name, path in own.items()}
    at_run_time = {name: each.at_run_time for name, each in imports.items()}
    both = {name: each.at_run_time | each.for_typing for name, each in imports.items()}
    number, for_typing = sum(map(len, both.values())), sum(len(each.for_typing) for each in imports.values())
    print(f"{len(own)} modules, {number} imports of one by another, {for_typing} of them for typing only")
    for kind, needs in (("with those for typing", both), ("at run time", at_run_time)):
        groups = cycles(needs)
        print(f"cycles {kind}: {len(groups)}")
        for group in groups:
            print(f"  {len(group)} modules: " + ", ".join(name.removeprefix(f"{PACKAGE}.") for name in group))


if __name__ == "__main__":
    main()
