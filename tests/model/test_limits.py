"""Hostile and odd input: one message each, soon, and without much memory."""

import copy
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks.memory import peak
from desim_warehouse.errors import ModelError
from desim_warehouse.model import load
from desim_warehouse.questions.run import simulate
from desim_warehouse.study.reading import read_study
from desim_warehouse.values.fields import LIMITS

pytestmark = pytest.mark.slow
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
    ("overrides", "message"),
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
        ({"tasks.goods": {"random": 1e8}}, "should be a whole number (got 100000000.0); write 100000000"),
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
        ({"name": "\x1b[31mred\x1b]0;title\x07"}, "name: a control character in it (got '\\x1b[31mred"),
        ({"description": "a\x9b2Jb"}, "description: a control character in it (got 'a\\x9b2Jb')"),
        ({"name": "txt.\u202eexe"}, "name: a control character in it (got 'txt.\\u202eexe')"),
        ({"fleet.kinds": {"a\x1bc": {"count": 1}}}, "a control character in it (got 'a\\x1bc')"),
        ({"tasks.popularity": {"file": "NUL\0"}}, "a control character in it (got 'NUL\\x00')"),
        ({"policies.interval": 5e-324}, "policies.interval: too small (got 5e-324), expected at least 1e-09"),
        ({HALF: 1}, "override \\ud800: unknown key, expected "),
        ({"policies.charging": "a\0b"}, "a control character in it (got 'a\\x00b')"),
        ({"policies.charging": "a\0b.py:C"}, "a control character in it (got 'a\\x00b.py:C')"),
    ],
    ids=lambda value: str(value)[:40].encode("ascii", "replace").decode() if isinstance(value, dict) else "",
)
def test_values_beyond_the_limits_are_refused(overrides, message):
    assert message in one_message(MULTIBOTS, overrides)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([1, 10**9], "lines.1: too large (got 1000000000), expected at most 10,000 (lines of an order)"),
        (10**6, "lines: too large (got 1000000), expected at most 10,000 (lines of an order)"),
        ({"discrete": {"values": [1, 20_000]}}, "values.1: too large (got 20000), expected at most 10,000 (lines"),
    ],
)
def test_orders_of_a_billion_lines(lines, message):
    assert message in one_message(
        ROOT / "models" / "gallery" / "goods-to-person.yaml", {"tasks.flows.picks.lines": lines}
    )


def test_pods_on_which_there_are_billions_of_items():
    model = ROOT / "models" / "gallery" / "goods-to-person.yaml"
    changes = {"pods.count": 40, "pods.items": 1_000_000, "pods.per_pod": 900_000}
    assert "pods.per_pod: too large (got 36000000), expected at most 2,000,000 (items on all" in one_message(
        model, changes
    )


def test_blocks_of_too_many_nodes():
    assert "too large (got 2000000002), expected at most 100,000 (nodes" in one_message(
        TUTORIAL, {"layout.blocks.columns": 10**9}
    )


@pytest.mark.parametrize("file", ["/dev/zero", "FIFO", "LARGE", "x" * 5000, "."])
def test_a_table_that_never_ends_or_is_none(file, tmp_path):
    if file == "FIFO":
        file = str(tmp_path / "fifo")
        os.mkfifo(file)
    if file == "LARGE":
        file = str(tmp_path / "large.csv")
        with Path(file).open("wb") as large:
            large.truncate(LIMITS["bytes"][0] + 1)
    message = one_message(TUTORIAL, {"tasks.popularity": {"file": file}})
    assert "tasks.popularity.file: cannot be read (got '" in message
    assert "expected a CSV file" in message


def test_a_model_file_that_never_ends():
    assert one_message("/dev/zero") == "/dev/zero: too large, expected a model file of at most 10,000,000 bytes"


@pytest.mark.parametrize(
    "text",
    ["a: " + "[" * 100_000, "a: " + "{b: [" * 20_000, "\n".join(" " * deep + "a:" for deep in range(2000))],
    ids=["lists", "both", "sections"],
)
def test_a_deeply_nested_file_is_refused(text, tmp_path):
    file = tmp_path / "deep.yaml"
    file.write_text(text)
    assert "too many lists or sections inside one another, expected 30 at most" in one_message(file)


def test_aliases_that_multiply_are_refused(tmp_path):
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


