"""The package as people install it: wheel and sdist, in an environment that has nothing else."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet")
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The folder with the wheel and the sdist."""
    place = tmp_path_factory.mktemp("dist")
    subprocess.run([sys.executable, "-m", "hatchling", "build", "-d", place], cwd=ROOT, check=True, capture_output=True)
    return place


@pytest.fixture(scope="module")
def installed(built, tmp_path_factory):
    """The programs of an environment that has the wheel and what it requires, no extras."""
    home = tmp_path_factory.mktemp("clean")
    reached = [*PIP, "download", "--no-deps", "--dest", home / "reached", "simpy"]
    if subprocess.run(reached, check=False, capture_output=True).returncode:
        pytest.skip("no package index is reached")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", home / "env"], check=True)
    wheel = next(built.glob("*.whl"))
    python = str(home / "env/bin/python")
    subprocess.run([*PIP, "--python", python, "install", "--no-compile", wheel], check=True, capture_output=True)
    return home / "env/bin"


def files_of(wheel):
    return {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}


def test_the_sdist_makes_the_same_wheel(built, tmp_path):
    sdist = next(built.glob("*.tar.gz"))
    subprocess.run([*PIP, "wheel", "--no-deps", "--no-build-isolation", "-w", tmp_path, sdist], check=True)
    files = files_of(next(tmp_path.glob("*.whl")))
    assert files == files_of(next(built.glob("*.whl")))
    assert {"desim_warehouse/py.typed", "desim_warehouse/gallery/hospital.yaml"} <= files


@pytest.mark.long
def test_a_first_model_is_run_reported_and_replayed_and_what_an_extra_does_says_how_to_install_it(installed, tmp_path):
    def desim(*words):
        return subprocess.run([installed / "desim", *words], cwd=tmp_path, check=False, capture_output=True, text=True)

    for words in (
        ["new", "w.yaml", "--size", "16x14", "--orders", "60/h", "--schema"],
        ["run", "w.yaml", "--set", "log=all", "--set", "run.length=3600", "--set", "run.warm_up=0", "--out", "run"],
        ["report", "run", "-o", "report.html"],
        ["replay", "run", "-o", "replay.html"],
        ["new", "pods.yaml", "--like", "goods-to-person"],
    ):
        done = desim(*words)
        assert (done.returncode, done.stderr) == (0, ""), words
    assert (tmp_path / "report.html").stat().st_size > 10_000
    assert (tmp_path / "replay.html").stat().st_size > 10_000

    (tmp_path / "day.xlsx").write_bytes(b"PK")
    (tmp_path / "plan.dxf").write_text("0\nSECTION\n")
    for extra, words in {
        "excel": ["orders", "day.xlsx", "--model", "w.yaml"],
        "dxf": ["import", "plan.dxf", "-o", "plan.yaml"],
        "serve": ["serve", "w.yaml"],
        "dask": ["what-if", "w.yaml", "--vary", "fleet.size=1,2", "--cluster", "local", "--no-cache"],
    }.items():
        done = desim(*words)
        (line,) = done.stderr.splitlines()
        assert line.endswith(f"pip install 'desim-warehouse[{extra}]'")
        assert done.returncode == 2
    learn = [installed / "python", "-c", "import desim_warehouse.learn.rl"]
    done = subprocess.run(learn, check=False, capture_output=True, text=True)
    assert done.stderr.splitlines()[-1].endswith("pip install 'desim-warehouse[rl]'")
