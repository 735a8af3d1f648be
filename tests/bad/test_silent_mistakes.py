"""Mistakes that a file may hold and still be a model: each is named by `desim check`, in the words beside it.

Each file in silent/ changes some keys of warehouse.yaml there; its first line says what was meant. Three of each kind.
"""

from collections import Counter
from pathlib import Path

import pytest

from desim_warehouse.model import load
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.questions.check import check
from tests.daily import some

HERE = Path(__file__).parent / "silent"
FILES = sorted(HERE.glob("[0-9]*.yaml"))
MEASURED = {"24_warm_up_60"}
"""Whose words have a time to four digits, for which a probe must be whole."""


def findings(changes):
    report = check(load(HERE / "warehouse.yaml", changes))
    return [str(finding).replace(f"{HERE}/", "") for finding in report.findings]


def test_there_are_84_of_28_kinds_in_a_warehouse_that_is_sound():
    assert Counter(Counter(file.stem[:2] for file in FILES).values()) == {3: 28}
    assert findings({}) == []


@pytest.mark.slow  # each measures a robot on the real engine
@pytest.mark.parametrize("file", some(FILES[::-1], 3), ids=lambda file: file.stem)
def test_a_mistake_is_named(file, request):
    if file.stem not in MEASURED:
        request.getfixturevalue("brief_probes")
    expected = file.with_suffix(".txt").read_text(encoding="utf-8").splitlines()
    assert expected
    assert findings(read_yaml(file.read_text(encoding="utf-8"), file.name).data) == expected
