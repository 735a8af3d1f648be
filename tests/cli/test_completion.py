"""What bash completes, asked as bash does: the function that click writes, with the words of a line."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

MODEL = "models/tutorial.yaml"
ASK = """
eval "$(_DESIM_COMPLETE=bash_source desim)"
compopt() { echo "($2)"; }
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=()
_desim_completion desim
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """A folder with a program `desim`, whatever stands on the path."""
    folder = tmp_path_factory.mktemp("bin")
    code = "import sys; sys.argv[0] = 'desim'; from desim_warehouse.cli import main; main()"
    (folder / "desim").write_text(f'#!/bin/sh\nexec "{sys.executable}" -c "{code}" "$@"\n')
    (folder / "desim").chmod(0o755)
    return folder


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
@pytest.mark.parametrize(
    ("line", "offered"),
    [
        (["wh"], ["what-if", "why"]),
        pytest.param(["run", "--un"], ["--unset"], marks=pytest.mark.long),
        (["run", "mod"], ["(default)"]),  # bash completes files
        pytest.param(["run", MODEL, "--set", "fleet.si"], ["(nospace)", "fleet.size="], marks=pytest.mark.long),
        pytest.param(["run", MODEL, "--set", "fl"], ["(nospace)", "fleet."], marks=pytest.mark.long),
        pytest.param(
            ["run", MODEL, "--unset", "tasks.load"], ["(nospace)", "tasks.load_time."], marks=pytest.mark.long
        ),
        (["run", MODEL, "--set", "layout.bays."], ["(nospace)", "layout.bays.parking."]),  # as its file names it
        pytest.param(["run", "no.yaml", "--set", "layout.bays."], [], marks=pytest.mark.long),
        pytest.param(
            ["plan", MODEL, "--vary", "battery.thr"], ["(nospace)", "battery.threshold="], marks=pytest.mark.long
        ),
        (["what-if", MODEL, "--indicator", "cycle_time_m"], ["cycle_time_mean", "cycle_time_median"]),
        (["report", MODEL, "--accept", "BAT"], ["BATTERY_TOO_SMALL"]),
    ],
    ids=" ".join,
)
def test_bash_completes(program, line, offered):
    done = subprocess.run(
        ["bash", "--norc", "-c", ASK, "bash", "desim", *line],
        cwd=Path(__file__).parents[2],
        env={**os.environ, "PATH": f"{program}{os.pathsep}{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr == ""
    assert done.stdout.split() == offered
