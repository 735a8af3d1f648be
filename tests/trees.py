"""Sources as syntax trees, each parsed once for all tests of a process."""

import ast
from functools import cache


@cache
def tree_of(path):
    return ast.parse(path.read_text(encoding="utf-8"))
