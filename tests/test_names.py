"""Names and docstrings say by themselves what they are about: counted for each file, and no count may grow.

After a count fell, `python -m tests.test_names` writes the counts anew.
"""

import ast
import json
import operator
import re
from pathlib import Path

import desim_warehouse
from tests.trees import tree_of

PACKAGE = Path(desim_warehouse.__file__).parent
COUNTS = Path(__file__).parent / "golden" / "vague.json"
VAGUE = {"found", "said", "known", "there", "given", "told", "one", "at", "of", "to", "so"}
"""Names that fit anything: a search for what is meant does not find them."""
LEANING = re.compile(r"^(The same|What|Who|Those|That)\b|\b(that of|those of|of which|of whom|whoever)\b")
"""Words by which a first sentence leans on another text, or on a pronoun."""


def vague_names(tree):
    """The vague names that are assigned, or are parameters."""
    names = [node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)]
    names += [node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)]
    return [name for name in names if name in VAGUE]


def openings(tree):
    """The first paragraph of each docstring."""
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    texts = [ast.get_docstring(node) for node in ast.walk(tree) if isinstance(node, kinds)]
    return [text.partition("\n\n")[0].replace("\n", " ") for text in texts if text]


def leaning(tree):
    """The first sentences that lean on a pronoun or on another docstring."""
    return [text for text in openings(tree) if LEANING.search(text.partition(". ")[0])]


def counts():
    """For each file of the package with any: its vague names and its leaning docstrings."""
    counted = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        tree = tree_of(path)
        pair = [len(vague_names(tree)), len(leaning(tree))]
        if any(pair):
            counted[path.relative_to(PACKAGE).as_posix()] = pair
    return counted


def hidden(tree):
    """The names of the module that a comprehension hides by a name of its own."""
    own = {node.name for node in tree.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    imports = [node for node in tree.body if isinstance(node, (ast.Import, ast.ImportFrom))]
    own |= {(alias.asname or alias.name).partition(".")[0] for node in imports for alias in node.names}
    targets = [node.target for node in ast.walk(tree) if isinstance(node, ast.comprehension)]
    return [name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name) and name.id in own]


def test_vague_names_and_leaning_docstrings_are_recognised():
    code = 'def f(one):\n    """The same of robots."""\n    found, robots = 1, 2\n    return [of for of in robots]'
    tree = ast.parse(code)
    assert sorted(vague_names(tree)) == ["found", "of", "one"]
    assert leaning(tree) == ["The same of robots."]
    assert leaning(ast.parse('"""Return the robots of a kind."""')) == []


def test_no_file_has_more_vague_names_or_leaning_docstrings_than_before():
    kept, now = json.loads(COUNTS.read_text("utf-8")), counts()
    grown = {file: pair for file, pair in now.items() if any(map(operator.gt, pair, kept.get(file, [0, 0])))}
    assert grown == {}, f"more than in {COUNTS.name}: name them by what they are"


def test_no_comprehension_hides_a_function_or_a_module():
    """Python 3.12.1 inlines comprehensions, and loses a global that one of them hides (`UnboundLocalError`)."""
    assert hidden(ast.parse("from a import one\n\ndef f(ones):\n    return [one for one in ones]")) == ["one"]
    names = {path: hidden(tree_of(path)) for path in sorted(PACKAGE.rglob("*.py"))}
    assert {path: hides for path, hides in names.items() if hides} == {}


if __name__ == "__main__":
    COUNTS.write_text(json.dumps(counts(), indent=1) + "\n", "utf-8")
