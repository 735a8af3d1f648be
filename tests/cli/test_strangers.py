"""What strangers send: files in their folders are never run, and their names and paths are one message or harmless."""

import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

import desim_warehouse as dw

pytestmark = pytest.mark.usefixtures("brief_probes")
TUTORIAL = Path(__file__).parents[2] / "models" / "tutorial.yaml"
DESIM = str(Path(sys.executable).with_name("desim"))
NAMES = ["pandas", "numpy", "sitecustomize", "usercustomize", "ipython_config", "conftest", "desim_warehouse"]
NAMES += ["multiprocessing", "pickle", "signal", "threading", "json", "jinja2", "matplotlib", "distributed", "dask"]
NAMES += ["click", "rich", "ruamel", "own_backend", "_distutils_hack"]


def program(folder, *words):
    env = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        [DESIM, *words], cwd=folder, env=env, capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    return done


@pytest.fixture(scope="module")
def stranger(tmp_path_factory):
    """A folder with a run, a study, and Python files that would say where they ran."""
    folder = tmp_path_factory.mktemp("stranger")
    vary = ["what-if", str(TUTORIAL), "--vary", "fleet.size=1,2", "--quiet", "--indicator", "T"]
    dw.simulate(dw.load(TUTORIAL)).save(folder / "run")
    dw.Study(str(TUTORIAL), {"fleet.size": [1, 2]}, replications=2, indicators=["T"]).run(out=folder / "study")
    (folder / "model.yaml").write_bytes(TUTORIAL.read_bytes())
    ran = folder.parent / "ran"
    for place in (folder, folder / "run", folder / "study"):
        line = f"open({str(ran)!r}, 'a').write({str(place)!r} + ' ' + __name__ + chr(10))\n"
        for name in NAMES:
            (place / f"{name}.py").write_text(line)
        (place / "own.pth").write_text(f"import sys; {line}")
        (place / "matplotlibrc").write_text("backend: module://own_backend\n")
        (place / "pyvenv.cfg").write_text(f"home = {place}\ninclude-system-site-packages = true\n")
        (place / "setup.cfg").write_text("[tool:pytest]\n")
    return folder, ran, vary


def commands(at, vary):
    yield *vary, "--replications", "2", "--workers", "2", "--out", str(at / "study")
    yield "draw", str(at / "model.yaml"), "-o", str(at / "floor.png")
    yield "report", str(at / "run"), "--notebook", str(at / "x.ipynb"), "--replay"
    yield "report", str(at / "study")
    yield "replay", str(at / "run"), "-o", str(at / "replay.html")
    yield "export", str(at / "run"), "--format", "csv", "-o", str(at / "csv")
    yield "compare", str(at / "study"), "--indicator", "T"
    yield "check", str(at / "model.yaml")


WITHIN = [
    pytest.param("", slice(1), id="workers"),
    pytest.param("", slice(1, 2), id="picture"),
    pytest.param("", slice(8), id="all-inside", marks=pytest.mark.long),
    pytest.param("run", slice(8), id="in-run", marks=pytest.mark.long),
    pytest.param("study", slice(8), id="in-study", marks=pytest.mark.long),
    pytest.param(None, slice(8), id="outside", marks=pytest.mark.long),
]


@pytest.mark.parametrize(("within", "some"), WITHIN)
def test_no_file_of_a_stranger_s_folder_runs(stranger, tmp_path, within, some):
    """Of a run and a study: every day what starts workers and what draws a picture, in the long run all commands."""
    folder, ran, vary = stranger
    inside = tmp_path if within is None else folder / within
    at = folder if within is None else Path(os.path.relpath(folder, inside))
    for words in list(commands(at, vary))[some]:
        program(inside, *words)
        assert not ran.exists(), (words, ran.read_text())


@pytest.mark.long
def test_the_processes_of_dask_run_none_either(stranger, tmp_path):
    folder, ran, vary = stranger
    pytest.importorskip("distributed")
    options = ["--replications", "3", "--cluster", "local", "--workers", "2", "--out", str(tmp_path / "new")]
    program(folder, *vary, *options)
    assert not ran.exists(), ran.read_text()


