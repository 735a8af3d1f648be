"""What axe-core says of the pages: nothing, on light and on dark ground, on a screen and on a phone."""

from __future__ import annotations

from importlib.resources import files
from typing import TYPE_CHECKING, Any

import pytest

import desim_warehouse as dw
from desim_warehouse.report.page import example
from desim_warehouse.report.write import report
from desim_warehouse.study.fleet import plan_fleet
from desim_warehouse.study.why import why
from tests.browser.pages import Opened
from tests.report.replay.floors import busy_run, people_run

if TYPE_CHECKING:
    from pathlib import Path

AXE = "const [how, done] = arguments; axe.run(how).then((found) => done(found.violations))"
EVERY = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]}
UNFOLD = "for (const one of document.querySelectorAll('details')) one.open = true"


def a_study(folder: Path) -> Path:
    study = dw.Study(example(), {"fleet.size": [1, 3]}, replications=3, target="on_time >= 70 %").run()
    study.page(folder / "page.html")
    return folder / "page.html"


def a_study_of_words(folder: Path) -> Path:
    factors = {"fleet.size": [1, 3], "policies.allocation": ["nearest", "hungarian"]}
    dw.Study(example(), factors, replications=2).run().page(folder / "page.html")
    return folder / "page.html"


def an_answer_of_plan(folder: Path) -> Path:
    plan_fleet(example(), "on_time >= 75 %", growth=2, strategies={}, robots=range(1, 5)).answer.save(folder)
    return report(folder, folder / "page.html")


def an_answer_of_why(folder: Path) -> Path:
    why(example(), first=5, cap=5).answer.save(folder)
    return report(folder, folder / "page.html")


def an_answer_of_a_study(folder: Path) -> Path:
    factors = {"tasks.demand": [1, 2.2], "fleet.size": [1, 3]}
    dw.Study(example(), factors, replications=3, target="on_time >= 60 %").run(out=folder / "study")
    return report(folder / "study", folder / "page.html")


def an_answer_of_a_race(folder: Path) -> Path:
    found = dw.best(dw.Study(example(), {"fleet.size": [1, 3]}), "throughput_per_hour", first=3, cap=3)
    found.answer.save(folder)
    return report(folder, folder / "page.html")


def two_replays(folder: Path) -> Path:
    busy_run().replay(folder / "page.html", beside=people_run())
    return folder / "page.html"


def a_replay(folder: Path) -> Path:
    busy_run().replay(folder / "page.html")
    return folder / "page.html"


def a_report(folder: Path) -> Path:
    return report(people_run(), folder / "page.html")


ANSWERS = (an_answer_of_plan, an_answer_of_why, an_answer_of_a_study, an_answer_of_a_race)


@pytest.mark.parametrize("make", [a_study, a_study_of_words, a_replay, two_replays, a_report, *ANSWERS])
def test_axe_finds_nothing(browser: Any, tmp_path: Path, make: Any) -> None:
    page = Opened(browser, make(tmp_path))
    browser.execute_script(files("axe_core_python").joinpath("axe.min.js").read_text("utf-8"))
    browser.execute_script(UNFOLD)
    found = []
    for scheme, (width, height) in (("light", (1400, 900)), ("dark", (1400, 900)), ("light", (390, 844))):
        browser.execute_cdp_cmd(
            "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        )
        page.enlarge(width, height)
        found += [
            (scheme, width, one["id"], [node["html"][:120] for node in one["nodes"][:3]])
            for one in browser.execute_async_script(AXE, EVERY)
        ]
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    assert found == []
