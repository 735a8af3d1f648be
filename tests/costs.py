"""What does each test cost? Processor time, with the programs and browsers that it starts; none may outgrow its mark.

A test without the mark `long` takes at most a second of processor, one of the inner loop, without `slow`, half of that.
A session in which one takes more than `LENIENCY` times as much fails, and names it. Over a second it is a proof, to be
marked so, with a small twin for every day. The clock has no say, so a busy machine changes little. A fixture that tests
share counts for none of them, as they run in random order; it may take ten times as much. `python -m pytest --costs
build/costs.csv tests/world` writes the costs down.
"""

import csv
import io
import math
import os
import statistics
import time
from pathlib import Path

import pytest
import simpy

LIMITS = {"not slow": 0.5, "not long": 1.0}
"""Seconds of processor that a test may take where tests with a mark are left out; the first that holds."""
SHARED = 10
"""How many times as much a fixture may take that tests share: a site, a study."""
LENIENCY = 4.0
"""By what factor a test may exceed its limit, as caches that others use slow down some tests more than others."""
REFERENCE = 0.0042
"""Seconds of processor that `reference_work` takes on the machine for which the limits were set, when it is quiet."""
EVERY = 30.0
"""Seconds between two looks at how slow this machine is."""
_PROCESSES = "/proc"


def spent():
    """Seconds of processor of this process and of all that it started; of what still runs, where /proc lists that."""
    return sum(os.times()[:4]) + sum(map(_of_running, _children(f"{_PROCESSES}/self")))


def _children(process):
    """Numbers of the processes that a process started and that still run; a browser has a hundred threads to ask."""
    try:
        with os.scandir(f"{process}/task") as threads:
            return [pid for thread in threads for pid in _content(f"{thread.path}/children").split()]
    except OSError:  # it has just ended, or the system has no such files
        return []


def _of_running(pid):
    process = f"{_PROCESSES}/{int(pid)}"
    of_children = sum(map(_of_running, _children(process)))
    try:
        fields = _content(f"{process}/stat").rpartition(b")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK") + of_children


def _content(path):
    """Bytes of a small file, without the layers of text, which would cost several times as much."""
    with io.FileIO(path) as file:
        return file.read()


def reference_work():
    """Run a fixed piece of simulation, 4,000 timeouts of 200 processes, and return its seconds of processor."""
    begin = time.process_time()
    world = simpy.Environment()

    def clock(period):
        for _ in range(20):
            yield world.timeout(period)

    for number in range(200):
        world.process(clock(1 + number / 200))
    world.run()
    return time.process_time() - begin


def slowness():
    """How many times as long this machine takes now as the machine for which the limits were set; at least 1."""
    return max(1.0, statistics.median(reference_work() for _ in range(5)) / REFERENCE)


class Costs:
    """Measures where tests run, and judges in the process that reports them."""

    def __init__(self, config, limits=LIMITS):
        self.config = config
        chosen = config.getoption("markexpr")
        self.limit = next((seconds for left_out, seconds in limits.items() if left_out in chosen), math.inf)
        self.begin = self.shared = 0.0
        self.looked, self.slowness = -math.inf, 1.0
        self.item = None
        self.of_tests, self.of_fixtures = {}, {}
        self.here = 0.0  # seconds of processor of all tests on this machine

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_setup(self, item):
        if time.monotonic() > self.looked + EVERY:
            self._look()
        self.item, self.begin, self.shared = item, spent(), 0.0
        return (yield)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_fixture_setup(self, fixturedef):
        if fixturedef.scope == "function":
            return (yield)
        begin, before = spent(), self.shared
        result = yield
        cost = spent() - begin
        self.shared = before + cost  # fixtures that it asked for itself are part of it
        cost /= self.slowness
        self.item.user_properties.append(("fixture", (f"{fixturedef.baseid}::{fixturedef.argname}", cost)))
        return result

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_teardown(self, item):
        seconds, slow = spent() - self.begin - self.shared, self.slowness
        if seconds > self.limit * slow:  # or has the machine become slow meanwhile?
            self._look()
            slow = max(slow, self.slowness)
        item.user_properties += [("processor", seconds / slow), ("here", seconds)]

    def _look(self):
        self.looked, self.slowness = time.monotonic(), slowness()

    def pytest_runtest_logreport(self, report):
        if report.when == "teardown":
            properties = dict(report.user_properties)
            self.of_tests[report.nodeid] = properties["processor"]
            self.here += properties["here"]
            self.of_fixtures |= [value for name, value in report.user_properties if name == "fixture"]

    def outgrown(self):
        """Name and seconds of processor of what took much more than it may, the dearest first."""
        most = LENIENCY * self.limit
        return [each for each in self.dearest() if each[1] > most * (SHARED if each[0] in self.of_fixtures else 1)]

    def dearest(self):
        """Seconds of processor of each test and each shared fixture, the dearest first, with their names."""
        return sorted({**self.of_tests, **self.of_fixtures}.items(), key=lambda each: -each[1])

    def pytest_sessionfinish(self, session):
        if self.outgrown() and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED
        if self.config.getoption("costs"):
            with Path(self.config.getoption("costs")).open("w", encoding="utf-8", newline="") as file:
                rows = ((f"{cost:.2f}", name) for name, cost in self.dearest())
                csv.writer(file).writerows([("seconds", "test"), *rows])

    def pytest_terminal_summary(self, terminalreporter):
        total = sum(cost for _, cost in self.dearest())
        slow = self.here / sum(self.of_tests.values()) if self.of_tests else 1.0
        slower = f"; this machine took {slow:.1f} times as long" if slow > 1.05 else ""
        terminalreporter.write_line(f"tests took {total:.0f} s of processor of a quiet machine{slower}")
        for name, cost in self.outgrown():
            terminalreporter.write_line(
                f"OUTGROWN {name} took {cost:.1f} s of processor. A test has at most {self.limit:g}, "
                f"what tests share {SHARED * self.limit:g}: make it smaller, or mark it (docs/dev/adding.md)"
            )
