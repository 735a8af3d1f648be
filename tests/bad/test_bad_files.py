"""One file for each mistake; beside it, under the same name, the full text of the error."""

from pathlib import Path

import pytest

from desim_warehouse.errors import ModelError
from desim_warehouse.model import load

HERE = Path(__file__).parent
FILES = sorted(HERE.glob("*.yaml"))


def quick_or_slow(file):
    return pytest.param(file, id=file.stem, marks=[pytest.mark.slow] if file.stem == "beyond_the_limits" else [])


@pytest.mark.parametrize("file", [*map(quick_or_slow, FILES)])
def test_a_bad_file_is_refused_with_all_its_problems(file, monkeypatch):
    monkeypatch.chdir(HERE)
    with pytest.raises(ModelError) as refused:
        load(file.name)
    assert str(refused.value) + "\n" == file.with_suffix(".txt").read_text(encoding="utf-8")


def test_every_message_belongs_to_a_file():
    assert {file.stem for file in HERE.glob("*.txt")} == {file.stem for file in FILES}
