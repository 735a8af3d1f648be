"""Faults from outside: whole studies and single workers killed, runs that never end, Ctrl-C."""

import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from pathlib import Path
from pkgutil import resolve_name
from queue import SimpleQueue
from threading import Thread

import pandas as pd
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.folders import JOURNAL
from desim_warehouse.study.execution.kept_fleets import KeptFleets
from desim_warehouse.study.execution.pool import Worker
from desim_warehouse.study.execution.shared import BATCH_TIME, Batches, Handle
from desim_warehouse.study.execution.signals import Interrupts
from desim_warehouse.study.execution.store import Store
from desim_warehouse.study.execution.work import ENOUGH, Simulator, Wanted

from .conftest import MULTIBOTS, PATIENCE, ample, wait_for

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="signals and /proc of Linux")

DESIM = [sys.executable, "-c", "from desim_warehouse.cli import main; main()"]
FACTORS = {"fleet.size": [1, 2, 6]}
CHANGES = {"tasks.goods": {"random": 8}}


def study(replications, factors=FACTORS, **more):
    return dw.Study(MULTIBOTS, factors, changes=CHANGES, replications=replications, name="what-if", **more)


def command(folder, replications, workers):
    options = ["--set", "tasks.goods={random: 8}", "--replications", str(replications)]
    vary = ["--vary", "fleet.size=1,2,6", "--workers", str(workers), "--out", str(folder)]
    return [*DESIM, "what-if", str(MULTIBOTS), *vary, *options]


def lines(folder):
    path = folder / JOURNAL
    return path.read_bytes().count(b"\n") if path.exists() else 0


def children(pid):
    """Worker processes of a study (not the resource tracker)."""
    workers = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in task.read_text().split():
            command_line = Path(f"/proc/{child}/cmdline").read_bytes()
            if b"spawn_main" in command_line:
                workers.append(int(child))
    return workers


def alive(pid):
    try:
        return ") Z " not in Path(f"/proc/{pid}/stat").read_text()
    except FileNotFoundError:
        return False


def finished(table):
    return table.drop(columns="run_time")


def kill_after(folder, workers, runs):
    """Start the study, kill -9 it as soon as it has this many runs, and wait for its workers to end."""
    quiet = subprocess.DEVNULL
    process = subprocess.Popen(command(folder, 200, workers), stdout=quiet, stderr=quiet)
    wait_for(lambda: lines(folder) >= runs or process.poll() is not None)
    orphans = children(process.pid) if process.poll() is None else []
    process.kill()
    process.wait()
    wait_for(lambda: not any(alive(pid) for pid in orphans))


@pytest.mark.long
@pytest.mark.parametrize("workers", [1, 2])
def test_kill_9_of_the_whole_study_at_random_instants_loses_nothing(tmp_path, workers):
    chance = random.Random(workers)
    count = 0
    for _ in range(3):
        kill_after(tmp_path, workers, count + chance.randrange(1, 80))
        assert lines(tmp_path) > count
        count = lines(tmp_path)
    assert 0 < count < 600
    made = study(200).run(out=tmp_path, workers=2)
    assert lines(tmp_path) == 600  # every run once: what was finished was not done again
    assert finished(made.table).equals(finished(study(200).run().table))


@pytest.mark.long
@pytest.mark.parametrize(("replications", "workers", "targets"), [(30, 2, [10]), (100, 3, [30, 120])])
def test_a_killed_worker_is_replaced_and_its_runs_are_done_again(tmp_path, replications, workers, targets):
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen(command(tmp_path, replications, workers), **options)
    for target in targets:
        wait_for(lambda least=target: lines(tmp_path) > least)
        wait_for(lambda: len(children(process.pid)) >= 2)
        os.kill(children(process.pid)[0], signal.SIGKILL)
    _, stderr = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    assert "a worker process died; its runs are retried" in stderr
    assert lines(tmp_path) == 3 * replications
    table = pd.read_parquet(tmp_path / "results.parquet")
    assert finished(table).equals(finished(study(replications).run().table))


