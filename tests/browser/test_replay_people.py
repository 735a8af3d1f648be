"""Pick-assist in a browser: pickers walk and pick beside robots, and can be pointed at, followed and found by keys."""

import pytest
from selenium.webdriver.common.keys import Keys

from tests.browser.pages import Page
from tests.world.test_pickers import ring


@pytest.fixture(scope="module")
def run():
    """A robot waits at 5 m from 5 on; he comes from 10 m at 15, picks until 22, and all is done at 81."""
    return ring(log="all")


def test_robot_that_waits_says_who_comes_and_the_picker_whom_he_goes_to(browser, tmp_path, run):
    page = Page(browser, run, tmp_path)
    legend = page.text("legend").splitlines()
    assert {"waiting for a picker", "picker, free", "picker, walking", "picker, picking"} <= set(legend)
    page.seek(10)
    robot, picker = page.ask("page.positions(10)")
    assert (robot, picker) == (pytest.approx([5, 0], abs=0.1), pytest.approx([7.5, 0], abs=0.1))
    page.tap(*page.ask("page.drawn()[0]"))
    page.frame()
    assert "waiting for a picker, picker 0 is walking until 00:15" in page.text("robot")
    page.press("f")
    page.frame()
    assert page.text("status") or page.text("said") == "Following picker 0"
    assert "Picker 0\n" in page.text("robot")
    assert "walking to robot 0 until 00:15" in page.text("robot")
    page.seek(18)
    page.frame()
    assert "picking into robot 0 until 00:22" in page.text("robot")
    page.seek(60)
    page.frame()
    assert "free" in page.text("robot")
    page.press(Keys.ESCAPE)
    assert page.complaints() == []


@pytest.mark.long  # every day without a browser, in tests/js
def test_page_without_pickers_has_none(browser, tmp_path):
    run = ring(log="all", pickers=None)
    page = Page(browser, run, tmp_path)
    assert "picker" not in page.text("legend")
    page.press("f", "f")
    page.frame()
    assert "Robot 0" in page.text("robot")
    assert page.complaints() == []
