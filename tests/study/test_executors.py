"""Runs that are submitted one by one, by several callers, and cancelled while they wait, run, or have ended."""

import multiprocessing
import os
import signal
import threading
import time
from contextlib import closing

import pytest

import desim_warehouse as dw
from desim_warehouse.run.stop import StoppedError, StopSignal
from desim_warehouse.study.execution import make_executor
from desim_warehouse.study.execution.kept_fleets import KeptFleets
from desim_warehouse.study.execution.signals import Interrupts
from desim_warehouse.study.execution.work import Wanted

from .conftest import MULTIBOTS, PATIENCE, wait_for

BASE = dw.load(MULTIBOTS)
LONG = {"tasks.goods": {"saturated": 12}, "run.length": 10**9, "log": "tasks"}
"""A run of many minutes."""
SHORT = {"tasks.goods": {"random": 4}}
HEEDED = 2
"""Seconds within which a run stops: on a quiet machine it takes some hundredths of a second."""
WORKERS = [1, 2, "auto"]
pytestmark = pytest.mark.usefixtures("two_processors")


def executor(workers, messages=None):
    say = pytest.fail if messages is None else messages.append
    return closing(make_executor(workers, None, None, say, Interrupts(), KeptFleets()))


@pytest.fixture(scope="module")
def two():
    """Two processes that are at work, for all tests that leave them as they were."""
    with executor(2) as pool:
        times(pool, short(range(8)))
        yield pool


@pytest.fixture
def made(request, workers):
    """One executor or the other; `two` where that is the number."""
    if workers == 2:
        yield request.getfixturevalue("two")
        return
    with executor(workers) as made:
        yield made


def times(executor, runs):
    """T of each run by its seed."""
    handles = [executor.submit(BASE, run) for run in runs]
    return {handle.wanted.seed: handle.outcome.values["T"] for handle in executor.ended(handles)}


def short(seeds):
    return [Wanted(0, SHORT, seed) for seed in seeds]


def watched(executor, handle):
    """A thread that waits for a run, and when it was told that it had ended."""
    told = []
    thread = threading.Thread(target=lambda: told.extend(time.monotonic() for _ in executor.ended([handle])))
    thread.start()
    return thread, told


def simulating(pool, handle):
    return any(handle in worker.handles for worker in getattr(pool, "workers", ()))


@pytest.mark.parametrize("workers", WORKERS)
def test_callers_in_several_threads_are_given_their_own_runs(made):
    model = dw.load(MULTIBOTS, SHORT)
    right = {seed: dw.simulate(model, seed).T for seed in range(12)}
    task_times = {}
    ask = [(made, short(range(first, first + 4))) for first in (0, 4, 8)]
    threads = [threading.Thread(target=lambda *one: task_times.update(times(*one)), args=one) for one in ask]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
    assert task_times == right


def test_a_running_simulation_is_stopped_and_its_process_goes_on(two, monkeypatch):
    monkeypatch.setattr("desim_warehouse.study.execution.pool._HEED", 10)
    before = {worker.process.pid for worker in two.workers}
    handle = two.submit(BASE, Wanted(1, LONG, 0))
    thread, told = watched(two, handle)
    wait_for(lambda: simulating(two, handle))
    time.sleep(0.3)
    began = time.monotonic()
    handle.cancel()
    wait_for(lambda: not simulating(two, handle))
    assert time.monotonic() - began < HEEDED
    thread.join(PATIENCE)
    assert told
    assert told[0] - began < HEEDED
    assert (handle.cancelled, handle.outcome) == (True, None)
    assert len(times(two, short(range(8)))) == 8
    assert {worker.process.pid for worker in two.workers} == before


def test_a_run_in_this_process_is_stopped_by_another_thread():
    with executor(1) as alone:
        handle = alone.submit(BASE, Wanted(1, LONG, 0))
        thread, told = watched(alone, handle)
        wait_for(lambda: handle in alone.stops)
        time.sleep(0.2)
        began = time.monotonic()
        handle.cancel()
        thread.join(PATIENCE)
        assert told
        wait_for(lambda: handle not in alone.stops)
        assert time.monotonic() - began < HEEDED
        assert len(times(alone, short(range(2)))) == 2


@pytest.mark.parametrize("workers", WORKERS)
def test_a_run_that_waits_is_never_begun_and_one_that_has_ended_keeps_its_outcome(made):
    done, waiting = made.submit(BASE, short([1])[0]), made.submit(BASE, Wanted(1, LONG, 0))
    waiting.cancel()
    assert list(made.ended([waiting])) == [waiting]
    assert list(made.ended([done])) == [done]
    outcome = done.outcome
    done.cancel()
    assert (done.cancelled, done.outcome) == (False, outcome)
    assert outcome.values["T"] == dw.simulate(dw.load(MULTIBOTS, SHORT), 1).T


def test_a_process_that_does_not_heed_is_killed_and_replaced(parking):
    others = len(multiprocessing.active_children())
    with executor(2) as pool:
        times(pool, short(range(8)))
        deaf = pool.submit(BASE, Wanted(1, {**SHORT, "policies.parking": parking("block")}, 0))
        wait_for(lambda: simulating(pool, deaf))
        time.sleep(0.3)
        before = len(multiprocessing.active_children()) - others
        deaf.cancel()
        wait_for(lambda: not simulating(pool, deaf))
        assert len(times(pool, short(range(8)))) == 8
        assert before <= 2


def test_a_killed_worker_costs_no_caller_a_run():
    messages, others = [], multiprocessing.active_children()
    with executor(2, messages) as pool:
        task_times = {}
        threads = [
            threading.Thread(
                target=lambda seeds: task_times.update(times(pool, short(seeds))), args=[range(at, at + 24)]
            )
            for at in (0, 24)
        ]
        for thread in threads:
            thread.start()
        wait_for(lambda: any(worker.handles for worker in pool.workers))
        os.kill(next(worker for worker in pool.workers if worker.handles).process.pid, signal.SIGKILL)
        for thread in threads:
            thread.join(PATIENCE)
    assert len(task_times) == 48
    assert set(messages) == {"a worker process died; its runs are retried"}
    assert {*multiprocessing.active_children()} <= {*others}


def test_a_stop_before_a_run_and_in_it_is_the_same():
    model, stop = dw.load(MULTIBOTS, LONG), StopSignal()
    stop.ask()
    with pytest.raises(StoppedError):
        dw.simulate(model, 0, stop)
    late = StopSignal()
    threading.Timer(0.2, late.ask).start()
    with pytest.raises(StoppedError):
        dw.simulate(model, 0, late)
    plain = dw.load(MULTIBOTS, SHORT)
    assert dw.simulate(plain, 3, StopSignal()).record.rows == dw.simulate(plain, 3).record.rows
