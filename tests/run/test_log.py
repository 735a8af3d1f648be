"""Rows of the log are written by its methods alone, and taken apart by nobody but the history."""

import ast
import re
from pathlib import Path

import pytest

import desim_warehouse as dw
from desim_warehouse.outcome.log import Log, LogRow
from tests.trees import tree_of

ROOT = Path(dw.__file__).parent
MAY = {"outcome/history.py", "contracts.py"}
"""The one reader of rows; and where whole logs are compared, no row taken apart."""


def touches_rows(tree):
    """Whether a source, as a syntax tree, reaches for the rows of a log."""
    return any(
        isinstance(node, ast.Attribute)
        and node.attr == "rows"
        and (
            (isinstance(node.value, ast.Name) and node.value.id in ("log", "record"))
            or (isinstance(node.value, ast.Attribute) and node.value.attr in ("log", "record", "_log"))
        )
        for node in ast.walk(tree)
    )


@pytest.mark.parametrize(
    "source",
    [
        "log.rows.append((0.0, 'parked'))",
        "self.log.rows = []",
        "for time, *_ in run.record.rows: pass",
        "log.rows[0][1]",
    ],
)
def test_the_law_sees_what_it_forbids(source):
    assert touches_rows(ast.parse(source))


def test_nobody_but_the_log_and_the_history_reaches_for_its_rows():
    named = (file for file in ROOT.rglob("*.py") if re.search(r"\.\s*rows\b", file.read_text(encoding="utf-8")))
    readers = {file.relative_to(ROOT).as_posix() for file in named if touches_rows(tree_of(file))}
    assert readers == MAY
    assert "rows.append" not in (ROOT / "outcome/history.py").read_text()


def test_moves_written_beyond_the_level_are_left_out_in_the_end():
    log = Log("tasks", knows_moves=True)
    assert (log.moves, Log("tasks").moves, Log("moves").moves) == (True, False, True)
    log.closed(("A", "B"), 3.0, 8.0)
    log.event(1.0, "enter", 0, -1, None, None, edge=("A", "B"))
    log.visit(4, [("A", "B")], 2.0, 9.0)
    log.close(8.5)
    assert [(row.time, row.kind) for row in log.of("enter", "edge_closed", "person_in", "person_out")] == [
        (1, "enter"),
        (2, "person_in"),
        (3, "edge_closed"),
    ]
    log.forget_moves()
    assert [LogRow._make(row)[:2] for row in log.rows] == [(2, "person_in"), (3, "edge_closed"), (8, "edge_opened")]
