"""What somebody takes to the boss: a page as its browser prints it."""

import base64

import pytest

import desim_warehouse as dw
from tests.browser.pages import Opened, Page
from tests.browser.pdf import pages
from tests.browser.test_axe import kept_answer
from tests.report.replay.floors import busy_run, people_run

MOST_BYTES = 40_000
"""Of the page of an answer."""


def sheets(browser):
    """The text of each page as it is printed, without spaces."""
    return pages(base64.b64decode(browser.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})["data"]))


@pytest.mark.long  # every day the answer of a plan
@pytest.mark.parametrize("beside", [people_run, None])
def test_a_replay_is_one_sheet(browser, tmp_path, beside):
    Page(browser, busy_run(), tmp_path, beside=beside and beside())
    assert len(sheets(browser)) == 1


def test_the_answer_of_a_plan_is_one_sheet_for_the_boss(browser, tmp_path):
    """The decision is its title, the demands are side by side; the day stands beside the floor, with how sure it is."""
    page = Opened(browser, kept_answer("plan", tmp_path))
    answer = dw.load_answer(tmp_path)
    assert (tmp_path / "page.html").stat().st_size <= MOST_BYTES
    [sheet] = sheets(browser)
    each = [line for line in answer.answer if "shown to be enough" in line]
    on_sheet = [part for part in answer.tables if part.on_sheet]
    nearly = [bar.text for figure in answer.nearest for bar in figure.rows]
    rows = [cell for part in on_sheet for row in part.rows for cell in row]
    assert (len(each), len(nearly), len(on_sheet)) == (2, 4, 2)
    for text in (answer.name, answer.question, *each, *nearly, *rows, answer.promise):
        assert "".join(text.split()) in sheet
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    page.enlarge(673, 1017)  # A4 without its margins
    course, floor = (page.browser.find_element("class name", name).rect for name in ("course", "floor"))
    assert course["x"] + course["width"] <= floor["x"]
    first, *others = browser.find_elements("css selector", "ul.answers li")
    size = "return parseFloat(getComputedStyle(arguments[0]).fontSize)"
    assert browser.execute_script(size, first) > max(browser.execute_script(size, line) for line in others)
    assert page.browser.find_element("css selector", "details.sure p").rect["height"] > 0
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": []})
