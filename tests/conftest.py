"""Hypothesis profiles, `fast` for every day and `long` for make test-long; and why tests were skipped."""

import gc
import os
import signal
import sys
from collections import Counter
from itertools import count

import pytest
from hypothesis import settings
from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer

from desim_warehouse.world.robots.settled import SettledFleets
from tests.brief import FEWER_SAMPLES, probe_briefly
from tests.costs import Costs

settings.register_profile("fast", max_examples=20, deadline=None, derandomize=True)
settings.register_profile("long", max_examples=2000, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "fast"))

# Tests start hundreds of programs, each of which would else compile the package anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # begun by a shell with `&`: children would ignore Ctrl-C, too
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser):
    parser.addoption("--costs", help="file to write the processor time of each test to: CSV, the dearest first")


def pytest_configure(config):
    config.pluginmanager.register(Costs(config))


def pytest_collection_finish():
    """What was imported and collected stays: search for garbage without it, until a probe does else, and rarely."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 20, 20)


@pytest.fixture(scope="session")
def _caches(tmp_path_factory):
    """Names of folders, one by one. That of a factory would list all there are to find the next."""
    folder = tmp_path_factory.mktemp("caches")
    return (folder / str(number) for number in count())


@pytest.fixture(autouse=True)
def _own_cache(_caches, monkeypatch):
    """No test finds the runs of another, nor those of the user."""
    monkeypatch.setenv("DESIM_CACHE", str(next(_caches)))


_SETTLED = {}


@pytest.fixture(autouse=True)
def settles_once(monkeypatch):
    """Fleets that settled in one test are given to the others of its process: a model's are the same each time."""
    of = SettledFleets.of

    def remembered(fleets, model, settle, waiting):
        def once(settling):
            if settling.model not in _SETTLED:
                _SETTLED[settling.model] = settle(settling)
            return _SETTLED[settling.model]

        return of(fleets, model, once, waiting)

    monkeypatch.setattr(SettledFleets, "of", remembered)


_COMPOSED = {}
_LONGEST = 20_000
"""Characters of a text whose nodes are kept."""


@pytest.fixture(autouse=True)
def composes_once(monkeypatch):
    """The nodes of a YAML text are given to all tests of its process: its values are made of them each time."""
    compose = YAML.compose

    def remembered(yaml, text):
        if yaml.Composer is not Composer or len(text) > _LONGEST:
            return compose(yaml, text)
        if text not in _COMPOSED:
            _COMPOSED[text] = compose(yaml, text)
        return _COMPOSED[text]

    monkeypatch.setattr(YAML, "compose", remembered)


@pytest.fixture(autouse=True)
def _one_processor(monkeypatch):
    """`--workers auto` starts no processes beside those in which tests run; those of executors ask for two."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0}, raising=False)


@pytest.fixture
def brief_probes(request, monkeypatch):
    """For tests of what a check says; proofs have whole probes, as have those that ask for `whole_probes`."""
    if request.node.get_closest_marker("long") is None and "whole_probes" not in request.fixturenames:
        probe_briefly(monkeypatch)


@pytest.fixture
def whole_probes():
    """For tests of the figures of a check, in files of others."""


@pytest.fixture
def fewer_samples(request, monkeypatch):
    """For tests of what a fit says; proofs have all."""
    if request.node.get_closest_marker("long") is None:
        monkeypatch.setattr("desim_warehouse.study.fit.SAMPLES", FEWER_SAMPLES)


def pytest_terminal_summary(terminalreporter):
    """One line for each reason, however many tests were skipped for it."""
    reports = terminalreporter.stats.get("skipped", [])
    reasons = Counter(report.longrepr[2].removeprefix("Skipped: ") for report in reports)
    for reason, times in reasons.most_common():
        terminalreporter.write_line(f"{times} skipped: {reason}")
