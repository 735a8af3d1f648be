"""Folders of strangers: what lies in them is read, and never run, from outside and from inside."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

TUTORIAL = Path(__file__).parents[2] / "models" / "tutorial.yaml"
DESIM = str(Path(sys.executable).with_name("desim"))
NAMES = ["pandas", "numpy", "sitecustomize", "usercustomize", "ipython_config", "conftest", "desim_warehouse"]
NAMES += ["multiprocessing", "pickle", "signal", "threading", "json", "jinja2", "matplotlib", "distributed", "dask"]
NAMES += ["click", "rich", "ruamel", "own_backend", "_distutils_hack"]


def desim(folder, *words):
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
    desim(folder, "run", str(TUTORIAL), "--out", "run")
    desim(folder, *vary, "--replications", "2", "--out", "study")
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
    yield "report", str(at / "run"), "--notebook", str(at / "x.ipynb"), "--replay"
    yield "report", str(at / "study")
    yield "replay", str(at / "run"), "-o", str(at / "replay.html")
    yield "export", str(at / "run"), "--format", "csv", "-o", str(at / "csv")
    yield "compare", str(at / "study"), "--indicator", "T"
    yield "check", str(at / "model.yaml")
    yield "draw", str(at / "model.yaml"), "-o", str(at / "floor.png")
    yield *vary, "--replications", "6", "--workers", "2", "--out", str(at / "study")


@pytest.mark.parametrize("within", ["", "run", "study", None], ids=["inside", "in-run", "in-study", "outside"])
def test_no_file_of_a_stranger_s_folder_runs(stranger, tmp_path, within):
    folder, ran, vary = stranger
    inside = tmp_path if within is None else folder / within
    at = folder if within is None else Path(os.path.relpath(folder, inside))
    for words in commands(at, vary):
        desim(inside, *words)
        assert not ran.exists(), (words, ran.read_text())


def test_the_processes_of_dask_run_none_either(stranger, tmp_path):
    folder, ran, vary = stranger
    pytest.importorskip("distributed")
    desim(folder, *vary, "--replications", "3", "--cluster", "local", "--workers", "2", "--out", str(tmp_path / "new"))
    assert not ran.exists(), ran.read_text()
