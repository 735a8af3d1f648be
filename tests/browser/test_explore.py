"""The what-if page in a real browser: what is chosen is what the commands print, on any screen, without a network."""

from __future__ import annotations

import re
import shlex
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.report.text import words
from desim_warehouse.report.write import report
from desim_warehouse.study.results import Results
from tests.browser.pages import Opened

if TYPE_CHECKING:
    from pathlib import Path

LEFT, RIGHT, DOWN, TAB, END = "\ue012", "\ue014", "\ue015", "\ue004", "\ue010"
SCREENS = {"desktop": (1400, 900, False), "phone": (390, 844, True)}
CHOOSE = (
    "const [side, levels] = arguments; levels.forEach((level, factor) => {"
    "const field = document.getElementById(`${side}-${factor}`); field.value = level;"
    "field.dispatchEvent(new Event('input')); })"
)
BOXES = (
    "return Array.from(document.querySelectorAll(arguments[0]), (one) => {"
    "const box = one.getBoundingClientRect(); return [box.left, box.top, box.right, box.bottom]; })"
)

OUTSIDE = """return Array.from(document.querySelectorAll("table, figure, img, svg, pre, p"), (one) => {
  const box = one.getBoundingClientRect(), around = one.parentElement.getBoundingClientRect();
  const scrolls = getComputedStyle(one.parentElement).overflowX === "auto";
  return scrolls || (box.left >= around.left - 1 && box.right <= around.right + 1) ? "" : one.outerHTML.slice(0, 80);
}).filter(Boolean)"""
"""Parts of a page that leave their box, where that does not scroll."""


