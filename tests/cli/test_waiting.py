"""What a command says while somebody waits: on a terminal, after two seconds, and nothing anywhere else."""

import io
from types import SimpleNamespace

import pytest

import desim_warehouse as dw
from desim_warehouse.cli import waiting
from desim_warehouse.cli.waiting import Waiting
from tests.report.replay.floors import busy


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def model():
    return dw.load(busy())  # 900 s


def test_the_time_left_is_said_once_a_hundredth_is_done(model):
    """A third of 900 s in 10 s leaves 20 s; of 5 s in 10 s nothing is told yet."""
    progress = Waiting("simulating", model)
    progress.clock = SimpleNamespace(now=300.0)
    assert progress.line(10.0) == "simulating: 33 % of 15 min, 10 s so far, 20 s left"
    progress.clock = SimpleNamespace(now=5.0)
    assert progress.line(10.0) == "simulating: 1 % of 15 min, 10 s so far"


def test_a_run_without_an_end_and_a_check_say_how_long_they_take(model):
    endless = Waiting("simulating", dw.load("models/multibots.yaml"))
    endless.clock = SimpleNamespace(now=120.0)
    assert endless.line(3.0) == "simulating: 120 steps of the run, 3 s so far"
    assert Waiting("checking").line(2.5) == "checking: 2.5 s so far"


@pytest.mark.parametrize(
    ("stream", "patience", "is_said"), [(Terminal, 0, True), (Terminal, 60, False), (io.StringIO, 0, False)]
)
def test_only_a_terminal_is_told_and_only_of_what_takes_long(monkeypatch, model, stream, patience, is_said):
    monkeypatch.setattr(waiting, "PATIENCE", patience)
    told = stream()
    with Waiting("simulating", model, stream=told) as signal:
        dw.simulate(model, 1, signal)
    text = told.getvalue()
    assert ("simulating: " in text) == is_said
    assert text.endswith("\r\x1b[K" if is_said else "")
    assert "\n" not in text


def test_a_run_that_is_followed_is_the_run_without(model):
    with Waiting("simulating", model, stream=Terminal()) as signal:
        assert dw.simulate(model, 1, signal).kpis == dw.simulate(model, 1).kpis