@pytest.mark.long
def test_ctrl_c_ends_at_once_and_keeps_what_is_done(tmp_path):
    process = subprocess.Popen(
        command(tmp_path, 5_000, 2), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    wait_for(lambda: lines(tmp_path) > 20 and children(process.pid))
    workers = children(process.pid)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers too
    _, stderr = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert "finished runs are kept in" in stderr
    assert "Traceback" not in stderr
    wait_for(lambda: not any(alive(pid) for pid in workers))
    with Store(tmp_path, pytest.fail) as store:
        assert len(store.runs) == lines(tmp_path) > 20
    assert len(pd.read_parquet(tmp_path / "results.parquet")) == lines(tmp_path)


def test_ctrl_c_in_one_process_keeps_what_is_done(tmp_path):
    """Every day in this process; how long it takes to start another, and to end workers, is seen above."""
    strike = Thread(target=lambda: (wait_for(lambda: lines(tmp_path) > 5), os.kill(os.getpid(), signal.SIGINT)))
    strike.start()
    done = CliRunner().invoke(desim, command(tmp_path, 5_000, 1)[len(DESIM) :])
    strike.join(PATIENCE)
    assert done.exit_code == 130
    assert "finished runs are kept in" in done.stderr
    assert "Traceback" not in done.stderr
    assert len(pd.read_parquet(tmp_path / "results.parquet")) == lines(tmp_path) > 5


def test_ctrl_c_that_strikes_as_python_closes_a_generator_is_not_lost(tmp_path, parking, capfd):
    """Python drops the exception there: the study heeds Ctrl-C after the run."""
    mark = tmp_path / "mark"
    case = parking("Ctrl-C as a generator is closed", mark=str(mark))
    with pytest.raises(KeyboardInterrupt):
        study(5, {"policies.parking": {"named": {"interrupted": case}}}).run(out=tmp_path / "out")
    assert lines(tmp_path / "out") == 1
    assert "ignored" not in capfd.readouterr().err
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_waits_while_locks_of_other_modules_are_held_and_is_heeded_then():
    interrupts = Interrupts()
    with pytest.raises(KeyboardInterrupt), interrupts, interrupts.held():
        os.kill(os.getpid(), signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        interrupts.heed()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.long
def test_ctrl_c_does_not_wait_for_a_worker_that_has_not_begun(tmp_path):
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True, "start_new_session": True}
    process = subprocess.Popen([*command(tmp_path, 20_000, 2), "--quiet"], **options)
    wait_for(lambda: children(process.pid))
    worker = children(process.pid)[0]
    os.kill(worker, signal.SIGSTOP)  # it never says hello; the other does
    wait_for(lambda: lines(tmp_path) > 0)
    os.killpg(process.pid, signal.SIGINT)
    _, stderr = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert stderr.startswith("stopped: ")
    assert not alive(worker)


@pytest.mark.long
def test_sigterm_ends_a_study_as_ctrl_c_does(tmp_path):
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen([*command(tmp_path, 20_000, 2), "--quiet"], **options)
    wait_for(lambda: lines(tmp_path) > 100 and children(process.pid))
    workers = children(process.pid)
    process.terminate()
    _, stderr = process.communicate(timeout=PATIENCE)
    assert process.returncode == 143
    count = lines(tmp_path)
    assert stderr == f"stopped: {count} finished runs are kept in {tmp_path}; the same command resumes\n"
    assert len(pd.read_parquet(tmp_path / "results.parquet")) == count
    assert not any(alive(pid) for pid in workers)


START_UP = [
    ("1", "study.Progress.__enter__"),
    ("1", "study.Store.__init__"),
    ("1", "study.StudyRunner.__init__"),
    ("1", "record.write_record"),
    ("1", "execution.work.Simulator.__init__"),
    ("1", "execution.work.RunData.simulated"),
    ("2", "execution.pool.Pool.__init__"),
    ("2", "execution.pool.Worker.__init__"),
    ("2", "execution.pool.Pool._receive"),
]


DAILY = ("study.Progress.__enter__",)


@pytest.mark.parametrize(
    ("workers", "place"), [pytest.param(*one, marks=[] if one[1] in DAILY else [pytest.mark.long]) for one in START_UP]
)
def test_sigterm_during_start_up_ends_with_143(tmp_path, monkeypatch, workers, place):
    """The signal comes as this is called for the first time; were it not heeded, the study would go on for long."""
    place = f"desim_warehouse.study.{place}"
    called = resolve_name(place)

    def struck(*args, **options):
        monkeypatch.setattr(place, called)
        os.kill(os.getpid(), signal.SIGTERM)
        return called(*args, **options)

    before = signal.signal(signal.SIGTERM, lambda *_: pytest.fail("nobody listens"))
    monkeypatch.setattr(place, struck)
    try:
        done = CliRunner().invoke(desim, command(tmp_path / "out", 20_000, workers)[len(DESIM) :])
    finally:
        signal.signal(signal.SIGTERM, before)
    assert done.exit_code == 143
    assert done.stderr == f"stopped: 0 finished runs are kept in {tmp_path / 'out'}; the same command resumes\n"
    assert not children(os.getpid())


@pytest.mark.parametrize(
    ("workers", "times"), [(1, 2), *(pytest.param(workers, 4, marks=pytest.mark.long) for workers in (1, 2))]
)
def test_sigterm_at_any_instant_of_the_start_ends_with_143(tmp_path, workers, times):
    """Before the command listens the system ends the process, which a shell tells as 143 too."""
    chance = random.Random(workers)
    options = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    for number in range(times):
        process = subprocess.Popen(command(tmp_path / str(number), 20_000, workers), **options)
        time.sleep(chance.uniform(0, 1.5))
        process.terminate()
        _, stderr = process.communicate(timeout=PATIENCE)
        assert process.returncode in {143, -signal.SIGTERM}
        assert stderr == "" or (stderr.startswith("stopped: ") and stderr.count("\n") == 1)


def test_workers_end_with_a_killed_study_even_at_code_that_lets_no_other_thread_run(tmp_path, parking):
    mark = tmp_path / "mark"
    holding = f"policies.parking={json.dumps(parking('hold', mark=str(mark)))}"
    options = ["--set", "tasks.goods={random: 8}", "--vary", holding, "--replications", "1", "--workers", "2"]
    quiet = subprocess.DEVNULL
    process = subprocess.Popen([*DESIM, "what-if", str(MULTIBOTS), *options], stdout=quiet, stderr=quiet)
    wait_for(lambda: mark.exists() and mark.read_text())
    worker = int(mark.read_text())
    assert alive(worker)
    process.kill()
    process.wait()
    wait_for(lambda: not alive(worker))


@pytest.mark.parametrize(
    ("what", "runs"),
    [
        ("start a process", 1),
        *(pytest.param(what, 10, marks=pytest.mark.long) for what in ("start a process", "fork", "fork and wait")),
    ],
)
def test_what_a_policy_starts_in_a_worker_ends_with_the_study(tmp_path, parking, what, runs):
    mark = tmp_path / "mark"
    cases = {"starts": parking(what, mark=str(mark))}
    made = study(runs, {"policies.parking": {"named": cases}}).run(workers=2, out=tmp_path / "out")
    assert made.table["error"].isna().all()
    assert lines(tmp_path / "out") == runs  # a copy of the worker counts nothing twice
    wait_for(lambda: not alive(int(mark.read_text())))


@pytest.mark.parametrize("runs", [1, pytest.param(10, marks=pytest.mark.long)])
def test_a_dead_worker_is_noticed_though_a_copy_of_it_holds_its_pipe_open(tmp_path, parking, runs):
    mark = tmp_path / "mark"
    made = study(runs, {"policies.parking": {"named": {"dies": parking("fork and die", mark=str(mark))}}})
    made.run(workers=2, out=tmp_path / "out")
    assert made.table["error"].isna().all()
    assert lines(tmp_path / "out") == runs
    assert set(made.notes) == {"a worker process died; its runs are retried"}  # twice if both were at it
    wait_for(lambda: not alive(int(mark.read_text())))


@pytest.mark.parametrize(("main", "limit", "status"), [(id, 120, 0), (Connection.recv, 0.5, -9)], ids=["ends", "hangs"])
def test_workers_that_never_begin_end_the_study_with_one_message(tmp_path, monkeypatch, main, limit, status):
    monkeypatch.setattr("desim_warehouse.study.execution.pool._START", limit)
    monkeypatch.setattr("desim_warehouse.study.execution.worker.main", main)
    message = rf"^worker processes end before they are ready \(exit status {status}\); try --workers 1$"
    with pytest.raises(dw.StudyError, match=message):
        study(1).run(workers=2, out=tmp_path)
    assert not children(os.getpid())
    assert lines(tmp_path) == 0


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.long)])
def test_a_policy_that_exits_is_a_failed_run_and_not_the_end_of_the_study(parking, workers):
    cases = {"exits": parking("exit"), "good": "home"}
    with pytest.warns(RuntimeWarning, match="failed"):
        made = study(2, {"policies.parking": {"named": cases}}).run(workers=workers)
    errors = made.table.set_index("policies.parking")["error"]
    assert errors["good"].isna().all()
    assert all("policies.parking" in error and "raised SystemExit(3) in " in error for error in errors["exits"])
    assert len(errors["exits"]) == 2


