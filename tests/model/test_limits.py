"""Hostile and odd input: one message each, soon, and without much memory."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks.memory import peak
from desim_warehouse.errors import ModelError
from desim_warehouse.model import load
from desim_warehouse.values.fields import LIMITS

ROOT = Path(__file__).parents[2]
TUTORIAL = ROOT / "models" / "tutorial.yaml"
MULTIBOTS = ROOT / "models" / "multibots.yaml"
HALF = "\ud800"  # of a surrogate pair
SECONDS, MEGABYTES = 10, 1000


def one_message(source, overrides=None):
    start, before = time.process_time(), peak()
    with pytest.raises(ModelError) as refused:
        load(source, overrides)
    assert time.process_time() - start < SECONDS
    assert peak() - before < MEGABYTES
    (line,) = refused.value.problems
    line.encode()
    return line


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        ({"fleet.size": 1e20}, "fleet.size: should be a whole number (got 1e+20)"),
        ({"fleet.size": 10**20}, "fleet.size: too large (got 100000000000000000000), expected at most "),
        ({"fleet.size": 10**400}, "fleet.size: too large (got a number of about 401 digits)"),
        ({"fleet.size": 10**7}, "fleet.size: too large (got 10000000), expected at most 10,000 (robots"),
        ({"fleet.kinds": {"a": {"count": 10**7}}}, "too large (got 10000000), expected at most 10,000 (robots"),
        ({"battery.taper": {"start": 0.5, "end_rate": 1e-17}}, "end_rate: too small (got 1e-17), expected at least "),
        ({"tasks.load_time": 1e308}, "tasks.load_time: too large (got 1e+308), expected at most 1,000,000,000,000"),
        ({"tasks.load_time": 10**400}, "tasks.load_time: too large a number (got a number of about 401 digits)"),
        ({"fleet.robot.speed": 5e-324}, "fleet.robot.speed: too small (got 5e-324), expected at least 1e-09"),
        (
            {"tasks.goods": {"random": 1e8}},
            "should be a whole number (got 100000000.0); write 100000000",
        ),
        (
            {"tasks.goods": {"random": 10**8}},
            "tasks.goods.random: too large (got 100000000), expected at most 1,000,000",
        ),
        ({"tasks.goods": [0] * 1_000_001}, "tasks.goods: too large (got 1000001), expected at most 1,000,000 (tasks"),
        ({"tasks.goods": {"poisson": 1e9}, "run.length": 10}, "tasks.goods.poisson: too large (got 1000000000)"),
        (
            {"tasks.goods": {"poisson": 1e5}, "run.length": 1e9},
            "run.length: too large (got 1388888889), expected at most",
        ),
        ({"layout.blocks.block_depth": 10**9}, "block_depth: too large (got 20000000000), expected at most 1,000,000"),
        ({"layout.bays.charging.places": 10**9}, "places: too large (got 1000000000), expected at most 10,000"),
        ({"name": HALF}, "name: not text (got '\\ud800'), expected characters that can be written in UTF-8"),
        ({"tasks.unload_at": [HALF]}, "should be text that can be written in UTF-8 (got '\\ud800')"),
        ({"policies.charging.level": HALF}, "not text (got '\\ud800')"),
        ({HALF: 1}, "override \\ud800: unknown key, expected "),
        ({"policies.charging": "a\0b"}, "not a name (got 'a\\x00b'), expected no character 0x00"),
        ({"policies.charging": "a\0b.py:C"}, "not a name (got 'a\\x00b.py:C'), expected no character 0x00"),
    ],
    ids=lambda value: str(value)[:40].encode("ascii", "replace").decode() if isinstance(value, dict) else "",
)
def test_values_beyond_the_limits(overrides, said):
    assert said in one_message(MULTIBOTS, overrides)


def test_blocks_of_too_many_nodes():
    assert "too large (got 2000000002), expected at most 100,000 (nodes" in one_message(
        TUTORIAL, {"layout.blocks.columns": 10**9}
    )


@pytest.mark.parametrize("file", ["/dev/zero", "FIFO", "LARGE", "NUL\0", "x" * 5000, "."])
def test_a_table_that_never_ends_or_is_none(file, tmp_path):
    if file == "FIFO":
        file = str(tmp_path / "fifo")
        os.mkfifo(file)
    if file == "LARGE":
        file = str(tmp_path / "large.csv")
        with Path(file).open("wb") as large:
            large.truncate(LIMITS["bytes"][0] + 1)
    said = one_message(TUTORIAL, {"tasks.popularity": {"file": file}})
    assert "tasks.popularity.file: cannot be read (got '" in said
    assert "expected a CSV file" in said


def test_a_model_file_that_never_ends():
    assert one_message("/dev/zero") == "/dev/zero: too large, expected a model file of at most 10,000,000 bytes"


@pytest.mark.parametrize(
    "text",
    ["a: " + "[" * 100_000, "a: " + "{b: [" * 100_000, "\n".join(" " * deep + "a:" for deep in range(2000))],
    ids=["lists", "both", "sections"],
)
def test_deep_nesting(text, tmp_path):
    file = tmp_path / "deep.yaml"
    file.write_text(text)
    assert "too many lists or sections inside one another, expected 30 at most" in one_message(file)


def test_aliases_that_multiply(tmp_path):
    file = tmp_path / "laughs.yaml"
    lines = ["a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"{new}: &{new} [{', '.join([f'*{old}'] * 10)}]" for old, new in zip("abcdef", "bcdefg", strict=True)]
    file.write_text("\n".join(lines))
    assert "too many values, expected 1,000,000 at most" in one_message(file)


def test_the_program_says_so_in_one_line(tmp_path):
    file = tmp_path / "surrogate.yaml"
    file.write_text(TUTORIAL.read_text(encoding="utf-8").replace("name: tutorial", 'name: "\\ud800"'), encoding="utf-8")
    done = subprocess.run(
        [Path(sys.executable).with_name("desim"), "run", file], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "name: not text (got '\\ud800')" in done.stderr
