"""Hundreds of hostile inputs: one message, exit status 2, no traceback, below 10 s of processor and 1 GiB."""

import pytest

from tests.cli import hostile
from tests.cli.forks import call_all

SOME = 60
"""Every so many of them every day, all in the long run."""


@pytest.mark.parametrize("each", [SOME, pytest.param(1, marks=pytest.mark.long)], ids=["some", "all"])
@pytest.mark.parametrize("group", hostile.GROUPS, ids=lambda group: group.__name__)
def test_what_cannot_be_worked_with_is_one_message(group, each, tmp_path):
    calls = dict(list(group(tmp_path).items())[::each])
    done = call_all(list(calls.values()), tmp_path)
    wrong = {name: faults for name, one in zip(calls, done, strict=True) if (faults := one.faults())}
    assert wrong == {}


def test_there_are_hundreds_of_them(tmp_path):
    counts = []
    for group in hostile.GROUPS:
        (place := tmp_path / group.__name__).mkdir()
        counts.append(len(group(place)))
    assert sum(counts) >= 300