def test_a_debugger_follows_what_comes_after_a_time_limit():
    """On Python 3.11 an interruption that is withdrawn leaves a traced program where it is, for ever."""
    code = (
        "import sys\n"
        "from desim_warehouse.study.execution.time_limit import TimeLimit, TimeOutError\n"
        "sys.settrace(lambda *_: None)\n"
        "def done(): return True\n"
        "with TimeLimit(60): assert done()\n"
        "try:\n"
        "    with TimeLimit(0.01):\n"
        "        while done(): pass\n"
        "except TimeOutError: print(done())\n"
    )
    process = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert process.stdout == "True\n"


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.long)])
def test_a_run_that_never_ends_is_a_row_with_a_time_out(tmp_path, parking, workers):
    timeout = ample(study(1).run(workers=workers).table)
    factors = {"policies.parking": {"named": {"good": "home", "endless": parking("loop")}}}
    with pytest.warns(RuntimeWarning, match="failed"):
        made = study(1, factors, timeout=timeout).run(workers=workers, out=tmp_path)
    errors = made.table.set_index(["policies.parking", "replication"])["error"]
    assert errors["good"].isna().all()
    [error] = errors["endless"]
    assert re.fullmatch(rf"time-out: not finished after {timeout:g} s in .*\.py, line \d+", error)
    assert lines(tmp_path) == 2


