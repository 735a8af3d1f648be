"""Parts of the world do not know their whole: what a part needs it is given."""

import ast
from pathlib import Path

import pytest

import desim_warehouse
from tests.trees import tree_of

PACKAGE = Path(desim_warehouse.__file__).parent
MAY_KNOW_THE_WORLD = {"world", "__init__"}
ROBOTS = {"robot", "body", "driver", "other", "member", "ahead", "behind", "front"}
"""What robots, and bodies, are called where others deal with them."""
MOST_FIELDS_SET = 12
"""Five for slots in bays, and seven in the hot path, where a verb costs too much. In 0.2.0 there were 108."""


def classes(folder):
    for path in sorted(folder.rglob("*.py")):
        for node in ast.walk(tree_of(path)):
            if isinstance(node, ast.ClassDef):
                yield path, node


@pytest.mark.slow
def test_no_part_knows_the_world():
    for path, node in classes(PACKAGE / "world"):
        if path.stem in MAY_KNOW_THE_WORLD:
            continue
        names = {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
        names |= {one.attr for one in ast.walk(node) if isinstance(one, ast.Attribute)}
        names |= {one.arg for one in ast.walk(node) if isinstance(one, ast.arg)}
        assert not names & {"World", "world"}, f"{node.name} in {path.name}"


@pytest.mark.slow
def test_no_public_class_name_stands_twice():
    seen = {}
    for path, node in classes(PACKAGE):
        if not node.name.startswith("_"):
            seen.setdefault(node.name, []).append(path.name)
    assert {name: where for name, where in seen.items() if len(where) > 1} == {}


def fields_set(tree):
    """Attributes of robots to which something is assigned, with their lines."""
    for node in ast.walk(tree):
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets:
            for one in target.elts if isinstance(target, ast.Tuple | ast.List) else [target]:
                if isinstance(one, ast.Attribute) and isinstance(one.ctx, ast.Store):
                    owner = one.value
                    name = owner.id if isinstance(owner, ast.Name) else getattr(owner, "attr", "")
                    if name in ROBOTS:
                        yield one.lineno, ast.unparse(one)


def test_what_happens_to_a_robot_is_a_verb_of_the_robot():
    code = "robot.x = 1; a.body.y += 1; robot.z, other.u = 1, 2; robot.v: int = 3; robot.f(robot.x)"
    assert len(list(fields_set(ast.parse(code)))) == 5
    places = [
        f"{path.name}:{line} {target}"
        for path in sorted((PACKAGE / "world").rglob("*.py"))
        if path.stem not in {"body", "robot"}
        for line, target in fields_set(tree_of(path))
    ]
    assert len(places) <= MOST_FIELDS_SET, places


def test_a_folder_is_read_at_a_glance():
    """One command a file in cli, one format in plants; nothing else has more than twenty files."""
    many = {
        folder.relative_to(PACKAGE).as_posix(): len(list(folder.glob("*.py")))
        for folder in [PACKAGE, *PACKAGE.rglob("*")]
        if folder.is_dir() and len(list(folder.glob("*.py"))) > 20
    }
    assert set(many) <= {"cli", "plants"}, many


def blocks_below_code(tree):
    """Count the blocks below the first class or function that have a constant which needs nothing of the module."""
    code, constants = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef), (ast.Assign, ast.AnnAssign)
    own, blocks, was_free = set(), 0, False
    for node in (node for node in tree.body if isinstance(node, code + constants)):
        if isinstance(node, code):
            own.add(node.name)
            was_free = False
            continue
        names = [name for name in ast.walk(node) if isinstance(name, ast.Name)]
        if own & {name.id for name in names if isinstance(name.ctx, ast.Load)}:
            own |= {name.id for name in names if isinstance(name.ctx, ast.Store)}
        elif own:
            blocks += not was_free
            was_free = True
    return blocks


@pytest.mark.slow
def test_constants_stand_above_the_code():
    """Those that need a class or function of the module stand below it; of the others at most one block does."""
    assert blocks_below_code(ast.parse("A = 1\nclass B: ...\nC = B()\n'What it is.'\nD: int = 2\ndef e(): ...")) == 1
    assert blocks_below_code(ast.parse("class A: ...\nB = 1\ndef c(): ...\nD = 2")) == 2
    scattered = {
        path.relative_to(PACKAGE).as_posix(): blocks
        for path in sorted(PACKAGE.rglob("*.py"))
        if (blocks := blocks_below_code(tree_of(path))) > 1
    }
    assert scattered == {}
