"""Processor time of tests: what counts for them, and that a session fails where one has outgrown its mark."""

import os
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests import costs as module
from tests.costs import REFERENCE, Costs, slowness, spent

ROOT = Path(__file__).parent.parent
CONFTEST = """
from tests import costs
from tests.costs import Costs

costs.reference_work = lambda: costs.REFERENCE  # as on the machine for which the limit is

def pytest_addoption(parser):
    parser.addoption("--costs")

def pytest_configure(config):
    config.pluginmanager.register(Costs(config, limits={"not long": 0.05}))
"""
TESTS = """
import subprocess, sys, time
import pytest

def work():
    begin = time.process_time()
    while time.process_time() < begin + 0.3:
        pass

@pytest.fixture(scope="module")
def shared():
    work()

def test_cheap():
    time.sleep(0.5)

def test_dear():
    work()

def test_program():
    code = "import time" + chr(10) + "while time.process_time() < 0.35: pass"
    subprocess.run([sys.executable, "-c", code], check=True)

def test_shares(shared):
    pass

@pytest.mark.long
def test_proof():
    work()
"""


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="no /proc, which lists programs that run")
def test_a_program_counts_while_it_runs_and_after_it_has_ended():
    before = spent()
    with subprocess.Popen([sys.executable, "-c", "while True: pass"]) as program:
        while spent() < before + 0.1:
            time.sleep(0.02)
        program.kill()
    assert spent() > before + 0.09


@pytest.mark.parametrize(
    ("chosen", "outgrown"),
    [("not long and not slow", ["dear", "site", "test_slow"]), ("not long", ["dear"]), ("", [])],
)
def test_a_fixture_may_take_ten_times_as_much_and_the_inner_loop_has_less(chosen, outgrown):
    costs = Costs(SimpleNamespace(getoption=lambda _: chosen))
    costs.of_tests = {"test_cheap": 0.6, "test_slow": 3.0}
    costs.of_fixtures = {"site": 35.0, "dear": 95.0}
    assert [name for name, _ in costs.outgrown()] == outgrown


@pytest.mark.parametrize(("seconds", "times"), [(REFERENCE / 2, 1.0), (3 * REFERENCE, 3.0)])
def test_a_slow_machine_has_more_seconds_and_a_fast_machine_has_no_less(monkeypatch, seconds, times):
    monkeypatch.setattr(module, "reference_work", lambda: seconds)
    assert slowness() == pytest.approx(times)


def test_a_test_during_which_the_machine_became_slow_is_not_dear(monkeypatch):
    costs = Costs(SimpleNamespace(getoption=lambda _: "not long"))
    item = SimpleNamespace(user_properties=[])
    with monkeypatch.context() as clocks:  # and not at the end of this test, which is measured itself
        clocks.setattr(module, "spent", lambda: 6.0)
        clocks.setattr(module, "reference_work", lambda: 5 * REFERENCE)
        costs.pytest_runtest_teardown(item)
    assert item.user_properties == [("processor", pytest.approx(1.2)), ("here", 6.0)]


@pytest.mark.parametrize(
    ("here", "text"),
    [
        (4.0, "tests took 4 s of processor of a quiet machine"),
        (10.0, "tests took 4 s of processor of a quiet machine; this machine took 2.5 times as long"),
    ],
)
def test_the_total_says_how_slow_the_machine_was(here, text):
    costs = Costs(SimpleNamespace(getoption=lambda _: "not long"))
    properties = [("processor", 4.0), ("here", here)]
    costs.pytest_runtest_logreport(SimpleNamespace(when="teardown", nodeid="test_some", user_properties=properties))
    lines = []
    costs.pytest_terminal_summary(SimpleNamespace(write_line=lines.append))
    assert lines == [text]


def test_what_outgrows_its_mark_fails_the_session(tmp_path):
    (tmp_path / "conftest.py").write_text(CONFTEST)
    (tmp_path / "test_some.py").write_text(TESTS)
    (tmp_path / "pytest.ini").write_text(f"[pytest]\nmarkers = long: a proof\npythonpath = {ROOT} {tmp_path}\n")
    command = [sys.executable, "-m", "pytest", "-p", "xdist", "-n", "1", "--costs", "costs.csv", "-m", "not long"]
    alone = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    daily = subprocess.run(command, cwd=tmp_path, env=alone, capture_output=True, text=True, check=False)
    assert daily.returncode == pytest.ExitCode.TESTS_FAILED
    assert "4 passed" in daily.stdout
    named = {line.split()[1] for line in daily.stdout.splitlines() if line.startswith("OUTGROWN")}
    assert named == {"test_some.py::test_dear", "test_some.py::test_program"}
    rows = [line.split(",") for line in (tmp_path / "costs.csv").read_text().splitlines()[1:]]
    assert {name for _, name in rows} == {
        *named,
        *(f"test_some.py::{name}" for name in ("shared", "test_cheap", "test_shares")),
    }
    costs = [float(cost) for cost, _ in rows]
    assert costs == sorted(costs, reverse=True)
