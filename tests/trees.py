"""Sources as syntax trees, each parsed once for all tests of a process."""

import ast
import gc
from functools import cache


@cache
def tree_of(path):
    """The syntax tree of a source, which searches for garbage leave out from then on: it stays."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    gc.freeze()
    return tree
