"""Mutants of the package, and which of them the tests catch: the witness that tests may be made fewer.

`python -m tests.mutants record tests/world tests/laws` notes which test runs which function, and how long it takes.
`python -m tests.mutants try --seed 1 --count 200 --under world,outcome,study/statistics` then changes one thing at a
time in a copy of the tree (a comparison, a sign, a number, a condition; a statement left out), and runs the tests that
run the changed function, the fastest first, until one fails. Both by hand; same seed and package, same mutants.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGE = "desim_warehouse"
COVERED = Path(tempfile.gettempdir()) / "desim_covered.json"
OTHER = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.And: ast.Or,
    ast.Or: ast.And,
}
DROPPED = (ast.AugAssign, ast.Raise, ast.Continue, ast.Break)
MEMORY = 4 << 30
"""Bytes that tests of a mutant may use: some of them never end."""


class Sites(ast.NodeVisitor):
    """What can be changed in a module: `changes` are functions that do it, with the line and function of each."""

    def __init__(self) -> None:
        self.found = []
        self.function = 0

    def add(self, node, what, change):
        self.found.append((self.function, node.lineno, what, change))

    def visit_FunctionDef(self, node):
        outer, self.function = self.function, min([node.lineno, *(one.lineno for one in node.decorator_list)])
        for part in (*node.args.defaults, *node.args.kw_defaults, *node.body):
            if part is not None:
                self.visit(part)
        self.function = outer

    def visit_AnnAssign(self, node):
        if node.value is not None:
            self.visit(node.value)

    def visit_Raise(self, node):
        """What a message says is tested where it is printed."""

    def visit_Compare(self, node):
        operator = node.ops[0]
        self.add(node, f"{name(operator)} for {name(OTHER[type(operator)]())}", lambda: swap(node.ops, 0))
        self.generic_visit(node)

    def visit_BoolOp(self, node):
        self.add(node, f"not {name(node.op)}", lambda: setattr(node, "op", OTHER[type(node.op)]()))
        self.generic_visit(node)

    def visit_BinOp(self, node):
        if type(node.op) in OTHER:
            self.add(node, f"not {name(node.op)}", lambda: setattr(node, "op", OTHER[type(node.op)]()))
        self.generic_visit(node)

    def visit_AugAssign(self, node):
        self.visit_BinOp(node)

    def visit_Constant(self, node):
        if type(node.value) in {int, float}:
            self.add(node, f"{node.value} + 1", lambda: setattr(node, "value", node.value + 1))

    def visit_JoinedStr(self, node):
        """What is printed is no number."""

    def visit_If(self, node):
        if ast.unparse(node.test) != "TYPE_CHECKING":
            self.add(node, "negated", lambda: setattr(node, "test", ast.UnaryOp(ast.Not(), node.test)))
            self.generic_visit(node)

    def visit_IfExp(self, node):
        self.visit_If(node)

    def visit_While(self, node):
        self.visit_If(node)

    def generic_visit(self, node):
        for field in ("body", "orelse", "finalbody"):
            body = getattr(node, field, None)
            for rank, one in enumerate(body if isinstance(body, list) else ()):
                self.left_out(body, rank, one)
        super().generic_visit(node)

    def left_out(self, body, rank, one):
        kept = isinstance(one, ast.Assign) and all(isinstance(target, ast.Name) for target in one.targets)
        calls = isinstance(one, ast.Expr) and not isinstance(one.value, ast.Constant)
        if calls or isinstance(one, DROPPED) or (isinstance(one, ast.Assign) and not kept):
            self.add(one, "left out", lambda: body.__setitem__(rank, ast.copy_location(ast.Pass(), one)))


def name(operator):
    return type(operator).__name__


def swap(operators, rank):
    operators[rank] = OTHER[type(operators[rank])]()


def sites(path):
    """A module as a tree, and what can be changed in it."""
    tree = ast.parse((ROOT / path).read_text())
    found = Sites()
    found.visit(tree)
    return tree, found.found


def drawn(under, seed, count):
    """Mutants by place: (module, rank of the change in it)."""
    modules = sorted(
        path.relative_to(ROOT).as_posix()
        for part in under
        for path in [*(ROOT / PACKAGE / part).rglob("*.py"), (ROOT / PACKAGE / part).with_suffix(".py")]
        if path.exists()
    )
    every = [(path, rank) for path in modules for rank in range(len(sites(path)[1]))]
    return sorted(random.Random(seed).sample(every, min(count, len(every))))


class Recorder:
    """Which functions of the package each test runs, and for how long."""

    def __init__(self) -> None:
        self.covered = {}

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item):
        seen = {}

        def called(frame, _event, _argument):
            seen[id(frame.f_code)] = frame.f_code

        begin = time.process_time()
        sys.settrace(called)
        yield
        sys.settrace(None)
        inside = f"{ROOT / PACKAGE}{os.sep}"
        functions = sorted(
            f"{code.co_filename.removeprefix(f'{ROOT}{os.sep}')}:{code.co_firstlineno}"
            for code in seen.values()
            if code.co_filename.startswith(inside)
        )
        self.covered[item.nodeid] = {"time": time.process_time() - begin, "functions": functions}


class Only:
    """Some tests, in a given order."""

    def __init__(self, chosen) -> None:
        self.rank = {test: i for i, test in enumerate(chosen)}

    def pytest_collection_modifyitems(self, items):
        items[:] = sorted((one for one in items if one.nodeid in self.rank), key=lambda one: self.rank[one.nodeid])


QUIET = ["-q", "-p", "no:randomly", "-p", "no:cacheprovider", "-m", "not long"]


def record(arguments):
    recorder = Recorder()
    pytest.main([*QUIET, "--durations=40", *arguments.tests], plugins=[recorder])
    COVERED.write_text(json.dumps(recorder.covered))


def run(arguments):
    """In the copy: one failure is enough."""
    chosen = json.loads(Path(arguments.chosen).read_text())
    files = sorted({test.partition("::")[0] for test in chosen})
    return pytest.main([*QUIET, "-x", "--no-header", "--tb=no", *files], plugins=[Only(chosen)])


def covering(covered, path, function, budget):
    """Tests that run a function (or any of a module, for what stands outside functions), the fastest first."""
    key = f"{path}:{function}" if function else f"{path}:"
    found = [
        (entry["time"], test)
        for test, entry in covered.items()
        if any(one == key if function else one.startswith(key) for one in entry["functions"])
    ]
    chosen, spent = [], 0.0
    for seconds, test in sorted(found):
        spent += seconds
        if spent > budget:
            break
        chosen.append(test)
    return chosen


def outcome(tree, chosen, budget):
    """Whether a mutant is caught."""
    if not chosen:
        return "no test runs it"
    (tree / "chosen.json").write_text(json.dumps(chosen))
    command = [sys.executable, "-m", "tests.mutants", "run", "chosen.json"]
    try:
        found = subprocess.run(
            command,
            cwd=tree,
            env={**os.environ, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"},
            capture_output=True,
            text=True,
            check=False,
            timeout=4 * budget + 60,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)),
        )
    except subprocess.TimeoutExpired:
        return "caught: it never ends"
    if found.returncode == 0:
        return f"SURVIVED {len(chosen)} tests"
    last = [line for line in found.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return f"caught by {last[0].split(' ')[1] if last else found.stdout[-200:]}"


def attempt(arguments):
    """Each mutant with what became of it, a line each; then how many are caught."""
    covered = json.loads(COVERED.read_text())
    caught, mutants = 0, drawn(arguments.under.split(","), arguments.seed, arguments.count)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "tree"
        left = shutil.ignore_patterns(".venv", ".git", ".hypothesis", "*_cache", "__pycache__", "out")
        shutil.copytree(ROOT, copy, ignore=left)
        for path, rank in mutants:
            tree, found = sites(path)
            function, line, what, change = found[rank]
            change()
            (copy / path).write_text(ast.unparse(ast.fix_missing_locations(tree)))
            said = outcome(copy, covering(covered, path, function, arguments.budget), arguments.budget)
            shutil.copy(ROOT / path, copy / path)
            caught += said.startswith("caught")
            print(f"{path}:{line} {what}: {said}", flush=True)  # noqa: T201 - a tool to be read
    print(f"{caught} of {len(mutants)} caught")  # noqa: T201


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(required=True)
    one = commands.add_parser("record")
    one.add_argument("tests", nargs="+")
    one.set_defaults(call=record)
    one = commands.add_parser("try")
    one.add_argument("--seed", type=int, default=1)
    one.add_argument("--count", type=int, default=200)
    one.add_argument("--under", default="world,outcome,study/statistics", help="folders of the package")
    one.add_argument("--budget", type=float, default=60, help="seconds of tests a mutant")
    one.set_defaults(call=attempt)
    one = commands.add_parser("run")
    one.add_argument("chosen")
    one.set_defaults(call=run)
    arguments = parser.parse_args()
    return arguments.call(arguments)


if __name__ == "__main__":
    sys.exit(main())
