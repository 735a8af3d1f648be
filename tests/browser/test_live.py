"""The live page in a real browser, state by state."""

import json
import shutil
from contextlib import contextmanager
from importlib.resources import files
from time import monotonic

import pytest

import desim_warehouse as dw
from tests.browser.pages import Opened
from tests.browser.test_axe import AXE, EVERY

TUTORIAL = "models/tutorial.yaml"
TARGET = "T <= 6 min"  # three robots meet it, two do not
HOME, LEFT, RIGHT = "\ue011", "\ue012", "\ue014"
SLIDE = (
    "const [id, place] = arguments, field = document.getElementById(id); field.value = place;"
    "field.dispatchEvent(new Event('input'))"
)
UNTIL = """
const done = arguments[0], since = performance.now();
const test = (live) => { try { return Boolean(TEST); } catch { return false; } };
const look = () => test(window.desimLive?.live) || performance.now() - since > 20000
  ? done(test(window.desimLive?.live)) : setTimeout(look, 20);
look()
"""
SAID = "live.state === 'done' && document.getElementById('said').textContent.includes(WORDS)"


STILL = ({"name": "prefers-reduced-motion", "value": "reduce"},)


class LivePage(Opened):
    """A live page that is open; its reader wishes to see nothing move, unless that is what is tested."""

    def __init__(self, browser, address, wishes=STILL):
        browser.get("about:blank")  # an address that differs only behind the # loads nothing
        self.wishes = wishes
        super().__init__(browser, address)

    def slide(self, rank, place):
        self.browser.execute_script(SLIDE, f"knob-{rank}", place)

    def until(self, test):
        assert self.browser.execute_async_script(UNTIL.replace("TEST", test)), test

    def done(self, words):
        """Wait until a design is done, which begins with these words."""
        self.until(SAID.replace("WORDS", json.dumps(words)))

    def ask(self, expression):
        return self.browser.execute_script(f"const live = window.desimLive.live; return {expression}")

    def chips(self):
        return [text.replace("\n", " ") for text in self.browser.execute_script(CHIPS)]


CHIPS = "return [...document.querySelectorAll('#chips button')].map((one) => one.innerText)"
"""What was tried, read at once: the list is made anew with each answer."""


@contextmanager
def serving(out, model=TUTORIAL, **options):
    with dw.serve(model, out=out, **{"workers": 1, "target": TARGET, **options}) as live:
        yield live


@pytest.fixture(scope="module")
def live(tmp_path_factory):
    vary = {"fleet.size": [1, 2, 3, 4, 5], "battery.consumption": [10], "policies.allocation": None}
    with serving(tmp_path_factory.mktemp("live"), vary=vary) as made:
        yield made


@pytest.fixture
def page(browser, live):
    opened = LivePage(browser, live.address)
    opened.until("live.answer")
    return opened


def test_runs_come_in_until_the_verdict_is_clear(page):
    page.slide(0, 3)  # others ask for more runs of 3 robots
    page.done("with 4 robots")
    assert page.text("verdict") == "Target met"
    assert "done: the verdict is clear" in page.text("live")
    assert "Target: task time at most 6 min" in page.text("more")
    dots = page.browser.find_elements("css selector", "#funnel .dot")
    assert len(dots) == page.ask("live.answer.n") > 1
    assert page.attribute("funnel", "aria-label").startswith("Task time: 5.")
    assert page.complaints() == []
    assert [url for url in page.requests() if not url.startswith("http://127.0.0.1:")] == []


def test_a_slider_that_moves_makes_numbers_old_until_the_hand_calculation_and_runs_come(page):
    page.done("3 robots")
    page.browser.execute_script(
        "window.seen = []; new MutationObserver(() => seen.push([document.body.className,"
        "document.getElementById('verdict').textContent, document.getElementById('said').textContent])).observe("
        "document.getElementById('said'), {childList: true})"
    )
    page.slide(0, 0)
    page.done("with 1 robot.")
    seen = page.browser.execute_script("return seen")
    assert ["stale", "Quick estimate", "1 robot can do about 87 tasks an hour, limited by the robots."] in seen
    assert page.text("verdict") == "Not met"


def test_keys_move_sliders_pin_and_stop(page):
    page.done("3 robots")
    page.browser.find_element("tag name", "body").send_keys("p")
    assert page.text("pin") == "Unpin"
    page.browser.find_element("id", "knob-0").send_keys(HOME, RIGHT)
    page.done("2 robots")
    assert "pinned 3" in page.text("knob-0-value")
    assert "Pinned: Task time " in page.text("more")
    assert "Difference, run by run: 1." in page.text("more")
    assert page.browser.find_elements("css selector", "#funnel circle.pinned")
    assert "pinned" in " ".join(page.chips())


@pytest.mark.long
def test_a_click_on_a_design_that_was_tried_goes_back(page):
    page.done("3 robots")
    page.slide(0, 3)
    page.done("4 robots")
    asked = page.ask("live.answer.n")
    chip = "[...document.querySelectorAll('#chips button')].find((one) => one.textContent.includes('3 robots'))"
    page.browser.execute_script(f"{chip}.click()")
    page.done("3 robots")
    assert page.ask("live.knobs.levels['fleet.size']") == 3
    assert asked


def test_a_design_that_cannot_run_says_why_and_the_last_answer_stays(page):
    page.done("3 robots")
    page.slide(1, 1)
    page.until("live.state === 'refused'")
    assert "BATTERY_TOO_SMALL" in page.text("note")
    assert page.text("said").endswith(" with 3 robots.")
    assert page.text("verdict") == "Target met"
    assert "wrong" in page.browser.find_element("css selector", "[data-key='battery.consumption']").get_attribute(
        "class"
    )
    page.slide(1, 0)
    page.done("3 robots")
    assert not page.browser.find_element("id", "note").is_displayed()


