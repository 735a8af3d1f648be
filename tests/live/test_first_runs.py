"""What the live page says before its first look: how many runs there are, and at once that work piles up."""

from functools import cache

import pytest

import desim_warehouse as dw
from desim_warehouse.live.answers import Named, RunsSoFar
from desim_warehouse.study.execution.work import Outcome
from desim_warehouse.study.target import read_target
from tests.run.halls import RING

TARGET = read_target("on_time >= 95 %")
DUE = {"run.length": "1 h", "tasks.unload_time": 20}


def hall(rate):
    """Six robots and a packer of 20 s, 180 loads an hour at most."""
    return dw.load(RING, {**DUE, "tasks.goods": {"due_within": 300, "poisson": rate}})


@cache
def measured(rate, seed):
    return dict(dw.simulate(hall(rate), seed).kpis)


def so_far(runs, rate):
    outcomes = [Outcome(measured(rate, seed), 1.0) for seed in range(runs)]
    return RunsSoFar(Named("6 robots", {}, hall(rate)), outcomes, "on_time", 0)


@pytest.mark.parametrize("runs", [1, 2, 9])
@pytest.mark.parametrize("rate", [260, pytest.param(300, marks=pytest.mark.long)])
def test_an_overloaded_design_is_overloaded_after_its_first_run(runs, rate):
    """80 and 120 tasks an hour more than can be done pile up."""
    words = so_far(runs, rate).in_words(TARGET)
    assert (words.verdict, words.label) == ("overloaded", "Cannot keep up")
    assert words.sentence.startswith("Only ")


@pytest.mark.parametrize("runs", [1, 3, 9])
def test_before_the_first_look_the_badge_counts(runs):
    words = so_far(runs, 100).in_words(TARGET)
    assert words.label == f"{runs} of 10 runs"
    assert words.sentence.startswith("So far ") == (runs > 1)


def test_from_the_first_look_on_it_is_the_verdict():
    assert so_far(10, 60).in_words(TARGET).label == "Needs more runs"
    assert so_far(35, 60).in_words(TARGET).label == "Target met"


def test_without_a_target_nothing_is_counted_down():
    assert so_far(3, 60).in_words(None).label == "Simulated"
