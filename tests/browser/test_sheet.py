"""What somebody takes to the boss: a page as its browser prints it."""

import base64

import pytest

from tests.browser.pages import Opened, Page
from tests.browser.test_axe import kept_answer
from tests.report.replay.floors import busy_run, people_run


def sheets(browser):
    printed = base64.b64decode(browser.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})["data"])
    return printed.count(b"/Type /Page\n")


@pytest.mark.parametrize("beside", [people_run, pytest.param(None, marks=pytest.mark.long)])
def test_a_replay_is_one_sheet(browser, tmp_path, beside):
    Page(browser, busy_run(), tmp_path, beside=beside and beside())
    assert sheets(browser) == 1


def test_the_answer_of_a_plan_is_one_sheet_for_the_boss(browser, tmp_path):
    """The decision is its title, the demands are side by side; the day stands beside the floor, with how sure it is."""
    page = Opened(browser, kept_answer("plan", tmp_path))
    assert sheets(browser) == 1
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    page.enlarge(673, 1017)  # A4 without its margins
    course, floor = (page.browser.find_element("class name", name).rect for name in ("course", "floor"))
    assert course["x"] + course["width"] <= floor["x"]
    first, *others = browser.find_elements("css selector", "ul.answers li")
    size = "return parseFloat(getComputedStyle(arguments[0]).fontSize)"
    assert browser.execute_script(size, first) > max(browser.execute_script(size, line) for line in others)
    assert page.browser.find_element("css selector", "details.sure p").rect["height"] > 0
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": []})
