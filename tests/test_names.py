"""Names and docstrings say by themselves what they are about."""

import ast
import re
from pathlib import Path

import desim_warehouse
from tests.trees import tree_of

PACKAGE = Path(desim_warehouse.__file__).parent
EMPTY = {"found", "said", "known"}
"""Names that say how something was come by, and not what it is."""
VAGUE = EMPTY | {"there", "given", "told", "one"}
"""Names that fit anything: a search for what is meant does not find them."""
PREPOSITIONS = {"at", "of", "to", "so"}
"""Names that are as vague unless they are fields, which are read with their object: `window.at`."""
LEANING = re.compile(r"^(The same|What(?!-if)|Who|Those|That)\b|\b(that of|those of|of which|of whom|whoever)\b")
"""Words by which a first sentence leans on another text, or on a pronoun."""


def vague_names(tree):
    """The vague names that are assigned, or are parameters."""
    names = [node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)]
    names += [node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)]
    for field in fields(tree):
        names.remove(field)
    return [name for name in names if name in VAGUE | PREPOSITIONS] + [name for name in fields(tree) if name in VAGUE]


def fields(tree):
    """The names that bodies of classes declare with a type."""
    bodies = [node.body for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    declared = [part.target for body in bodies for part in body if isinstance(part, ast.AnnAssign)]
    return [target.id for target in declared if isinstance(target, ast.Name)]


def openings(tree):
    """The first paragraph of each docstring."""
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    texts = [ast.get_docstring(node) for node in ast.walk(tree) if isinstance(node, kinds)]
    return [text.partition("\n\n")[0].replace("\n", " ") for text in texts if text]


def leaning(tree):
    """The first sentences that lean on a pronoun or on another docstring."""
    return [text for text in openings(tree) if LEANING.search(text.partition(". ")[0])]


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


def test_fields_may_be_prepositions_as_they_are_read_with_their_object():
    assert vague_names(ast.parse("class Window:\n    at: float\n    found: float\n    of = 1")) == ["of", "found"]


def test_no_name_of_the_package_is_vague():
    names = {path.relative_to(PACKAGE).as_posix(): vague_names(tree_of(path)) for path in PACKAGE.rglob("*.py")}
    assert {path: vague for path, vague in names.items() if vague} == {}, "name them by what they are"


def test_no_variable_of_tests_and_scripts_is_called_by_how_it_was_come_by():
    root = Path(__file__).parents[1]
    paths = [path for folder in ("tests", "benchmarks", "docs", "studies") for path in (root / folder).rglob("*.py")]
    names = {path.relative_to(root).as_posix(): EMPTY.intersection(vague_names(tree_of(path))) for path in paths}
    assert {path: empty for path, empty in names.items() if empty} == {}, "name them by what they are"


def test_no_docstring_of_the_package_leans_on_another_text():
    texts = {path.relative_to(PACKAGE).as_posix(): leaning(tree_of(path)) for path in PACKAGE.rglob("*.py")}
    assert {path: leans for path, leans in texts.items() if leans} == {}, "repeat the noun"


def test_no_comprehension_hides_a_function_or_a_module():
    """Python 3.12.1 inlines comprehensions, and loses a global that one of them hides (`UnboundLocalError`)."""
    assert hidden(ast.parse("from a import one\n\ndef f(ones):\n    return [one for one in ones]")) == ["one"]
    names = {path: hidden(tree_of(path)) for path in sorted(PACKAGE.rglob("*.py"))}
    assert {path: hides for path, hides in names.items() if hides} == {}
