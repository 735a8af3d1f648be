"""Digests of functions: equal where the same is computed, in any process, and other where anything has changed."""

import subprocess
import sys
import threading
from types import ModuleType

import pytest

from desim_warehouse.study.execution.content import digest_of

SOURCE = """
import functools, operator
import numpy as np

PRICES = {"metre": 2.0}

def cost(distance):
    return distance * PRICES["metre"]

def measure(run, factor=2, *, share=0.5):
    return sum(cost(x) * factor for x in (run.T, run.S)) + share * (run.model.name in {"one", "two", "three"})

def factorial(number):
    return number * factorial(number - 1) if number else 1

@functools.cache
def known(number):
    return number + 1

def by_known(run):
    return known(run.S)

class Weight:
    least = 0.0
    def __init__(self, weight):
        self.weight = weight
    def __call__(self, run):
        return max(self.least, self.weight * run.T)
    @staticmethod
    def twice(run):
        return 2 * run.T

class Heavy(Weight):
    def __call__(self, run):
        return super().__call__(run) ** 2

def held(values):
    return lambda run: values[len(values) // 2] * run.T
"""
FORMS = [
    "measure",
    "functools.partial(measure, factor=3)",
    "operator.attrgetter('T')",
    "factorial",
    "by_known",
    "Weight(3)",
    "Weight(3).__call__",
    "Weight.twice",
    "Heavy(3)",
    "held(np.ones(3000))",
    "held({'b': {'x', 'y', 'z'}})",
    "lambda run: [known(n) for n in range(run.S)]",
    "np.mean",
]


def made(form, source=SOURCE):
    """What a module of a user's has for a form."""
    module = ModuleType("user")
    exec(source, vars(module))  # noqa: S102 - our own
    return eval(form, vars(module))  # noqa: S307 - our own


@pytest.mark.parametrize("form", FORMS)
def test_a_function_that_is_defined_again_is_the_same(form):
    assert digest_of(made(form)) == digest_of(made(form))


@pytest.mark.slow
def test_it_is_the_same_in_another_process():
    """Where sets have another order."""
    text = f"from tests.study.test_content import *; print([digest_of(made(form)) for form in {FORMS!r}])"
    other = subprocess.run(
        [sys.executable, "-c", text], env={"PYTHONHASHSEED": "7"}, capture_output=True, check=True, text=True
    )
    assert other.stdout == f"{[digest_of(made(form)) for form in FORMS]}\n"


@pytest.mark.parametrize(
    ("form", "before", "after"),
    [
        ("measure", "+ share", "- share"),
        ("measure", "cost(x) * factor", "cost(x) + factor"),
        ("measure", "factor=2", "factor=3"),
        ("measure", "share=0.5", "share=0.6"),
        ("measure", '"three"', '"four"'),
        ("measure", "return distance *", "return distance +"),
        ("measure", "2.0", "2.5"),
        ("functools.partial(measure)", "2.0", "2.5"),
        ("factorial", "* factorial", "+ factorial"),
        ("by_known", "number + 1", "number + 2"),
        ("Weight(3)", "self.weight *", "self.weight +"),
        ("Weight(3)", "least = 0.0", "least = 1.0"),
        ("Heavy(3)", "self.weight *", "self.weight +"),
        ("Weight.twice", "2 * run.T", "3 * run.T"),
        ("lambda run: Weight.twice(run)", "2 * run.T", "3 * run.T"),
        ("held(np.ones(3))", "// 2", "// 3"),
    ],
)
def test_a_change_of_what_it_uses_is_another_function(form, before, after):
    assert before in SOURCE
    assert digest_of(made(form)) != digest_of(made(form, SOURCE.replace(before, after)))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("functools.partial(measure, factor=1)", "functools.partial(measure, factor=1000)"),
        ("functools.partial(measure)", "functools.partial(cost)"),
        ("operator.attrgetter('T')", "operator.attrgetter('S')"),
        ("Weight(1)", "Weight(1000)"),
        ("Weight(1).__call__", "Weight(1000).__call__"),
        ("Weight(1)", "Heavy(1)"),
        # numpy and others show the middle of large values as ...
        ("held(np.ones(3000))", "held(np.r_[np.ones(1000), np.full(1000, 5.0), np.ones(1000)])"),
        ("held(1)", "held(True)"),
        ("held('1')", "held(b'1')"),
        ("np.mean", "np.median"),
    ],
)
def test_other_arguments_make_another_function(one, other):
    assert digest_of(made(one)) != digest_of(made(other))


HELPERS = """
import user

def mean(values):
    return sum(values) / len(values)

def most(values):
    return max(values)
"""
USER = """
import helpers

def measure(run):
    return helpers.mean(run.robots["distance"])
"""


@pytest.fixture
def with_helpers(monkeypatch):
    """Returns a function that imports a module of the user's, of other content each time, and one that uses it."""

    def measure_with(helpers, user=USER):
        monkeypatch.setitem(sys.modules, "user", ModuleType("user"))
        monkeypatch.setitem(sys.modules, "helpers", ModuleType("helpers"))
        exec(helpers, vars(sys.modules["helpers"]))  # noqa: S102 - our own
        return made("measure", user)

    return measure_with


def test_of_a_module_of_the_user_s_own_what_is_used_counts(with_helpers):
    before = digest_of(with_helpers(HELPERS))
    assert digest_of(with_helpers(HELPERS)) == before
    assert digest_of(with_helpers(HELPERS.replace("max(", "min("))) == before
    assert digest_of(with_helpers(HELPERS.replace("sum(", "len("))) != before


def test_what_nobody_can_look_into_equals_nothing(with_helpers):
    unknown = [
        made("lambda run, lock=lock: run.T", "import threading\nlock = threading.Lock()"),
        made("lambda run: lock.locked()", "import threading\nlock = threading.Lock()"),
        made("held(n for n in range(3))"),
        made("one", "class One:\n    def __reduce__(self):\n        return 'one'\none = One()"),
        with_helpers(HELPERS, "import helpers\ndef measure(run):\n    return getattr(helpers, 'mean')(run.robots)"),
        with_helpers(HELPERS, "def measure(run):\n    from helpers import mean\n    return mean(run.robots)"),
        threading.Lock().acquire,
    ]
    unknown.append([unknown])
    assert len({digest_of(value) for value in unknown * 2}) == 2 * len(unknown)


CLASSES = """
import abc, functools, typing

class Abstract(abc.ABC):
    def measure(self, run):
        return run.T

class Kept:
    @functools.cached_property
    def weight(self):
        return 2.0

class Form(typing.Protocol):
    def measure(self, run): ...

def times(self, factor, run):
    return factor * run.T

class Times:
    __call__ = functools.partialmethod(times, 2)
"""


@pytest.mark.parametrize(
    ("form", "before", "after"),
    [
        ("Abstract()", "run.T", "run.S"),
        ("Kept()", "2.0", "3.0"),
        ("Form", "run)", "run, seed)"),
        ("Times()", "times, 2", "times, 3"),
    ],
)
def test_classes_count_by_their_methods_of_whatever_kind(form, before, after):
    assert digest_of(made(form, CLASSES)) == digest_of(made(form, CLASSES))
    assert digest_of(made(form, CLASSES)) != digest_of(made(form, CLASSES.replace(before, after)))


def test_what_is_installed_counts_by_its_name():
    text = "import numpy as np\ndef measure(run):\n    import scipy.stats\n    return np.random.default_rng(run.seed)"
    assert digest_of(made("measure", text)) == digest_of(made("measure", text))