def call(line: str) -> str:
    """What a command prints."""
    result = CliRunner().invoke(desim, shlex.split(line)[1:], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Eighteen designs, eight replications each, with their page; and what the command printed."""
    folder = tmp_path_factory.mktemp("study")
    printed = call(
        "desim what-if models/multibots.yaml --vary fleet.size=2,3,5 --vary policies.allocation=in-order,nearest "
        "--vary battery.threshold=2,3.5,5 --set 'tasks.goods={random: 6}' --indicator T --indicator S "
        f"--indicator cycle_time_mean --replications 8 --quiet --out {folder} --page {folder}/page.html"
    )
    return folder, printed


@pytest.fixture
def page(browser: Any, study: tuple[Path, str]) -> Opened:
    return Opened(browser, study[0] / "page.html")


def choose(page: Opened, side: str, levels: list[int]) -> None:
    """Choose a design by the ranks of its levels."""
    page.browser.execute_script(CHOOSE, side, levels)


def row(page: Opened, indicator: str) -> list[str]:
    """The cells of an indicator in the table of A and B: A, B, difference, from, to, p, verdict."""
    script = "return Array.from(document.querySelectorAll(arguments[0]), (cell) => cell.textContent)"
    return list(page.browser.execute_script(script, f"#differences tr[data-indicator='{indicator}'] td"))


def cells(line: str) -> list[str]:
    """The columns of a printed line."""
    return re.split(r" {2,}", line.strip())


def test_curves_go_through_the_means_and_intervals_reach_their_ends(page: Opened, study: tuple[Path, str]) -> None:
    results = Results.load(study[0])
    choose(page, "a", [0, 0, 0])
    choose(page, "b", [2, 1, 1])
    marks = page.browser.execute_script(
        "return Array.from(document.querySelectorAll('#curve circle'), (mark) => "
        "[+mark.dataset.design, +mark.getAttribute('cx'), +mark.getAttribute('cy'), mark.classList.contains('chosen')])"
    )
    bars = page.browser.execute_script(
        "return Array.from(document.querySelectorAll('#curve .bar'), (bar) => { const box = bar.getBBox();"
        "return [box.y, box.y + box.height]; })"
    )
    assert [design for design, *_ in marks] == [0, 6, 12, 4, 10, 16]  # over robots, the others as in A and as in B
    assert [design for design, _, _, chosen in marks if chosen] == [0, 16]
    found = [results.estimates("T")[design] for design, *_ in marks]
    means = [one.mean for one in found if one]
    heights = np.polyfit(means, [mark[2] for mark in marks], 1)
    assert np.polyval(heights, means) == pytest.approx([mark[2] for mark in marks], abs=0.1)
    across = np.polyfit([2, 3, 5], [mark[1] for mark in marks[:3]], 1)
    assert np.polyval(across, [2, 3, 5]) == pytest.approx([mark[1] for mark in marks[:3]], abs=0.1)
    ends = [
        [float(np.polyval(heights, end)) for end in reversed(one.interval)] for one in found if one and one.interval
    ]
    assert np.array(bars) == pytest.approx(np.array(ends), abs=0.5)


def test_the_answer_says_in_what_b_is_better(page: Opened) -> None:
    choose(page, "a", [0, 0, 0])
    assert page.text("answer").startswith("B is better: Task time")
    page.click("swap")
    assert "B is worse: Task time" in page.text("answer")
    choose(page, "a", [2, 0, 0])
    choose(page, "b", [2, 0, 0])
    assert page.text("answer") == "A and B are the same design."


def test_the_command_can_be_copied(page: Opened, study: tuple[Path, str]) -> None:
    copied = page.browser.execute_script(
        "getSelection().selectAllChildren(document.getElementById('command')); return getSelection().toString()"
    )
    assert copied.startswith("desim what-if models/multibots.yaml --vary fleet.size=2,3,5 --vary")
    assert copied.strip().endswith("--set 'tasks.goods={random: 6}'")


def test_every_control_has_a_name_and_is_reached_by_tab(page: Opened) -> None:
    nodes = page.browser.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    roles = {"button", "slider", "combobox"}
    names = [
        node["name"]["value"]
        for node in nodes
        if node.get("role", {}).get("value") in roles and not node.get("ignored")
    ]
    sides = [f"{side}: {key}" for key in ("fleet.size", "policies.allocation", "battery.threshold") for side in "AB"]
    assert sorted(names) == sorted(["Swap A and B", *sides, "Indicator", "over"])
    reached = []
    for _ in range(9):
        page.press(TAB)
        reached.append(page.browser.execute_script("return document.activeElement.id"))
    assert reached == ["swap", "a-0", "b-0", "a-1", "b-1", "a-2", "b-2", "indicator", "over"]


@pytest.mark.parametrize("screen", SCREENS)
def test_nothing_overlaps_or_is_fetched_on_any_screen(page: Opened, screen: str) -> None:
    width, height, mobile = SCREENS[screen]
    page.enlarge(width, height, mobile=mobile)
    for indicator in range(3):
        for over in range(3):
            for name, rank in (("indicator", indicator), ("over", over)):
                script = "arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('input'))"
                page.browser.execute_script(script, page.browser.find_element("id", name), rank)
            for group in ("section", ".side", "button, select, input", "#curve text.level", "#differences td"):
                boxes = page.browser.execute_script(BOXES, group)
                assert all(box[0] >= 0 and box[2] <= width + 0.5 for box in boxes), group
                assert not [
                    (one, other) for rank, one in enumerate(boxes) for other in boxes[:rank] if _overlap(one, other)
                ], group
    assert page.browser.execute_script("return document.documentElement.scrollWidth") <= width
    if mobile:
        fields = page.browser.find_elements("css selector", "button, select")
        assert min(field.rect["height"] for field in fields) >= 44
    assert page.complaints() == []
    assert page.requests() == []


def _overlap(one: list[float], other: list[float]) -> bool:
    across = min(one[2], other[2]) - max(one[0], other[0])
    down = min(one[3], other[3]) - max(one[1], other[1])
    return across > 0.5 and down > 0.5


def test_the_choice_of_designs_and_indicator_stands_in_the_address(page: Opened, study: tuple[Path, str]) -> None:
    choose(page, "a", [1, 0, 2])
    choose(page, "b", [2, 1, 1])
    page.browser.execute_script(
        "const field = document.getElementById('indicator'); field.value = 1; field.dispatchEvent(new Event('input'))"
    )
    address = page.browser.current_url
    assert address.endswith("#a=1.0.2&b=2.1.1&i=S&over=0")
    page.browser.get("about:blank")
    page.browser.get(address)
    assert [page.attribute(f"a-{rank}", "value") for rank in range(3)] == ["1", "0", "2"]
    assert [page.attribute(f"b-{rank}", "value") for rank in range(3)] == ["2", "1", "1"]
    assert page.attribute("indicator", "value") == "1"


def test_the_target_is_a_line_a_column_and_an_answer(browser: Any, tmp_path: Path) -> None:
    call(
        "desim what-if models/multibots.yaml --vary fleet.size=1..3 --set 'tasks.goods={random: 4}' --replications 3 "
        f"--target 'T <= 2000' --indicator S --quiet --page {tmp_path}/page.html --out {tmp_path}/out"
    )
    page = Opened(browser, tmp_path / "page.html")
    assert "target: task time at most 2,000 steps" in page.text("legend")
    assert page.text("answers").startswith(
        "2 robots are the first option shown to give task time at most 2,000 steps: "
    )
    assert [page.attribute(f"{side}-0", "value") for side in "ab"] == ["0", "2"]  # one robot beside three
    heads = [cell.text for cell in page.browser.find_elements("css selector", "#designs th[scope=col]")]
    column = heads.index("task time at most 2,000 steps")
    rows = page.browser.find_elements("css selector", "#designs tbody tr")
    shown = [row.find_elements("css selector", "th, td")[column].text for row in rows]
    results = Results.load(tmp_path / "out")
    assert shown == [words.met_or_when(results, design) for design in results.designs]
    assert page.complaints() == []


@pytest.fixture(scope="module")
def uneven(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """What-if page and report of four designs with as many runs as each needs, some of which cannot keep up."""
    folder = tmp_path_factory.mktemp("uneven")
    study = dw.Study(
        "models/multibots.yaml",
        {"fleet.size": [1, 6], "policies.allocation": ["in-order", "nearest"]},
        changes={"tasks.goods": {"poisson": 400}, "run.length": 10000, "run.warm_up": 2000},
        replications={"indicator": "throughput_per_hour", "half_width": 0.1, "minimum": 2, "cap": 6},
        target="throughput_per_hour >= 380",
    ).run(out=folder / "study")
    assert len({len(study.results.runs(design)) for design in study.results.designs}) > 1
    study.page(folder / "page.html")
    return folder / "page.html", report(folder / "study", folder / "report.html")


@pytest.mark.parametrize("which", [0, 1])
def test_unequal_runs_fit_screens_of_any_width(browser: Any, uneven: tuple[Path, Path], which: int) -> None:
    page = Opened(browser, uneven[which])
    for width in (390, 800, 1024, 1280, 1400, 1920):
        page.enlarge(width, 900, mobile=width == 390)
        assert page.browser.execute_script("return document.documentElement.scrollWidth") <= width
        assert page.browser.execute_script(OUTSIDE) == [], width
    assert page.complaints() == []


def test_paper_has_all_of_the_page_and_nothing_to_press(browser: Any, uneven: tuple[Path, Path]) -> None:
    page = Opened(browser, uneven[0])
    page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    page.enlarge(718, 1000)  # A4
    pressed = page.browser.find_elements("css selector", "button, input")
    assert [item.get_attribute("id") for item in pressed if item.is_displayed()] == []
    assert page.browser.execute_script("return document.documentElement.scrollWidth") <= 718
    figure = page.browser.find_element("id", "curve").rect
    assert figure["width"] > figure["height"] > 200
    page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