@pytest.mark.parametrize(
    ("overrides", "key", "what"),
    [
        ({"fleet.robot.breakdowns": {"every": 1e-9, "repair": 1e-9}}, "fleet.robot.breakdowns.every", "breakdowns"),
        ({"fleet.robot.breakdowns": {"every": {"uniform": [0, 1e-6]}, "repair": 60}}, "breakdowns.every", "breakdowns"),
        (
            {"fleet.kinds": {"old": {"count": 1, "breakdowns": {"every": 1e-9, "repair": 0}}}},
            "fleet.kinds.old.breakdowns.every",
            "breakdowns",
        ),
        ({"layout.bays.parking.outages": {"every": 1e-9, "repair": 1e-9}}, "bays.parking.outages.every", "outages"),
        ({"people": {"p": {"per_hour": 1e9, "stay": 1}}}, "people.p.per_hour", "visits"),
        ({"calendars": {"c": {"every": 1e-6, "lasts": 5e-7}}, "fleet.hours": "c"}, "calendars.c", "openings"),
        ({"calendars": {"c": {"every": 1, "lasts": 1e-9}}, "fleet.hours": "c"}, "calendars.c.lasts", "openings"),
    ],
)
def test_events_without_end_are_refused(overrides, key, what):
    """In work that ends as well, which has no run.length: each of these ran until somebody stopped it."""
    message = one_message(TUTORIAL, overrides)
    assert key in message
    assert re.search(rf"about \d+ {what}.* in an hour, expected at most 10,000,000; is the unit right\?", message)


def test_the_limit_on_events_is_by_the_length_of_the_run():
    """Three robots, 60 s from one breakdown to the next: 10 million of them in 200 million seconds, and no more."""
    work = {"tasks.goods": {"poisson": 1e-6}, "fleet.robot.breakdowns": {"every": 50, "repair": 10}}
    assert load(TUTORIAL, {**work, "run.length": 2e8}).run.length == 2e8
    error = one_message(TUTORIAL, {**work, "run.length": 2.2e8})
    assert "fleet.robot.breakdowns.every: about 11000000 breakdowns in run.length, expected at most 10,000,000" in error


def test_a_shift_system_of_a_month_with_many_robots_is_within_the_limits():
    shifts = {"open": ["06:00-14:00", "14:30-22:00"], "breaks": [f"{hour:02}:30-{hour:02}:35" for hour in range(6, 22)]}
    over = {"calendars": {"c": shifts}, "fleet.hours": "c", "fleet.size": 3, "run.length": 30 * 86400}
    assert load(TUTORIAL, over).fleet.hours == "c"


def test_schedules_of_work_that_ends_are_limited_like_lists():
    flow = {"from": "storage", "to": "packing", "arrivals": {"schedule": [{"at": 0, "tasks": 600_000}] * 2}}
    content = dict(load(TUTORIAL).content())
    content["tasks"] = {"load_time": 5, "unload_time": 5, "flows": {"lorries": flow}}
    assert "tasks.flows: too large (got 1200000), expected at most 1,000,000 (tasks" in one_message(content)


SQUARE = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [5, 0], "C": [5, 5], "D": [0, 5]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"edge": ["B", "C"], "offset": 2}],
        "bays": {"home": {"at": ["A"], "places": 2}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.3, "speed": 1}},
    "tasks": {"goods": [0], "unload_at": ["D"], "load_time": 5, "unload_time": 5},
}


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sign", [1, -1])
def test_coordinates_of_hundreds_of_digits_are_one_message_and_tiny_ones_are_harmless(axis, sign):
    layout = copy.deepcopy(SQUARE["layout"])
    for value in (5e-324, 1e-300):
        layout["nodes"]["B"][axis] = sign * value
        assert simulate(load({**SQUARE, "layout": layout})).kpis["tasks"] == 1
    layout["nodes"]["B"][axis] = sign * 10**400
    message = one_message({**SQUARE, "layout": layout})
    assert message == f"<mapping>: layout.nodes.B.{axis}: too large a number (got a number of about 401 digits)"


@pytest.mark.parametrize(
    "lines",
    [
        "".join(f"k{i}: {i}\n" for i in range(100_000)),
        "fleet:\n" + "".join(f"  k{i}: {i}\n" for i in range(100_000)),
        "other: [" + "[1, 2], " * 50_000 + "]\n",
    ],
    ids=["keys", "keys-of-a-section", "values-of-one-key"],
)
@pytest.mark.parametrize("reader", [load, read_study], ids=["model", "study"])
def test_a_large_file_of_unknown_keys_is_not_read_to_its_end(lines, reader, tmp_path):
    file = tmp_path / "other.yaml"
    file.write_text("name: something else\n" + lines)
    start = time.process_time()
    with pytest.raises(
        ModelError, match=r"unknown, as are 1,000 values before it; is this another kind of file\?"
    ) as one:
        reader(file)
    assert time.process_time() - start < 1.5
    assert len(one.value.problems) == 1
    assert len(str(one.value)) < 300


def test_a_large_model_is_read_as_before_whatever_its_names(tmp_path):
    file = tmp_path / "large.yaml"
    nodes = "".join(f"    place {n}: [{n % 100}, {n // 100}]\n" for n in range(1_500))
    file.write_text("layout:\n  nodes:\n" + nodes + "fleet: {size: 1}\nfleets: 1\n")
    with pytest.raises(ModelError) as refused:
        load(file)
    assert "fleets: unknown key, did you mean 'fleet'?" in str(refused.value)