ESCAPES = "\x1b[2J\x1b]0;title\x07\x9b31m"
"""Clears the screen, renames the window, and begins red, where a terminal sees it."""
OBEYED = re.compile("\x1b(?!\\[[0-9;]*m)|[\x00-\x08\x0b-\x1a\x1c-\x1f\x7f-\x9f]")


@pytest.mark.parametrize("command", ["run", "check", "export", "replay", "draw", "report", "plan"])
def test_names_do_not_steer_the_terminal(desim, command, tmp_path):
    """In a model, and in the folders of runs and studies that somebody has changed: one message each."""
    model, folder = tmp_path / "model.yaml", tmp_path / "folder"
    text = TUTORIAL.read_text(encoding="utf-8")
    model.write_text(text.replace("name: tutorial", f"name: {json.dumps(ESCAPES)}"), encoding="utf-8")
    dw.simulate(dw.load(TUTORIAL)).save(folder)
    record = json.loads((folder / "run.json").read_text())
    record["model"]["name"] = ESCAPES
    (folder / "run.json").write_text(json.dumps(record))
    given = {"export": [str(folder), "--format", "csv"], "replay": [str(folder)], "report": [str(folder)]}
    more = {"plan": ["--target", "T <= 100"], "draw": ["-o", str(tmp_path / "x.png")]}
    message = failing(desim, command, *given.get(command, [str(model), *more.get(command, [])]))
    assert "control character" in message


def test_what_a_study_folder_says_does_not_steer_the_terminal(desim, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    study = dw.Study(str(TUTORIAL), {"fleet.size": [1, 2]}, replications=2, indicators=["T"])
    study.run(out=tmp_path / "study")
    file = tmp_path / "study" / "results.parquet"
    table = pd.read_parquet(file)
    table["error"] = [f"BatteryError: {ESCAPES}", None, None, None]
    table.to_parquet(file)
    for words in (["study", "study"], ["compare", "study"]):
        done = desim(*words)
        assert "Traceback" not in done.stderr
        assert not OBEYED.search(done.stdout)


def test_a_file_s_own_name_is_spelt_out(desim):
    assert "\\x1b[2J\\x1b]0;title\\x07\\x9b31m.yaml: no such file" in failing(desim, "check", f"{ESCAPES}.yaml")


DEEP = "x/" * 2000


@pytest.mark.parametrize(
    "words",
    [
        ["run", str(TUTORIAL), "--out", DEEP],
        ["what-if", str(TUTORIAL), "--vary", "fleet.size=1,2", "--quiet", "--out", DEEP],
        ["what-if", str(TUTORIAL), "--vary", "fleet.size=1,2", "--quiet", "--page", f"{DEEP}p.html"],
        ["why", str(TUTORIAL), "--out", DEEP],
        ["draw", str(TUTORIAL), "-o", f"{DEEP}floor.png"],
        ["export", str(TUTORIAL), "--format", "csv", "-o", DEEP],
        ["new", f"{DEEP}w.yaml", "--size", "16x14"],
        ["report", DEEP],
    ],
    ids=lambda words: " ".join(word[:9] for word in words if not word.startswith("/")),
)
def test_a_path_of_two_thousand_folders_is_one_message(desim, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    failing(desim, *words)
    assert not list(tmp_path.iterdir())


def failing(desim, *words):
    """What a command says that is refused: one message, and nothing that a terminal obeys."""
    done = desim(*words)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "Traceback" not in done.stderr
    assert not OBEYED.search(done.stdout + done.stderr)
    return done.stderr


def test_a_run_that_takes_too_long_is_stopped(desim):
    model, before = str(TUTORIAL.with_name("medium.yaml")), time.monotonic()
    long = ["--set", "run.length=400000", "--set", "log=tasks", "--set", "battery=null"]
    assert failing(desim, "run", model, *long, "--timeout", "0.1").endswith("not finished after 0.1 s (--timeout)\n")
    assert time.monotonic() - before < 60
    assert desim("run", str(TUTORIAL), "--timeout", "600").returncode == 0
