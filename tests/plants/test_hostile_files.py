"""Damaged and hostile files of every format: each is read, or is one message, in little time and memory."""

import json
import random
import subprocess
import sys
from pathlib import Path

import pytest

import desim_warehouse as dw
from desim_warehouse.plants import import_layout
from desim_warehouse.plants.formats import FORMATS
from desim_warehouse.questions.check import check
from tests.daily import some
from tests.plants.damage import SECONDS, damaged, outcome
from tests.plants.drawings import DRAWN

pytestmark = pytest.mark.usefixtures("brief_probes")

MEGABYTES = 1000
"""What reading all hostile files one after the other needs at most."""


def read_by(path):
    """The title of the format that a file is taken for."""
    start = path.read_bytes()[:4096].removeprefix(b"\xef\xbb\xbf").lstrip()
    return next(one.title for one in FORMATS if one.looks(path, start))


def test_every_format_has_a_plant_drawn_for_the_tests(tmp_path):
    pytest.importorskip("ezdxf")
    assert {read_by(draw(tmp_path)) for draw in DRAWN.values()} == {one.title for one in FORMATS}


@pytest.mark.parametrize("name", some(DRAWN, 3))
def test_every_drawn_plant_can_be_checked_and_driven_on(name, tmp_path):
    made = import_layout(DRAWN[name](tmp_path), robots=2)
    for path, text in made.files(tmp_path / "model.yaml").items():
        path.write_text(text)
    model = dw.load(tmp_path / "model.yaml")
    assert model.layout == made.model.layout
    assert not [finding for finding in check(model).findings if finding.level == "error"]
    assert dw.simulate(model.replace({"run.length": 1800, "fleet.start_energy": 0.9})).kpis["tasks"] > 0


@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.parametrize("count", [24, pytest.param(60, marks=pytest.mark.long)])
def test_damaged_files_are_read_or_are_one_message(name, count, tmp_path):
    draw = random.Random(name)
    path = DRAWN[name](tmp_path)
    beside = [one for one in tmp_path.iterdir() if one.is_file()]  # of two tables either may be damaged
    content = {one: one.read_bytes() for one in beside}
    refused = 0
    for number in range(count):
        hit = beside[number % len(beside)]
        hit.write_bytes(damaged(content[hit], draw))
        refused += outcome(path) is not None
        hit.write_bytes(content[hit])
    assert refused > 0
    assert refused < count or name == "excel"  # an archive, whose parts have checksums
    assert outcome(path) is None


@pytest.mark.parametrize("name", some(DRAWN, 2))
def test_a_file_of_another_format_is_one_message_or_known_for_what_it_is(name, tmp_path):
    (tmp_path / "its").mkdir()
    content = DRAWN[name](tmp_path / "its").read_bytes()
    for other, draw in DRAWN.items():
        (tmp_path / other).mkdir()
        path = draw(tmp_path / other)
        path.write_bytes(content)
        outcome(path)


@pytest.mark.long
def test_hostile_files_are_one_message_in_little_time_and_memory(tmp_path):
    command = [sys.executable, "-W", "error", "-m", "tests.plants.hostile_files", str(tmp_path)]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=500, check=False, cwd=Path(__file__).parents[2]
    )
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert (done.returncode, done.stderr) == (0, ""), rows[-1:]
    assert len(rows) > 100
    for name, seconds, megabytes, problems in rows:
        assert seconds < SECONDS, name
        assert megabytes < MEGABYTES, name
        if problems is None:  # what is odd there is put right, and said
            assert any(word in name for word in ("0x10", "1_000", "\u0661")), name
        else:
            assert len(problems) == 1, name
            assert "\n" not in problems[0], name
            assert len(problems[0]) < 3000, name