@pytest.mark.long
def test_as_many_runs_more_and_stop(page):
    page.slide(0, 4)
    page.done("5 robots")
    before = page.ask("live.answer.n")
    page.click("stop")
    page.until(f"live.answer.n > {before}")
    page.done("5 robots")
    assert page.ask("live.answer.n") == before + 35


@pytest.mark.long  # every day six moves without a browser, in tests/live
def test_of_fifty_moves_in_five_seconds_the_last_wins_and_nothing_is_left_behind(page, live):
    page.done("3 robots")
    knob, begin = page.browser.find_element("id", "knob-0"), monotonic()
    knob.send_keys(HOME, *(RIGHT if move % 6 < 3 else LEFT for move in range(49)))
    assert monotonic() - begin < 5
    page.done("2 robots")
    assert page.ask("live.knobs.levels['fleet.size']") == 2
    page.until("live.floorOf === live.answer.id")  # what was simulated last
    with live.desk.lock:
        assert (len(live.desk.listeners), live.desk.of) == (2, {})  # this page, and the design of today


@pytest.mark.long
def test_two_tabs_see_the_same_designs(browser, page, live):
    page.done("3 robots")
    first = browser.current_window_handle
    browser.switch_to.new_window("tab")
    try:
        second = LivePage(browser, live.address)
        second.until("live.answer")
        second.browser.execute_script(SLIDE, "knob-2", 1)
        second.until("live.state === 'done' && live.answer.tried[0].words.includes('auction')")
        browser.switch_to.window(first)
        page.until("live.answer.tried.some((one) => one.words.includes('auction'))")
        browser.switch_to.window(browser.window_handles[1])
        browser.close()
    finally:
        browser.switch_to.window(first)


def test_the_floor_shows_robots_of_the_design(browser, live):
    page = LivePage(browser, live.address, wishes=())
    page.done("3 robots")
    page.until("live.watch.side && live.floorOf === live.answer.id")
    assert page.ask("live.watch.side.header.radii.length") == 3
    first = page.ask("live.watch.player.time")
    page.until(f"live.watch.player.time !== {first}")


def test_the_target_can_be_moved_and_the_slider_wears_the_verdicts_of_what_was_tried(page):
    page.done("3 robots")
    page.browser.execute_script(SLIDE, "target", 3)
    page.until("live.answer.verdict === 'not met' && live.target === 3")
    assert page.text("verdict") == "Not met"
    worn = "[...document.querySelectorAll('[data-key=\"fleet.size\"] .worn')].map((one) => one.className)"
    page.until(f"{worn}.some((kinds) => kinds.includes('not-met'))")


@pytest.mark.long
def test_names_stay_text_and_a_design_that_falls_behind_says_so(browser, tmp_path):
    hostile = "<img src=x onerror=alert(1)>"
    base = dw.load("models/people.yaml", {"name": hostile, "fleet.size": 1})
    with serving(tmp_path, base, target="throughput_per_hour >= 100", vary={"fleet.size": [1, 6]}) as live:
        page = LivePage(browser, live.address)
        page.until("live.answer?.verdict === 'overloaded' && live.state === 'done'")
        assert page.text("name") == hostile
        assert page.text("verdict") == "Cannot keep up"
        assert page.text("said").startswith("Only ")
        assert page.text("said").endswith(" loads an hour delivered with 1 robot.")
        assert page.ask("live.answer.n") in range(5, 14)  # runs under way may end, too
        assert page.complaints() == []


@pytest.mark.parametrize("back", [False, pytest.param(True, marks=pytest.mark.long)])
def test_without_its_server_the_page_stays_readable_and_goes_on_when_it_is_back(page, live, browser, tmp_path, back):
    page.done("3 robots")
    shutil.copy(live.folder / "runs.jsonl", tmp_path)
    with serving(tmp_path, vary=["fleet.size"]) as own:
        page = LivePage(browser, own.address)
        page.done("3 robots")
        sentence, port, token = page.text("said"), own.port, own.token
    page.until("live.state === 'offline'")
    assert "Connection lost." in page.text("note")
    assert page.text("said") == sentence
    assert page.ask("[...document.querySelectorAll('#knobs input')].every((field) => field.disabled)")
    if not back:
        return
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("secrets.token_urlsafe", lambda *_: token)
        with serving(tmp_path, vary=["fleet.size"], port=port):
            page.done("3 robots")
            assert not page.browser.find_element("id", "note").is_displayed()


@pytest.mark.parametrize(
    ("width", "scheme"),
    [(390, "light"), *(pytest.param(1400, scheme, marks=pytest.mark.long) for scheme in ("light", "dark"))],
)
def test_axe_finds_nothing_and_nothing_is_wider_than_the_screen(page, width, scheme):
    page.browser.execute_cdp_cmd(
        "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    )
    page.enlarge(width, 900)
    page.done("3 robots")
    script = files("axe_core_python").joinpath("axe.min.js").read_text("utf-8")
    page.browser.execute_cdp_cmd("Runtime.evaluate", {"expression": script})
    violations = page.browser.execute_async_script(AXE, EVERY)
    assert [(one["id"], one["nodes"][0]["html"][:100]) for one in violations] == []
    assert page.browser.execute_script("return document.documentElement.scrollWidth") <= width