def test_a_run_that_cannot_be_interrupted_has_its_process_killed(parking, monkeypatch):
    monkeypatch.setattr("desim_warehouse.study.execution.pool._GRACE", 0.5)
    timeout = ample(study(1).run(workers=1).table)
    factors = {"policies.parking": {"named": {"good": "home", "stuck": parking("block")}}}
    with pytest.warns(RuntimeWarning, match="failed"):
        made = study(1, factors, timeout=timeout).run(workers=2)
    errors = made.table.set_index("policies.parking")["error"]
    assert pd.isna(errors["good"])
    assert errors["stuck"] == f"time-out: not finished after {timeout:g} s, and its process had to be killed"
    assert made.notes == ["a run did not end and could not be interrupted; its process was killed"]


@pytest.mark.long
def test_one_stuck_run_in_a_batch_of_short_ones_is_done_again_with_the_others(parking, tmp_path, monkeypatch):
    take, stuck, sizes = Batches.take, Batches.stuck, []

    def take_ten(batches, workers):
        batches.run_time = BATCH_TIME / 10
        return take(batches, workers)

    def note(batches, handles, outcome):
        sizes.append(len(handles))
        stuck(batches, handles, outcome)

    timeout = ample(study(1).run(workers=1).table)
    monkeypatch.setattr(Batches, "take", take_ten)
    monkeypatch.setattr(Batches, "stuck", note)
    cases = {"good": "home", "stuck": parking("block once", mark=str(tmp_path / "mark"))}
    made = study(12, {"policies.parking": {"named": cases}}, timeout=timeout).run(workers=2)
    assert len(sizes) == 1
    assert sizes[0] > 1
    assert made.table["error"].isna().all()
    assert made.notes == ["a run did not end and could not be interrupted; its process was killed"]


@pytest.mark.parametrize(("runs", "seconds"), [(0, None), (1, 1.0 + 2.0), (200, 1.0 + 1.0 + 2.0)])
def test_a_stuck_run_in_a_batch_is_found_a_second_later_than_one_that_is_alone(runs, seconds, monkeypatch):
    """After the time-out and two seconds of grace: the time-outs of the other runs in the batch do not add up."""
    monkeypatch.setattr("desim_warehouse.study.execution.pool.monotonic", lambda: now)
    now = 100.0
    worker = Worker()
    try:
        worker.begun, worker.handles = True, [Handle(None, Wanted(0, {}, seed), id) for seed in range(runs)]
        for now in (100.0, 102.9, 103.1, 103.9, 104.1, 1000.0):
            assert worker.late(1.0) == (seconds is not None and now > 100 + seconds)
            assert not worker.late(None)
    finally:
        worker.kill()
        worker.close()


def test_runs_of_a_batch_in_which_one_is_stuck_are_done_again_one_by_one():
    """A run that is stuck alone has the outcome that was given; none of a batch has."""
    base, batches, told = study(1).plan.base, Batches(), SimpleQueue()
    handles = [Handle(base, Wanted(0, {}, seed), id) for seed in range(12)]
    for handle in handles:
        handle.tell(told)
        batches.add(handle)
    batches.run_time = BATCH_TIME / 10
    batch = batches.take(1)
    assert len(batch) == 6  # half of what waits
    outcome = object()
    batches.stuck(batch, outcome)
    assert told.empty()
    assert [batches.take(1) for _ in batch] == [[handle] for handle in batch]
    batches.stuck(batch[:1], outcome)
    assert told.get().outcome is outcome
    assert batches.open == 11


