"""The installed program: exit status, messages without a traceback, and what it imports."""

import json
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from desim_warehouse import __version__

DESIM = [sys.executable, "-c", "from desim_warehouse.cli import main; main()"]
MODEL = "models/multibots.yaml"
HEAVY = {
    "numpy",
    "pandas",
    "scipy",
    "matplotlib",
    "pyarrow",
    "simpy",
    "pydantic",
    "networkx",
    "distributed",
    "nbclient",
}


def program(*arguments, start=DESIM):
    return subprocess.run([*start, *arguments], capture_output=True, text=True, check=False)


def test_the_installed_script_runs():
    done = program("--version", start=[Path(sys.executable).with_name("desim")])
    assert (done.returncode, done.stderr) == (0, "")
    assert __version__ in done.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "no_such_file.yaml"], "no_such_file.yaml: no such file, expected a model file"),
        (["check", "no_such_file.yaml"], "no_such_file.yaml: no such file, expected a model file"),
        (["run", "models"], "models: cannot be read"),
        (["run", "tests/bad/threshold.yaml"], "tests/bad/threshold.yaml:"),
        (["check", "tests/bad/threshold.yaml"], "tests/bad/threshold.yaml:"),
        (["run", MODEL, "--set", "fleet.size=0"], "--set fleet.size: should be greater than or equal to 1 (got 0)"),
        (["run", MODEL, "--set", "fleet.size"], "--set fleet.size: no assignment, expected KEY=VALUE"),
        (["run", MODEL, "--set", "fleet.sise=3"], "--set fleet.sise: unknown key, did you mean 'fleet.size'?"),
        (["run", MODEL, "--set", "policies.allocation=neerest"], "did you mean 'nearest'?"),
        (["run", MODEL, "--set", "policies.routing=nowhere.py:Mine"], "nowhere.py"),
        (["run", MODEL, "--set", "fleet.start=[G]"], "fleet.start: G: there is no bay at this node"),
        (["run", MODEL, "--set", "battery.capacity=3", "--set", "battery.threshold=0"], "ran flat at time"),
        (["run", MODEL, "--set", "tasks.goods=[80]"], "80"),
        (["run"], "Missing argument 'MODEL'"),
        (["run", MODEL, "--seed", "x"], "--seed"),
        (["frobnicate"], "No such command 'frobnicate'"),
        (["rnu", MODEL], "No such command 'rnu'. Did you mean 'run'?"),
        (["whatif", MODEL], "No such command 'whatif'. Did you mean 'what-if'?"),
        (["policies", "--doc", "neerest"], "no policy 'neerest', did you mean 'nearest'? Expected one of in-order,"),
        (["policies", "--doc", "zzz"], "no policy 'zzz', expected one of in-order,"),
        (["export", "nowhere", "--format", "csv"], "nowhere: no run can be read there (No such file or directory)"),
        (["export", MODEL, "--format", "trace"], "no run can be read there (a file is in the place of a folder)"),
        (["paper", "--study", MODEL], "multibots.csv: the paper's figures cannot be read (No such file or directory)"),
        (["run", MODEL, "--out", "README.md/run"], "README.md/run: the run cannot be written there"),
    ],
)
def test_what_is_refused_is_one_clear_message_and_exit_status_2(desim, arguments, message):
    done = desim(*arguments)
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert "Errno" not in done.stderr
    assert (done.returncode, done.stdout) == (2, "")


TELLING = """
import atexit, gc, json, os, sys

def tell():
    collections = sum(one["collections"] for one in gc.get_stats()) - begin
    threads = len(os.listdir("/proc/self/task")) if sys.platform == "linux" else 1
    modules = {name.split(".")[0] for name in sys.modules}
    json.dump([sorted(modules), collections, threads], sys.stderr)

from desim_warehouse.cli import main
begin = sum(one["collections"] for one in gc.get_stats())
atexit.register(tell)
main()
"""


def told_by(*arguments):
    """The top-level modules that a command has imported when it ends, its searches for garbage, and its threads."""
    done = program(*arguments, start=[sys.executable, "-c", TELLING])
    assert done.returncode == 0
    modules, collections, threads = json.loads(done.stderr)
    return set(modules), collections, threads


@pytest.fixture(scope="module")
def told_by_a_run():
    return told_by("run", MODEL, "--json")


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["run", "--help"]])
def test_help_imports_nothing_heavy(arguments):
    modules, *_ = told_by(*arguments)
    assert modules & HEAVY == set()


def test_a_run_imports_only_what_it_needs(told_by_a_run):
    """The paper's model draws nothing at random and makes no table: numpy is there for the hand calculation alone."""
    modules, *_ = told_by_a_run
    assert {"simpy", "networkx", "pydantic"} <= modules
    assert modules & {"matplotlib", "scipy", "pandas", "pyarrow"} == set()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="/proc of Linux")
def test_a_small_run_looks_for_garbage_once_a_probe_and_starts_no_threads(told_by_a_run):
    """The estimate probes one robot, then the fleet. More, or threads, would take several times as long as the run."""
    _, collections, threads = told_by_a_run
    assert threads == 1
    assert collections <= 2


def test_importing_the_package_imports_nothing_heavy():
    code = "import sys, desim_warehouse; print(*{m.split('.')[0] for m in sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) & HEAVY == set()


def test_a_model_from_another_folder_finds_its_own_files(desim, tmp_path, monkeypatch):
    (tmp_path / "storage.csv").write_text("from,to,offset\nA,B,10\nB,C,5\n")
    (tmp_path / "model.yaml").write_text(
        "layout:\n"
        "  nodes: {A: [0, 0], B: [20, 0], C: [20, 20]}\n"
        "  edges: [[A, B], [B, C], [C, A]]\n"
        "  storage: {file: storage.csv}\n"
        "  bays: {home: {at: [A]}}\n"
        "fleet: {size: 1, robot: {radius: 0.5, speed: 1}}\n"
        "tasks: {goods: [0, 1], unload_at: [C], load_time: 1, unload_time: 1}\n"
    )
    monkeypatch.chdir("/")
    done = desim("run", str(tmp_path / "model.yaml"), "--json")
    assert json.loads(done.stdout)["tasks"] == 2


CLOSED = [">&-", ">&- 2>&-", ">&- <&-"]


@pytest.mark.parametrize(
    ("arguments", "closed"),
    [
        ("policies", CLOSED[0]),
        *(("check models/none.yaml", closed) for closed in CLOSED[:2]),
        pytest.param("check models/none.yaml", CLOSED[2], marks=pytest.mark.long),
        *(pytest.param("check models/tutorial.yaml", closed, marks=pytest.mark.long) for closed in CLOSED),
        *(pytest.param("run models/tutorial.yaml", closed, marks=pytest.mark.long) for closed in CLOSED),
    ],
)
def test_a_closed_output_is_no_fault(arguments, closed):
    done = subprocess.run(
        ["sh", "-c", f"{shlex.join(DESIM)} {arguments} {closed}"], capture_output=True, text=True, check=False
    )
    assert done.returncode == (2 if "none" in arguments else 0)
    assert "Traceback" not in done.stderr
    assert bool(done.stderr) == ("none" in arguments and "2>&-" not in closed)
