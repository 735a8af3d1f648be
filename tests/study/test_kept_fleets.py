"""Settled fleets that commands and their workers share: each settles once, and nothing that goes wrong is answered."""

import errno
import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress

import pytest
from click.testing import CliRunner
from ruamel.yaml import YAML

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.draft import Draft, draft
from desim_warehouse.run import RunData
from desim_warehouse.run.stop import StoppedError, StopSignal
from desim_warehouse.study.execution import pool
from desim_warehouse.study.execution.cache import cache_folder
from desim_warehouse.study.execution.kept_fleets import FleetsOfACommand, KeptFleets
from desim_warehouse.study.execution.locks import turn
from desim_warehouse.study.procedures import scouted
from desim_warehouse.study.statistics.judge import Budget
from desim_warehouse.study.target import read_target
from desim_warehouse.world.robots import settled
from desim_warehouse.world.robots.settled import UNSETTLED, SettledFleets

from .conftest import PATIENCE, wait_for
from .test_faults import DESIM

posix = pytest.mark.skipif(os.name != "posix", reason="kill -9 and rights of folders")
WORDS = Draft(size=(16, 14), orders=30, robots=2, chargers=1)
SHORT = {"run": {"length": "40 min"}, "battery.capacity": 15}
"""A small battery settles soon."""


@pytest.fixture(autouse=True)
def settles_once():
    """Here each process settles its fleets itself, as that of a user does."""


@pytest.fixture(scope="module")
def model():
    return dw.load(YAML(typ="safe").load(draft(WORDS)), SHORT)


@pytest.fixture(scope="module")
def right(model):
    """What the first run of the model is, by a process that shares nothing."""
    return RunData.simulated(model, fleets=SettledFleets()).record.rows


@pytest.fixture
def settlings(monkeypatch):
    """The settling runs of this process."""
    begun = []
    watch = settled.SettlingRun.watch

    def counted(self, env, robots):
        begun.append(self.model)
        watch(self, env, robots)

    monkeypatch.setattr(settled.SettlingRun, "watch", counted)
    return begun


def rows(model, folder):
    """The first run of a model, by a process that shares a folder with others."""
    return RunData.simulated(model, fleets=KeptFleets(folder)).record.rows


def kept(folder):
    return sorted(folder.glob("settled-*.jsonl"))


def test_a_design_settles_once_for_all_processes_that_share_a_folder(model, right, settlings, tmp_path):
    assert rows(model, tmp_path) == right
    assert rows(model, tmp_path) == right
    assert len(settlings) == 1
    longer = model.replace({"run": {"length": "1 h", "warm_up": "30 min"}, "log": "all"})
    RunData.simulated(longer, fleets=KeptFleets(tmp_path))  # how long it is simulated changes no fleet
    assert len(settlings) == 1
    RunData.simulated(model.replace({"fleet.size": 3}), fleets=KeptFleets(tmp_path))
    assert len(settlings) == len(kept(tmp_path)) == 2


def test_without_a_folder_it_settles_once_in_a_process(model, right, settlings):
    fleets = KeptFleets()
    assert [RunData.simulated(model, fleets=fleets).record.rows for _ in range(2)] == [right, right]
    assert len(settlings) == 1


def test_a_fleet_that_has_no_long_run_is_not_asked_again(model, settlings, tmp_path):
    flat = model.replace({"battery.charge_rate": 0.001})
    first, again = rows(flat, tmp_path), rows(flat, tmp_path)
    assert first == again
    assert len(settlings) == 1


@pytest.mark.slow
def test_damaged_fleets_are_worked_out_again(model, right, settlings, tmp_path):
    rows(model, tmp_path)
    (path,) = kept(tmp_path)
    whole = path.read_bytes()
    other = model.replace({"fleet.size": 3})
    RunData.simulated(other, fleets=KeptFleets(tmp_path))
    (foreign,) = set(kept(tmp_path)) - {path}
    for damaged in (whole[:-9], whole.replace(b"[[", b"[", 1), foreign.read_bytes()):
        path.write_bytes(damaged)
        settlings.clear()
        assert rows(model, tmp_path) == right
        assert len(settlings) == 1
        assert rows(model, tmp_path) == right  # the line that was added is whole
        assert len(settlings) == 1


