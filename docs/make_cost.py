"""What each feature costs: the lines that nothing else reaches, their tests, its options: `python -m docs.make_cost`.

The table is `docs/dev/cost.md`. `FEATURES` names each feature with its doors: the modules through which the rest of the
package comes to it. Its lines are those of the doors, and of what cannot be reached with the doors shut; imports inside
functions count. A feature within another counts for itself alone, so each module is in one row, and the rows add up.

With `--check` nothing is written. The exit status is 1 where a row is missing, the rows do not add up, or one is no
longer nearly true; and small modules with one reader are named: each may be a part of the file that reads it.
"""

import ast
import importlib
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import desim_warehouse
from benchmarks.imports import imported, imports_in, modules
from desim_warehouse.cli import COMMANDS
from docs.make_reference import table

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "dev" / "cost.md"
PACKAGE = "desim_warehouse"
SMALL = 80
"""Lines below which a module with one reader is named."""
NEARLY = (50, 0.1)
"""By how much a row may be off before the table is to be made anew: lines, or a share of them if that is more."""
TOTAL = "all"


class Feature(NamedTuple):
    """Commands of a feature, and its doors: modules or packages, by their names within the package."""

    doors: tuple[str, ...]
    commands: tuple[str, ...] = ()


FEATURES = {
    "a first model": Feature(("draft", "working_day"), ("new",)),
    "a run": Feature((), ("run",)),
    "the replay": Feature(("replay",), ("replay",)),
    "reports": Feature(("report",), ("report",)),
    "figures": Feature(("plot",), ("draw",)),
    "layouts of other programs": Feature(("plants", "report.export"), ("import", "export")),
    "orders of a WMS or ERP": Feature(("orders",), ("orders",)),
    "check and the quick estimate": Feature(
        ("feasibility", "run.quick", "run.probe", "run.backlog", "questions.check"), ("check",)
    ),
    "likely mistakes in a model": Feature(("feasibility.mistakes",)),
    "the live page": Feature(("live",), ("serve",)),
    "studies": Feature(("questions.study", "study.study", "study.results"), ("study", "what-if", "compare")),
    "plan of a fleet": Feature(("questions.plan", "study.fleet"), ("plan",)),
    "plan with several offers": Feature(("questions.plan.options", "study.fleet.options")),
    "tipping points of a plan": Feature(("questions.tipping",)),
    "why": Feature(("questions.why", "study.held_up", "study.suspects"), ("why",)),
    "best design, one-way lanes": Feature(("questions.best", "questions.orient", "study.designs"), ("best", "orient")),
    "size": Feature(("questions.size", "study.procedures"), ("size",)),
    "logs of real fleets": Feature(("fleet_log", "report.validation_page", "plot.days"), ("calibrate", "validate")),
    "fitted distributions": Feature(("study.fit",), ("fit",)),
    "warm-up": Feature(("study.warm_up",), ("warm-up",)),
    "the paper's cells": Feature(("report.paper",), ("paper",)),
    "lists for editors": Feature((), ("policies", "schema")),
    "completion of commands": Feature(("cli.completion",)),
    "decisions from outside": Feature(("learn", "contracts")),
    "runs on a cluster": Feature(("study.execution.cluster",)),
    "runs kept for other studies": Feature(("study.execution.cache",)),
    "pods": Feature(
        ("world.orders.pods", "feasibility.pods", "model.sections.pods", "model.sections.lines", "policies.pods")
    ),
    "two-way lanes": Feature(
        ("world.traffic.avoidance", "world.traffic.home_plan", "layout.way_home", "layout.turnable", "layout.turning")
    ),
    "people and closures": Feature(
        (
            "world.traffic.people",
            "world.traffic.closures",
            "world.encounters",
            "world.places.cut_off",
            "feasibility.closures",
        )
    ),
    "zones": Feature(("world.traffic.zones", "layout.zones")),
    "lifts": Feature(("layout.lifts", "layout.shafts", "model.facts.lifts", "world.traffic.lift")),
    "wide aisles": Feature(("layout.aisles", "world.robots.aside", "world.traffic.wide")),
    "people who pick": Feature(("layout.walking", "model.sections.pickers", "world.places.pickers")),
}
_INTRO = """# What each feature costs

Made by `python -m docs.make_cost`; `make lint` fails where the rows do not add up, or one is off by more than a tenth
and 50 lines. Lines are those of modules that nothing but this feature reaches. What several features need is in the
last rows, by package: the model, the world, what comes out of runs. A file of tests counts for a feature if it imports
or calls from Python no other. The rest stand with the package that they mirror, and those of the whole in the row
*laws, pages, docs*. Options are those of the feature's commands.

"""
_WHOLE = "laws, pages, docs"


class Row(NamedTuple):
    """A row of the table: lines of the package, lines of tests, options of commands."""

    lines: int
    of_tests: int
    options: int


def reached(starts: Iterable[str], imports: dict[str, set[str]], shut: frozenset[str] = frozenset()) -> set[str]:
    """The modules that some need, these and the packages around them included, without what is shut and the root."""
    seen: set[str] = set()
    waiting = list(starts)
    while waiting:
        name = waiting.pop()
        if name not in seen and name not in shut and "." in name:
            seen.add(name)
            waiting += [*imports[name], name.rpartition(".")[0]]
    return seen


def lines(path: Path) -> int:
    """The lines of a file."""
    return len(path.read_text(encoding="utf-8").splitlines())


