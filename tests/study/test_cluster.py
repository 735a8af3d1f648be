"""A real Dask cluster: a scheduler and two workers, each a process of its own, on 127.0.0.1."""

import os
import re
import signal
import subprocess
import sys
import time

import pandas as pd
import pytest

import desim_warehouse as dw

from .conftest import MULTIBOTS, PATIENCE, ample

distributed = pytest.importorskip("distributed")

CHANGES = {"tasks.goods": {"random": 8}}


def started(arguments, log):
    with log.open("w") as file:
        return subprocess.Popen([sys.executable, "-m", *arguments], stdout=file, stderr=subprocess.STDOUT)


@pytest.fixture
def cluster(tmp_path):
    """Address, and the processes of the workers."""
    log = tmp_path / "scheduler.log"
    options = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
    scheduler = started(["distributed.cli.dask_scheduler", *options], log)
    processes = [scheduler]
    try:
        end = time.monotonic() + PATIENCE
        while not (match := re.search(r"Scheduler at:\s+(tcp://127\.0\.0\.1:\d+)", log.read_text())):
            assert time.monotonic() < end, log.read_text()
            time.sleep(0.05)
        options = ["--nthreads", "1", "--no-dashboard", "--no-nanny", "--local-directory", str(tmp_path)]
        for number in range(2):
            worker = ["distributed.cli.dask_worker", match[1], *options]
            processes.append(started(worker, tmp_path / f"worker{number}.log"))
        yield match[1], processes[1:]
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_a_cluster_within_this_process_gives_the_same_results():
    here, there = (dw.Study(MULTIBOTS, {"fleet.size": [1, 2]}, changes=CHANGES, replications=3) for _ in range(2))
    options = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with distributed.LocalCluster(**options, protocol="tcp://", host="127.0.0.1") as made:
        table = there.run(cluster=made.scheduler_address).table
    assert table.drop(columns="run_time").equals(here.run().table.drop(columns="run_time"))


@pytest.mark.long
def test_a_cluster_gives_the_same_results_though_a_worker_is_killed_half_way(cluster, tmp_path):
    address, workers = cluster
    out = tmp_path / "out"
    arguments = ["what-if", str(MULTIBOTS), "--set", "tasks.goods={random: 8}", "--vary", "fleet.size=1,2,6"]
    options = ["--replications", "150", "--cluster", address, "--out", str(out)]
    code = "from desim_warehouse.cli import main; main()"
    study = subprocess.Popen(
        [sys.executable, "-c", code, *arguments, *options], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    journal = out / "runs.jsonl"
    end = time.monotonic() + PATIENCE
    while not (journal.exists() and journal.read_bytes().count(b"\n") > 100):
        assert study.poll() is None
        assert time.monotonic() < end
        time.sleep(0.02)
    os.kill(workers[0].pid, signal.SIGKILL)
    _, stderr = study.communicate(timeout=PATIENCE)
    assert study.returncode == 0, stderr
    assert journal.read_bytes().count(b"\n") == 450  # nothing lost, nothing twice
    here = dw.Study(MULTIBOTS, {"fleet.size": [1, 2, 6]}, changes=CHANGES, replications=150).run()
    there = pd.read_parquet(out / "results.parquet")
    assert there["error"].isna().all()
    assert there.drop(columns="run_time").equals(here.table.drop(columns="run_time"))


@pytest.mark.long
def test_failing_and_endless_runs_are_rows_on_a_cluster_too(cluster, parking):
    address, _ = cluster
    usual = dw.Study(MULTIBOTS, changes=CHANGES, replications=20).run(cluster=address)
    timeout = ample(usual.table)
    cases = {"good": "home", "bad": parking("raise"), "endless": parking("loop")}
    made = dw.Study(MULTIBOTS, {"policies.parking": {"named": cases}}, changes=CHANGES, timeout=timeout)
    with pytest.warns(RuntimeWarning, match="2 of 3 runs failed"):
        made.run(cluster=address)
    errors = made.table.set_index("policies.parking")["error"]
    assert pd.isna(errors["good"])
    assert "no bay for me" in errors["bad"]
    assert errors["endless"].startswith(f"time-out: not finished after {timeout:g} s in ")


def test_a_cluster_that_does_not_answer_is_told(monkeypatch):
    monkeypatch.setattr("desim_warehouse.study.execution.cluster._WAIT", 0.5)
    with pytest.raises(dw.StudyError, match="no Dask scheduler answers there"):
        dw.Study(MULTIBOTS, changes=CHANGES).run(cluster="tcp://127.0.0.1:9")


@pytest.mark.parametrize("address", ["office", "tcp://office", "http://office:8786"])
def test_an_address_that_is_none_is_told_at_once(address):
    with pytest.raises(dw.StudyError, match=r"expected an address such as tcp://10\.0\.0\.1:8786, or local"):
        dw.Study(MULTIBOTS, changes=CHANGES).run(cluster=address)
