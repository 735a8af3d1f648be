"""Reports in a browser: on a phone, on dark ground and on paper."""

import base64

import pytest

from desim_warehouse.report.write import report
from tests.browser.pages import Opened
from tests.report.replay.floors import people_run

FIGURE = "return getComputedStyle(document.querySelector('img')).filter"


@pytest.fixture(scope="module")
def page(browser, tmp_path_factory):
    return Opened(browser, report(people_run(), tmp_path_factory.mktemp("report") / "page.html"))


def test_the_answer_and_its_numbers_can_be_read_on_a_phone(page):
    page.enlarge(390, 844, mobile=True)
    assert page.browser.execute_script("return document.documentElement.scrollWidth") <= 390
    for item in page.browser.find_elements("css selector", "dl.tiles dd, dl.tiles dt, ul.answers li"):
        assert item.text
        assert item.rect["x"] >= 0
        assert item.rect["x"] + item.rect["width"] <= 390
    tiles = page.browser.find_elements("css selector", "dl.tiles > div")
    assert sum(tile.rect["height"] for tile in tiles) < 844 / 3
    values = [item.rect["x"] for item in page.browser.find_elements("css selector", "dl.tiles dd")]
    assert max(values) - min(values) < 1


def test_figures_follow_the_ground_but_not_on_paper(page):
    for ground, turned in (("light", False), ("dark", True)):
        wish = {"media": "screen", "features": [{"name": "prefers-color-scheme", "value": ground}]}
        page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", wish)
        assert ("invert" in page.browser.execute_script(FIGURE)) == turned
    page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {**wish, "media": "print"})
    assert "invert" not in page.browser.execute_script(FIGURE)
    page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": []})


def test_printing_gives_whole_pages(page):
    printed = base64.b64decode(page.browser.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})["data"])
    assert printed.startswith(b"%PDF")
    assert printed.count(b"/Type /Page\n") <= 2  # what is folded away is not printed


def test_figures_keep_their_colours_on_paper(page):
    page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    kept = "return [...document.querySelectorAll('.course path, .floor path, .row rect, .key i')].map("
    kept += "(item) => getComputedStyle(item).printColorAdjust)"
    assert set(page.browser.execute_script(kept)) == {"exact"}
    page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": []})
