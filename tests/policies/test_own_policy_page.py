"""docs/how-to/own-policy.md does what it says."""

import contextlib
import io
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs import pages

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"```(\w+)(?: file=(\S+))?\n(.*?)```", re.DOTALL)


def test_the_page_can_be_followed(tmp_path, monkeypatch):
    shutil.copy(ROOT / "models" / "multibots.yaml", tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)  # options of this session mean nothing to the page's own
    output, names, commands = "", {}, 0
    for kind, file, text in BLOCK.findall((ROOT / "docs" / "how-to" / "own-policy.md").read_text(encoding="utf-8")):
        if file:
            Path(file).write_text(text)
        elif kind == "python":
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                exec(text, names)  # noqa: S102 - it is our own page
            output = out.getvalue()
        elif kind == "output":
            assert output == text
        elif kind == "console":
            command = text.removeprefix("$ ").split()
            if command[0] == "desim":
                status, *printed = pages.run_desim(text.removeprefix("$ "))
            else:
                assert command[0] == "pytest"
                done = subprocess.run([sys.executable, "-m", *command], capture_output=True, text=True, check=False)
                status, *printed = done.returncode, done.stdout, done.stderr
            assert status == 0, printed
            commands += 1
        else:
            changed = Path("multibots.yaml").read_text().replace("  allocation: in-order", text.split("\n")[1])
            Path("changed.yaml").write_text(changed)
            from desim_warehouse import load

            assert load("changed.yaml").policies.allocation.params == {"reach": 2}
    assert commands == 2
