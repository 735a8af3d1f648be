"""Mutants of the package, and which of them the tests catch: the witness that tests may be made fewer.

`python -m tests.mutants --seed 1 --count 200 --under world,outcome,study/statistics tests/world tests/laws` notes which
test runs which function, and for how long. Then it changes one thing in a function at a time (a comparison, a sign, a
number, a condition; a statement left out), and runs the tests that run it, the fastest first, until one fails. Each is
tried in a fork, where the code of the function is replaced; what tests start as other programs is not changed. By hand;
same seed and package, same mutants.
"""

from __future__ import annotations

import argparse
import ast
import gc
import json
import os
import random
import resource
import signal
import sys
import tempfile
import threading
import time
from pathlib import Path
from types import CodeType, FunctionType

import pytest

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "desim_warehouse"
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
"""Bytes that tests of a mutant may use beside what is there already: some of them never end."""
PATIENCE = 10
"""Seconds on the clock for each second of processor: some mutants wait for ever, and use none."""


class Sites(ast.NodeVisitor):
    """What can be changed in the functions of a module: the line of each, and a function that changes it."""

    def __init__(self):
        self.found = []
        self.function = 0

    def add(self, node, what, change):
        if self.function:
            self.found.append((self.function, node.lineno, what, change))

    def visit_FunctionDef(self, node):
        outer, self.function = self.function, min([node.lineno, *(one.lineno for one in node.decorator_list)])
        for rank, part in enumerate(node.body):
            self.left_out(node.body, rank, part)
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
    tree = ast.parse((PACKAGE / path).read_text())
    visitor = Sites()
    visitor.visit(tree)
    return tree, visitor.found


def drawn(under, seed, count):
    """Mutants by place: (module, rank of the change in it)."""
    places = [PACKAGE / part for part in under]
    files = [file for place in places for file in (place.rglob("*.py") if place.is_dir() else [place])]
    modules = sorted(file.relative_to(PACKAGE).as_posix() for file in files)
    every = [(path, rank) for path in modules for rank in range(len(sites(path)[1]))]
    return sorted(random.Random(seed).sample(every, min(count, len(every))))


def place_of(path, rank):
    """The place of a mutant, and what is changed."""
    _, line, what, _ = sites(path)[1][rank]
    return f"{path}:{line} {what}"


def codes(code):
    """Code of all functions in it, by qualified name and line."""
    yield (code.co_qualname, code.co_firstlineno), code
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from codes(inner)


def mutate(path, rank):
    """Change one thing in the functions that are in memory."""
    tree, changes = sites(path)
    changes[rank][-1]()
    file = str(PACKAGE / path)
    new = dict(codes(compile(ast.fix_missing_locations(tree), file, "exec")))
    gc.unfreeze()  # what `conftest` keeps is listed no more
    for one in gc.get_objects():
        if isinstance(one, FunctionType) and one.__code__.co_filename == file:
            one.__code__ = new.get((one.__code__.co_qualname, one.__code__.co_firstlineno), one.__code__)


def in_use():
    """Bytes of addresses that this process has, as Linux says."""
    statm = Path("/proc/self/statm")
    return int(statm.read_text().split()[0]) * resource.getpagesize() if statm.exists() else MEMORY


def forked(work, seconds):
    """Return what a function returns in a fork that may use so many seconds of processor; None if it does not end."""
    with tempfile.TemporaryFile() as told:
        child = os.fork()
        if child == 0:
            try:
                signal.alarm(PATIENCE * seconds)
                resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
                resource.setrlimit(resource.RLIMIT_AS, (in_use() + MEMORY, in_use() + MEMORY))
                told.write(json.dumps(work()).encode())
                told.flush()
            finally:
                os._exit(0)
        os.waitpid(child, 0)
        told.seek(0)
        return json.loads(told.read() or "null")


class Tried:
    """Runs tests in forks, in place of pytest's own loop."""

    def __init__(self, arguments):
        self.arguments = arguments
        self.failed = False

    def pytest_runtest_logreport(self, report):
        self.failed = self.failed or report.failed

    def once(self, item):
        """Run a test, and say nothing of it."""
        if item.config.pluginmanager.has_plugin("terminalreporter"):
            item.config.pluginmanager.unregister(name="terminalreporter")
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)

    def functions(self, items):
        """Seconds and functions of each test."""
        return [self.watched(item) for item in items]

    def watched(self, item):
        seen = {}

        def called(frame, _event, _argument):
            seen[id(frame.f_code)] = frame.f_code

        begin = time.process_time()
        threading.settrace(called)  # what a test runs in threads that it starts
        sys.settrace(called)
        self.once(item)
        sys.settrace(None)
        threading.settrace(None)
        inside = f"{PACKAGE}{os.sep}"
        codes = [code for code in seen.values() if code.co_filename.startswith(inside)]
        functions = sorted({f"{code.co_filename.removeprefix(inside)}:{code.co_firstlineno}" for code in codes})
        return time.process_time() - begin, functions

    def pytest_runtestloop(self, session):
        covered = forked(lambda: self.functions(session.items), 24 * 3600)
        print(f"{len(covered)} tests, {sum(one for one, _ in covered):.0f} s while they are watched")  # noqa: T201
        caught, mutants = 0, drawn(self.arguments.under.split(","), self.arguments.seed, self.arguments.count)
        if self.arguments.survived is not None:
            survivors = self.arguments.survived.read_text()
            mutants = [(path, rank) for path, rank in mutants if f"{place_of(path, rank)}: SURVIVED" in survivors]
        for path, rank in mutants:
            key = f"{path}:{sites(path)[1][rank][0]}"
            running = [(seconds, i) for i, (seconds, functions) in enumerate(covered) if key in functions]
            outcome = self.outcome(session.items, self.affordable(sorted(running)), path, rank)
            caught += outcome.startswith("caught")
            print(f"{place_of(path, rank)}: {outcome}", flush=True)  # noqa: T201 - a tool to be read
        print(f"{caught} of {len(mutants)} caught")  # noqa: T201
        return True

    def affordable(self, running):
        chosen, spent = [], 0.0
        for seconds, i in running:
            spent += seconds
            if chosen and spent > self.arguments.budget:
                break
            chosen.append(i)
        return chosen

    def outcome(self, items, chosen, path, rank):
        """What becomes of a mutant."""

        def first_failure():
            mutate(path, rank)
            for i in chosen:
                self.once(items[i])
                if self.failed:
                    return items[i].nodeid
            return ""

        if not chosen:
            return "no test runs it"
        test = forked(first_failure, 2 * self.arguments.budget + 10)
        if test is None:
            return "caught: it never ends"
        return f"caught by {test}" if test else f"SURVIVED {len(chosen)} tests"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tests", nargs="+")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--under", default="world,outcome,study/statistics", help="folders or modules of the package")
    parser.add_argument("--budget", type=int, default=30, help="seconds of tests for each mutant")
    parser.add_argument("--mark", default="not long", help="which of the tests: `long` for the proofs")
    parser.add_argument("--survived", type=Path, help="what an earlier call printed: only mutants that survived there")
    arguments = parser.parse_args()
    quiet = ["--tb=no", "-p", "no:randomly", "-p", "no:cacheprovider", "-m", arguments.mark]
    return pytest.main([*quiet, *arguments.tests], plugins=[Tried(arguments)])


if __name__ == "__main__":
    sys.exit(main())
