"""A mutant is tried as it stands in memory, and nowhere else."""

import os
import threading
import time

import pytest

from desim_warehouse.study.statistics.limits import days_for
from tests import mutants
from tests.mutants import Tried, forked, mutate, sites

MODULE = "study/statistics/limits.py"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="mutants are tried in forks")
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")  # from 3.12 on, of forks where threads run
def test_what_is_changed_is_what_runs_though_it_was_imported_before():
    """Searches for garbage leave out what `conftest` keeps, and so did mutants once: all of them survived."""
    begins, days = days_for.__code__.co_firstlineno, days_for(0.1)
    (rank,) = [rank for rank, (function, *_) in enumerate(sites(MODULE)[1]) if function == begins]

    def mutant():
        mutate(MODULE, rank)  # log(0.05) * log(0.9) for their ratio
        return days_for(0.1)

    assert forked(mutant, 60) == 1 < days == days_for(0.1)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="mutants are tried in forks")
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_mutant_that_waits_for_ever_is_stopped_by_the_clock_as_it_uses_no_processor(monkeypatch):
    monkeypatch.setattr(mutants, "PATIENCE", 1)
    assert forked(lambda: time.sleep(3600), 1) is None


def test_what_a_test_runs_in_a_thread_is_noted_too(monkeypatch):
    """Studies work in a thread of their own, and so no test was said to run what they do there."""

    def once(_item):
        thread = threading.Thread(target=days_for, args=(0.1,))
        thread.start()
        thread.join()

    tried = Tried(None)
    monkeypatch.setattr(tried, "once", once)
    _, functions = tried.watched(None)
    assert f"{MODULE}:{days_for.__code__.co_firstlineno}" in functions
