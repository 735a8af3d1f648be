"""What policies of ours say they read of tasks and batteries is what their code looks at."""

import ast
import inspect
import textwrap

import pytest

from desim_warehouse.policies import catalogue

FIELDS = {"priority", "due"}
"""Of a task: what few policies look at, so that `desim check` says where it is given for nothing."""


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind, names in catalogue.OURS.items() for name in names])
def test_a_policy_names_what_it_reads_of_tasks(kind, name):
    cls = catalogue.find(kind, name)
    tree = ast.parse(textwrap.dedent(inspect.getsource(cls)))
    read = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    assert set(getattr(cls, "reads", ())) == FIELDS & read


@pytest.mark.parametrize(
    ("name", "parameters", "reads"),
    [
        ("threshold", {}, True),
        ("threshold", {"level": 20}, False),
        ("reach-aware", {}, False),
        ("opportunity", {}, False),
        ("four-thresholds", {}, False),
        ("swap", {"time": 60}, False),
        ("swap", {}, False),  # which cannot be made
        ("mine.py:Own", {}, True),  # about which nothing is known
    ],
)
def test_which_charging_policies_look_at_the_threshold(name, parameters, reads):
    assert catalogue.reads_threshold(name, parameters) == reads
