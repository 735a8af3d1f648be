"""Planted bugs of policies: each is named with its line of the user's file, or as what no line shows."""

import inspect
import re
import sys
from pathlib import Path

import pytest

import desim_warehouse as dw
from tests.daily import some
from tests.policies.bugs import planted

FILE = Path(planted.__file__)
BUGS = [cls for cls in vars(planted).values() if inspect.isclass(cls) and cls.__module__ == planted.__name__]
KINDS = {
    "assign": "allocation",
    "allocate": "allocation",
    "route": "routing",
    "levels": "charging",
    "choose": "parking",
}
UNREPRODUCIBLE = {"Generated", "GlobalRandom", "Unseeded", "State", "Counted"}
"""Bugs that no line shows: what is named is the policy."""


def test_so_many_are_planted():
    assert len(BUGS) == 33


def line_of(cls):
    source, first = inspect.getsourcelines(cls)
    return first + next(number for number, line in enumerate(source) if line.rstrip().endswith("# bug"))


def forget_policies():
    """Have files of policies read anew, as in a program that has not run yet: classes keep what they counted."""
    for name in [name for name in sys.modules if name.startswith("desim_policies_")]:
        del sys.modules[name]


def told(cls, **study):
    """What a study says of a policy."""
    kind = next(KINDS[name] for name in vars(cls) if name in KINDS)
    forget_policies()
    try:
        changes = {f"policies.{kind}": f"{FILE}:{cls.__name__}", "tasks.goods": {"random": 7}}
        dw.Study("models/multibots.yaml", {"fleet.size": [3]}, changes=changes, **study).run()
    except dw.WarehouseError as error:
        return str(error)
    return ""


@pytest.mark.parametrize(
    "cls", [cls for cls in BUGS if cls.__name__ not in UNREPRODUCIBLE], ids=lambda cls: cls.__name__
)
def test_a_bug_is_named_with_the_user_s_line(cls):
    message = told(cls, timeout=0.3 if cls is planted.Endless else None)
    assert re.search(rf"{re.escape(str(FILE))}, line (\d+)", message)[1] == str(line_of(cls)), message
    assert cls.__name__ in message or cls is planted.Endless
    assert len(message) < 500


@pytest.mark.slow
@pytest.mark.parametrize("name", some(sorted(UNREPRODUCIBLE), 3))
def test_a_policy_that_is_not_reproducible_is_named(name):
    assert f"{FILE}:{name}: not reproducible, two runs with one seed differ" in told(getattr(planted, name))


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("NoneBack", "returned None, expected pairs (robot number, task number)"),
        ("Objects", "expected robot.number, task.number"),
        ("LevelsShare", "full is 1 of 10, so these are shares"),
        ("RouteWeight", "edges have no 'lenght', did you mean 'length'?"),
    ],
)
def test_messages_say_what_to_write(name, hint):
    assert hint in told(getattr(planted, name))


def test_the_contract_finds_what_is_kept_in_a_class():
    from desim_warehouse.contracts import AllocationContract

    class Mine(AllocationContract):
        name = f"{FILE}:State"

        def make(self):
            return planted.State()

    forget_policies()
    with pytest.raises((AssertionError, dw.PolicyError)):
        Mine().test_nothing_is_kept_from_one_run_to_the_next()
