"""The what-if page in a browser: sliders, the pinned option, and names as text, without a network."""

import pytest

import desim_warehouse as dw
from tests.browser.test_live import HOME, RIGHT, LivePage

HOSTILE = "<img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Three fleets with two ways of dispatching."""
    path = tmp_path_factory.mktemp("page") / "page.html"
    factors = {"fleet.size": [1, 2, 3], "policies.allocation": ["in-order", "nearest"]}
    changes = {"tasks.goods": {"random": 4}, "name": HOSTILE}
    dw.what_if_page(dw.Study("models/multibots.yaml", factors, changes=changes, replications=3).run().results, path)
    return path


@pytest.fixture
def page(browser, made):
    opened = LivePage(browser, made.as_uri())
    opened.until("live.state === 'done'")
    return opened


def test_a_slider_and_a_list_choose_the_option(page):
    page.browser.find_element("id", "knob-0").send_keys(HOME, RIGHT)
    page.done("with 2 robots, dispatching: ")
    page.browser.execute_script(
        "const field = document.getElementById('knob-1'); field.value = 1; field.dispatchEvent(new Event('input'))"
    )
    page.done("with 2 robots, dispatching: nearest.")
    assert page.text("name") == HOSTILE
    assert len(page.browser.find_elements("css selector", "#funnel .dot")) == 3
    assert "Difference, run by run: " in page.text("more")
    assert page.complaints() == []
    assert page.requests() == []


def test_the_pinned_option_can_be_changed(page):
    assert "pinned 1" in page.text("knob-0-value")
    page.click("pin")
    assert page.text("pin") == "Unpin"
    page.browser.find_element("id", "knob-0").send_keys(HOME)
    page.done("with 1 robot, ")
    assert "pinned 3" in page.text("knob-0-value")


def test_what_needs_a_server_is_not_there(page):
    for name in ("share", "stop", "floorbox"):
        assert not page.browser.find_element("id", name).is_displayed()
