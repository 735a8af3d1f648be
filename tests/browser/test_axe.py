"""What axe-core says of the pages: nothing serious, on light and on dark ground, on a screen and on a phone."""

from __future__ import annotations

from importlib.resources import files
from typing import TYPE_CHECKING, Any

import pytest

import desim_warehouse as dw
from desim_warehouse.report.page import example
from desim_warehouse.report.write import report
from tests.browser.pages import Opened
from tests.report.replay.floors import busy_run, people_run

if TYPE_CHECKING:
    from pathlib import Path

AXE = "const done = arguments[0]; axe.run({ resultTypes: ['violations'] }).then((found) => done(found.violations))"
SERIOUS = ("serious", "critical")


def a_study(folder: Path) -> Path:
    study = dw.Study(example(), {"fleet.size": [1, 3]}, replications=3, target="on_time >= 70 %").run()
    study.page(folder / "page.html")
    return folder / "page.html"


def a_replay(folder: Path) -> Path:
    busy_run().replay(folder / "page.html")
    return folder / "page.html"


def a_report(folder: Path) -> Path:
    return report(people_run(), folder / "page.html")


@pytest.mark.parametrize("make", [a_study, a_replay, a_report])
def test_axe_finds_nothing_serious(browser: Any, tmp_path: Path, make: Any) -> None:
    page = Opened(browser, make(tmp_path))
    browser.execute_script(files("axe_core_python").joinpath("axe.min.js").read_text("utf-8"))
    found = []
    for scheme, (width, height) in (("light", (1400, 900)), ("dark", (1400, 900)), ("light", (390, 844))):
        browser.execute_cdp_cmd(
            "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        )
        page.enlarge(width, height)
        found += [
            (scheme, width, one["id"], [node["html"][:120] for node in one["nodes"][:3]])
            for one in browser.execute_async_script(AXE)
            if one["impact"] in SERIOUS
        ]
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    assert found == []
