"""Hundreds of hostile inputs: one message, exit status 2, no traceback, below 10 s of processor and 1 GiB."""

import pytest

from tests.cli import hostile
from tests.cli.forks import call_all

SOME = 120
"""Every so many of them every day, all in the long run."""


def wrong_of(calls, folder):
    """Faults of the answers to some calls, by the names of these."""
    done = call_all(list(calls.values()), folder)
    return {name: faults for name, one in zip(calls, done, strict=True) if (faults := one.faults())}


def test_some_of_what_cannot_be_worked_with_is_one_message(tmp_path):
    calls = {}
    for group in hostile.GROUPS:
        (place := tmp_path / group.__name__).mkdir()
        calls |= {(group.__name__, name): call for name, call in list(group(place).items())[::SOME]}
    assert {group for group, _ in calls} == {group.__name__ for group in hostile.GROUPS}
    assert wrong_of(calls, tmp_path) == {}


@pytest.mark.long
@pytest.mark.parametrize("group", hostile.GROUPS, ids=lambda group: group.__name__)
def test_what_cannot_be_worked_with_is_one_message(group, tmp_path):
    assert wrong_of(group(tmp_path), tmp_path) == {}


def test_there_are_hundreds_of_them(tmp_path):
    counts = []
    for group in hostile.GROUPS:
        (place := tmp_path / group.__name__).mkdir()
        counts.append(len(group(place)))
    assert sum(counts) >= 300
