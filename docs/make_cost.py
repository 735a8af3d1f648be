"""What each command costs: the lines that it alone reaches, their tests, its options: `python -m docs.make_cost`.

The table is `docs/dev/cost.md`. A module counts for a command if no other command imports it, directly or through
others, wherever the import stands. With `--check` nothing is written, the exit status is 1 where the table is not up to
date, and small modules with one reader are named: each may be a part of the file that reads it.
"""

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

from benchmarks.imports import imported, modules
from desim_warehouse.cli import COMMANDS
from docs.make_reference import table

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "dev" / "cost.md"
SMALL = 80
"""Lines below which a module with one reader is named."""
_ROUND, _ROUND_REST = 50, 1000
"""Lines are counted in steps of so many, so that the table changes only where much has."""
_TOGETHER = (
    ("import", "export"),
    ("calibrate", "validate", "fit"),
    ("best", "orient"),
    ("plan", "why", "size", "best", "orient"),
)
"""Commands that share much with each other and little with the others: what they reach together and alone."""
_INTRO = f"""# What each command costs

Made by `python -m docs.make_cost`; `make lint` fails where it is not up to date. Lines are those of modules that this
command alone reaches, in steps of {_ROUND}; tests are those that import one of them. What two commands share counts
for neither; some stand together, too. The last row is what no command reaches alone: the model, the world, what comes
out of runs, studies, reports.

"""


def reached(start: str, imports: dict[str, set[str]]) -> set[str]:
    """The modules that one needs, itself and the packages around them included; the root, which names all, is not."""
    seen: set[str] = set()
    waiting = [start]
    while waiting:
        name = waiting.pop()
        if name not in seen and "." in name:
            seen.add(name)
            waiting += [*imports[name], name.rpartition(".")[0]]
    return seen


def lines(path: Path) -> int:
    """The lines of a file."""
    return len(path.read_text(encoding="utf-8").splitlines())


def rows(package: dict[str, Path], imports: dict[str, set[str]]) -> Iterator[list[str]]:
    """A row for each command, and for some together: name, lines, lines of tests, options; and one of what is left."""
    tests = modules(ROOT / "tests")
    of_tests = {name: imported(path, package).at_run_time for name, path in tests.items()}
    reaches = {name: reached(f"desim_warehouse.cli.{module}", imports) for name, (module, _) in COMMANDS.items()}
    shared = {name for name in package if sum(name in mine for mine in reaches.values()) != 1}
    for together in (*((name,) for name in COMMANDS), *_TOGETHER):
        others = set().union(*(mine for name, mine in reaches.items() if name not in together))
        alone = set().union(*(reaches[name] for name in together)) - others
        of_them = {test for test, needs in of_tests.items() if needs & alone}
        options = sum(_options(name) for name in together)
        yield [", ".join(together), _rounded(package, alone), _rounded(tests, of_them), str(options)]
    rest = {test for test, needs in of_tests.items() if needs <= shared}
    yield ["what is left", _rounded(package, shared, _ROUND_REST), _rounded(tests, rest, _ROUND_REST), ""]


def _options(name: str) -> int:
    command = importlib.import_module(f"desim_warehouse.cli.{COMMANDS[name][0]}").command
    return sum(param.param_type_name == "option" for param in command.params)


def _rounded(where: dict[str, Path], names: set[str], step: int = _ROUND) -> str:
    return f"{round(sum(lines(where[name]) for name in names) / step) * step:,}"


def small(package: dict[str, Path], imports: dict[str, set[str]]) -> Iterator[str]:
    """What is said of each small module that one file of its own folder alone imports."""
    for name, path in package.items():
        readers = [reader for reader, needs in imports.items() if name in needs and reader != name]
        near = [reader for reader in readers if package[reader].parent == path.parent]
        if path.name != "__init__.py" and len(readers) == len(near) == 1 and lines(path) < SMALL:
            yield f"{path.relative_to(ROOT)}: {lines(path)} lines, read by {near[0]} alone: may be a part of it"


def main(check: bool) -> int:
    """Write the table, or check it; the exit status."""
    package = modules(ROOT / "desim_warehouse")
    imports = {name: imported(path, package).at_run_time for name, path in package.items()}
    text = _INTRO + table(("command", "lines", "of tests", "options"), rows(package, imports), "lrrr")
    if not check:
        PAGE.write_text(text, encoding="utf-8")
        return 0
    for line in small(package, imports):
        print("warning:", line)
    if not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != text:
        print("docs/dev/cost.md is not up to date: python -m docs.make_cost")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main("--check" in sys.argv[1:]))