@pytest.mark.parametrize("room", [pytest.param(0, marks=pytest.mark.long), 40])
def test_a_full_disk_changes_no_answer(model, right, settlings, tmp_path, monkeypatch, room):
    write = os.write

    def full(file, data):
        if bytes(data).startswith(b"\n") and room:
            return write(file, data[:room])
        if bytes(data).startswith(b"\n"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(file, data)

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        assert rows(model, tmp_path) == right
    assert rows(model, tmp_path) == right  # there is room again
    assert rows(model, tmp_path) == right
    assert len(settlings) == 2


def test_a_folder_that_is_not_there_changes_no_answer(model, right, tmp_path):
    assert rows(model, tmp_path / "gone") == right


@posix
@pytest.mark.skipif(os.name == "posix" and os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_only_be_read_is_read_and_changes_no_answer(model, right, settlings, tmp_path):
    rows(model, tmp_path)
    other = model.replace({"fleet.size": 3})
    tmp_path.chmod(0o500)
    assert rows(model, tmp_path) == right
    assert len(settlings) == 1
    RunData.simulated(other, fleets=KeptFleets(tmp_path))
    assert len(settlings) == 2
    tmp_path.chmod(0o700)


def test_of_two_that_want_one_at_once_one_waits(model, right, settlings, tmp_path):
    histories = []
    threads = [threading.Thread(target=lambda: histories.append(rows(model, tmp_path))) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
    assert histories == [right, right]
    assert len(settlings) == 1


HOLDS = """
import sys, time
from pathlib import Path
from desim_warehouse.study.execution.locks import turn

with turn(Path(sys.argv[1]), 9, print):
    print("held", flush=True)
    time.sleep(1000)
"""


@pytest.fixture
def holder(tmp_path):
    """Another process, which has its turn."""
    process = subprocess.Popen([sys.executable, "-c", HOLDS, str(tmp_path / "lock")], stdout=subprocess.PIPE)
    process.stdout.readline()
    yield process
    process.kill()
    process.communicate()


def test_a_turn_ends_with_the_process_that_has_it(tmp_path, holder):
    waits = []

    def waiting():
        waits.append(time.monotonic())
        holder.kill()

    with turn(tmp_path / "lock", PATIENCE, waiting):
        assert waits


def test_nobody_waits_for_ever_for_a_process_that_was_halted(tmp_path, holder):
    began = time.monotonic()
    with turn(tmp_path / "lock", 0.1, lambda: None):
        assert 0.1 <= time.monotonic() - began < PATIENCE
    assert holder.poll() is None


def test_a_run_that_waits_for_another_process_is_stopped_when_nobody_wants_it(model, tmp_path, monkeypatch):
    stop = StopSignal()
    (tmp_path / "kept").mkdir()
    fleets = KeptFleets(tmp_path / "kept")
    monkeypatch.setattr(
        "desim_warehouse.study.execution.kept_fleets.turn", lambda *args: turn(tmp_path / "lock", *args[1:])
    )
    with turn(tmp_path / "lock", 0, lambda: None):
        threading.Timer(0.1, stop.ask).start()
        with pytest.raises(StoppedError):
            RunData.simulated(model, 0, stop, fleets=fleets)


def test_a_command_without_the_cache_has_a_folder_of_its_own_that_goes_with_it():
    fleets = FleetsOfACommand(cache=False)
    folder = fleets.folder
    assert folder.is_dir()
    fleets.close()
    assert not folder.exists()
    assert not list(cache_folder().glob("runs-*"))


# Commands and studies


def study(model, **more):
    return dw.Study(model, {"fleet.size": [2, 3]}, replications=3, **more)


def table(made):
    return made.table.drop(columns="run_time").to_dict("records")


@pytest.mark.slow
@pytest.mark.long  # every day one worker, which is killed, and the one in its place share them
def test_workers_share_settled_fleets_and_answer_as_one(model):
    alone, many = study(model), study(model)
    alone.run(cache=True)
    many.run(workers=2, cache=False)
    assert table(alone) == table(many)
    assert len(list(cache_folder().glob("runs-*/settled-*.jsonl"))) == 2


@posix
@pytest.mark.slow
def test_a_worker_that_is_killed_while_it_settles_costs_nothing(model):
    """One worker is started for one run, and is killed as soon as it settles."""
    big = model.replace({"fleet.size": 6, "tasks.goods": {"poisson": 60}})
    expected = dw.Study(big, replications=1).run().table["T"].tolist()
    made = dw.Study(big, replications=1)
    killed = []

    def kill():
        with suppress(OSError):
            wait_for(lambda: list(cache_folder().glob("runs-*/.settling-*")))
            (worker,) = multiprocessing.active_children()
            os.kill(worker.pid, signal.SIGKILL)
            killed.append(worker.pid)

    thread = threading.Thread(target=kill)
    thread.start()
    made.run(workers=2, cache=True)
    thread.join(PATIENCE)
    assert killed
    assert made.table["T"].tolist() == expected
    assert made.notes == ["a worker process died; its runs are retried"]
    assert len(list(cache_folder().glob("runs-*/settled-*.jsonl"))) == 1


@pytest.mark.slow
@pytest.mark.long
def test_two_commands_at_once_on_one_cache_settle_once_and_answer_as_one(tmp_path):
    path = tmp_path / "small.yaml"
    path.write_text(draft(WORDS))
    command = ["run", str(path), "--set", "run={length: 600}", "--json"]
    both = [subprocess.Popen([*DESIM, *command], stdout=subprocess.PIPE, text=True) for _ in range(2)]
    outputs = [process.communicate(timeout=PATIENCE)[0] for process in both]
    assert [process.returncode for process in both] == [0, 0]
    kpis = [{**json.loads(text), "warnings": ""} for text in (*outputs, CliRunner().invoke(desim, command).stdout)]
    assert kpis[0] == kpis[1] == kpis[2]  # warnings depend on how long the check takes
    (path,) = cache_folder().glob("runs-*/settled-*.jsonl")
    assert path.read_bytes().count(b'"fleets"') == 1


@pytest.mark.slow
def test_one_crew_simulates_for_all_studies_of_a_question(model, monkeypatch):
    """Two workers at most, though scouts and what is judged are two studies."""
    started = []

    class Counted(pool.Worker):
        def __init__(self):
            started.append(self)
            super().__init__()

    monkeypatch.setattr(pool, "Worker", Counted)
    search = dw.Search(workers=2, cache=False, first=2, cap=3)
    sizing = dw.size(dw.Study(model, {"fleet.size": [2, 3]}), "on_time >= 50 %", search=search)
    assert sizing.smallest == 2
    assert len(started) <= 2
    assert not multiprocessing.active_children()


def test_scouts_settle_nothing_and_are_kept_apart(model, settlings):
    """Levels begin between 30 and 95 % of 15, and a study with the seed of the scouts does not find their runs."""
    study = dw.Study(model, {"fleet.size": [2, 3]}, target="on_time >= 50 %")
    goal = read_target("on_time >= 50 %", model.units.names)
    assert scouted(study, goal, [(0,), (1,)], lambda one: one, Budget(9), dw.Search()) == set()
    assert not settlings
    run = RunData.simulated(model, 1, fleets=UNSETTLED)
    assert all(4.5 <= levels[0] <= 14.25 for _, levels in run.history.energy_curves)
    names = [path.stem for path in cache_folder().glob("runs-*/*.jsonl")]
    assert names
    assert all(name.endswith("-scout") for name in names)
    full = dw.Study(model.replace({"fleet.start_energy": 1}), {"fleet.size": [2]}, target="on_time >= 50 %")
    assert scouted(full, goal, [(0,)], lambda one: one, Budget(9), dw.Search()) == set()
    assert len(list(cache_folder().glob("runs-*/*-scout.jsonl"))) == len(names)


def test_the_cache_of_commands_makes_room_for_settled_fleets_too(model, tmp_path, monkeypatch):
    """They are journals like those of runs, of which those go first that were not used for longest."""
    monkeypatch.setattr("desim_warehouse.study.execution.cache.MOST", 1)
    fleets = FleetsOfACommand(cache=True)
    RunData.simulated(model, fleets=fleets)
    fleets.cache.close()
    assert not kept(fleets.folder)
    shutil.rmtree(cache_folder())
