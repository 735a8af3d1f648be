"""Parts of the world do not know their whole: what a part needs it is given."""

import ast
from pathlib import Path

import desim_warehouse

PACKAGE = Path(desim_warehouse.__file__).parent
MAY_KNOW_THE_WORLD = {"robot", "world", "__init__"}


def classes(folder):
    for path in sorted(folder.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                yield path, node


def test_only_robots_know_the_world():
    for path, node in classes(PACKAGE / "world"):
        if path.stem in MAY_KNOW_THE_WORLD:
            continue
        names = {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
        names |= {one.attr for one in ast.walk(node) if isinstance(one, ast.Attribute)}
        names |= {one.arg for one in ast.walk(node) if isinstance(one, ast.arg)}
        assert not names & {"World", "world"}, f"{node.name} in {path.name}"


def test_no_public_class_name_stands_twice():
    seen = {}
    for path, node in classes(PACKAGE):
        if not node.name.startswith("_"):
            seen.setdefault(node.name, []).append(path.name)
    assert {name: where for name, where in seen.items() if len(where) > 1} == {}