def doors(feature: Feature, package: Iterable[str]) -> frozenset[str]:
    """The modules through which the rest of the package comes to a feature; KeyError for a door that is no module."""
    within = [*feature.doors, *(f"cli.{COMMANDS[command][0]}" for command in feature.commands)]
    names = [f"{PACKAGE}.{door}" for door in within]
    if strange := [name for name in names if name not in package]:
        raise KeyError(*strange)
    return frozenset(name for name in package if any(f"{name}.".startswith(f"{door}.") for door in names))


def features(imports: dict[str, set[str]]) -> dict[str, set[str]]:
    """The modules of each feature, none of them in two: of features that hold a module the smallest has it."""
    used = set().union(*imports.values())
    public = {f"{PACKAGE}.{home}" for home in desim_warehouse._HOME}  # noqa: SLF001 - the one list of public names
    roots = public | {f"{PACKAGE}.cli.{module}" for module, _ in COMMANDS.values()} | (imports.keys() - used)
    every = reached(roots, imports)
    alone = {}
    for name, feature in FEATURES.items():
        shut = doors(feature, imports)
        alone[name] = (every - reached(roots - shut, imports, shut)) | shut
    taken: set[str] = set()
    for name in sorted(alone, key=lambda name: len(alone[name])):
        alone[name] -= taken
        taken |= alone[name]
    return alone


def needed_by_tests(path: Path, package: dict[str, Path]) -> set[str]:
    """The modules that a file of tests imports, or calls as `dw.plan`."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    called = {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "dw"
    }
    homes = desim_warehouse._MODULE_OF  # noqa: SLF001 - the one list of public names
    names = {desim_warehouse._CALLED.get(name, name) for name in called}  # noqa: SLF001
    return imports_in(tree, package).at_run_time | {f"{PACKAGE}.{homes[name]}" for name in names if name in homes}


def rows(package: dict[str, Path], imports: dict[str, set[str]]) -> dict[str, Row]:
    """Each feature, the dearest first, then each package without them, then all."""
    tests, of_feature = modules(ROOT / "tests"), features(imports)
    row_of = {module: name for name, parts in of_feature.items() for module in parts}
    size: Counter[str] = Counter()
    for module, path in package.items():
        size[row_of.get(module, _folder(module))] += lines(path)
    of_tests: Counter[str] = Counter()
    for module, path in tests.items():
        mine = {row_of[need] for need in needed_by_tests(path, package) if need in row_of}
        folder = _folder(module)
        rest = folder if folder in size else _WHOLE
        of_tests[mine.pop() if len(mine) == 1 else rest] += lines(path)
    dearest = sorted(FEATURES, key=lambda name: -size[name])
    rest = sorted({*size, *of_tests} - {_WHOLE, *FEATURES})
    every = {name: Row(size[name], of_tests[name], _options(name)) for name in (*dearest, *rest, _WHOLE)}
    return {**every, TOTAL: Row(*map(sum, zip(*every.values(), strict=True)))}


def _folder(module: str) -> str:
    """The package or folder of tests in which a module stands; `(root)` for one beside them."""
    _, *parts = module.split(".")
    return parts[0] if len(parts) > 1 or (parts and (ROOT / PACKAGE / parts[0]).is_dir()) else "(root)"


def _options(name: str) -> int:
    commands = FEATURES[name].commands if name in FEATURES else ()
    called = [importlib.import_module(f"{PACKAGE}.cli.{COMMANDS[command][0]}").command for command in commands]
    return sum(param.param_type_name == "option" for command in called for param in command.params)


def small(package: dict[str, Path], imports: dict[str, set[str]]) -> Iterator[str]:
    """What is said of each small module that one file of its own folder alone imports."""
    for name, path in package.items():
        readers = [reader for reader, needs in imports.items() if name in needs and reader != name]
        near = [reader for reader in readers if package[reader].parent == path.parent]
        if path.name != "__init__.py" and len(readers) == len(near) == 1 and lines(path) < SMALL:
            yield f"{path.relative_to(ROOT)}: {lines(path)} lines, read by {near[0]} alone: may be a part of it"


def written(page: str) -> dict[str, Row]:
    """The rows of a page."""
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in page.splitlines() if line[:1] == "|"]
    return {name: Row(*(int(cell.replace(",", "")) for cell in numbers)) for name, *numbers in cells[2:]}


def stale(page: dict[str, Row], now: dict[str, Row]) -> list[str]:
    """What is wrong with the rows of a page: they are not those of now, are not nearly true, or do not add up."""
    if page.keys() != now.keys():
        return [f"rows: {', '.join(sorted(page.keys() ^ now.keys()))}"]
    sums = Row(*map(sum, zip(*(row for name, row in page.items() if name != TOTAL), strict=True)))
    wrong = [] if sums == page[TOTAL] else [f"{TOTAL}: the rows add up to {sums}"]
    least, share = NEARLY
    for name, row in now.items():
        off = [abs(a - b) > max(least, share * b) for a, b in zip(page[name][:2], row[:2], strict=True)]
        if any(off) or page[name].options != row.options:
            wrong.append(f"{name}: {row} now")
    return wrong


def main(check: bool) -> int:
    """Write the table, or check it; the exit status."""
    package = modules(ROOT / PACKAGE)
    imports = {name: imported(path, package).at_run_time for name, path in package.items()}
    now = rows(package, imports)
    if not check:
        cells = [[name, *(f"{number:,}" for number in row)] for name, row in now.items()]
        PAGE.write_text(_INTRO + table(("feature", "lines", "of tests", "options"), cells, "lrrr"), encoding="utf-8")
        return 0
    for line in small(package, imports):
        print("warning:", line)
    wrong = stale(written(PAGE.read_text(encoding="utf-8")), now)
    for line in wrong:
        print(f"docs/dev/cost.md: {line}: python -m docs.make_cost")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main("--check" in sys.argv[1:]))