def test_a_batch_whose_runs_take_longer_than_thought_is_handed_in_half_done(monkeypatch):
    monkeypatch.setattr("desim_warehouse.study.execution.work.ENOUGH", 0.0)
    base = study(1).plan.base
    batches, told = Batches(), SimpleQueue()
    for seed in range(5):
        handle = Handle(base, Wanted(0, {}, seed), id)
        handle.tell(told)
        batches.add(handle)
    simulator = Simulator(KeptFleets())
    batches.run_time = 0.0001
    while handles := batches.take(1):
        outcomes = simulator.batch(base, [handle.wanted for handle in handles])
        assert len(outcomes) == 1
        batches.finish(handles, outcomes)
    assert [told.get().wanted.seed for _ in range(5)] == [0, 1, 2, 3, 4]
    assert not batches.open


@pytest.mark.parametrize(("runs", "before"), [(1, 0), (2, ENOUGH), (3, ENOUGH)])
def test_a_run_in_a_batch_may_have_to_wait_for_the_others_of_it(runs, before):
    worker = Worker.__new__(Worker)
    worker.handles = [None] * runs
    assert worker._before == before


def test_a_process_keeps_the_models_of_the_last_few_designs_only(monkeypatch):
    monkeypatch.setattr("desim_warehouse.study.execution.work._KEPT", 2)
    base, simulator = study(1).plan.base, Simulator(KeptFleets())
    for robots in (1, 2, 3):
        assert simulator.model(base, Wanted(robots, {"fleet.size": robots}, 0)).fleet.size == robots
    assert [number for _, number in simulator.models] == [2, 3]


@pytest.mark.long
def test_a_run_that_kills_its_worker_each_time_is_a_row_with_an_error(parking, tmp_path):
    cases = {"good": "home", "deadly": parking("die"), "once": parking("die once", mark=str(tmp_path / "mark"))}
    with pytest.warns(RuntimeWarning, match="2 of 6 runs failed"):
        made = study(2, {"policies.parking": {"named": cases}}).run(workers=2)
    errors = made.table.set_index(["policies.parking", "replication"])["error"]
    assert errors["good"].isna().all()
    assert errors["once"].isna().all()
    assert errors["deadly"].str.startswith("the worker process died at every attempt at this run").all()


def test_a_script_needs_no_main_guard(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        f"import desim_warehouse as dw\n"
        f"study = dw.Study({str(MULTIBOTS)!r}, changes={CHANGES!r})\n"
        f"print(len(study.run(workers=2).table), study.notes)\n"
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=True, timeout=PATIENCE)
    assert done.stdout == "1 []\n"
    assert not done.stderr


def test_a_study_in_a_working_directory_that_was_deleted_says_what_to_do(tmp_path, monkeypatch):
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    with pytest.raises(
        dw.StudyError, match=r"cannot be started \(.*\); try --workers 1, from a working directory that"
    ):
        study(1).run(workers=3)
    assert len(study(1).run().table) == 3


@pytest.mark.parametrize(
    ("names", "runs", "workers"), [("ab", 5, 1), pytest.param("abc", 30, 2, marks=pytest.mark.long)]
)
def test_studies_in_threads_of_one_process_are_apart(tmp_path, names, runs, workers):
    """With workers, too, which callers in several threads share every day in `test_executors`."""
    main = sys.modules["__main__"]
    with ThreadPoolExecutor(len(names)) as threads:
        made = list(threads.map(lambda name: study(runs).run(workers=workers, out=tmp_path / name), names))
    assert sys.modules["__main__"] is main
    alone = finished(study(runs).run().table)
    assert all(finished(each.table).equals(alone) for each in made)
    assert [lines(tmp_path / name) for name in names] == [3 * runs] * len(names)


@pytest.mark.long
def test_two_studies_in_one_folder_are_refused_and_a_killed_one_leaves_no_lock(tmp_path):
    process = subprocess.Popen(command(tmp_path, 20_000, 1), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wait_for(lambda: lines(tmp_path) > 0)
    second = subprocess.run(command(tmp_path, 1, 1), capture_output=True, text=True, check=False)
    assert second.returncode == 2
    assert f"another study is at work there (process {process.pid} on " in second.stderr
    process.kill()
    process.wait()
    assert subprocess.run(command(tmp_path, 1, 1), capture_output=True, check=False).returncode == 0
