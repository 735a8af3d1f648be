"""The replay page for everybody: keys alone, small screens, fingers, dark rooms, notebooks, and names of any kind."""

import pytest

import desim_warehouse as dw
from tests.browser.pages import READY, Page
from tests.report.replay.floors import busy, paper_run, people_run

SPACE, LEFT, UP, RIGHT, DOWN, TAB, ESCAPE, HOME, END, SHIFT = (
    "\ue00d", "\ue012", "\ue013", "\ue014", "\ue015", "\ue004", "\ue00c", "\ue011", "\ue010", "\ue008",
)  # fmt: skip
FOCUSED = (
    "const here = document.activeElement, style = getComputedStyle(here);"
    "return [here.id, style.outlineStyle, parseFloat(style.outlineWidth)]"
)
CONTROLS = (
    "return [...document.querySelectorAll('button:enabled, input, select, canvas[tabindex]')]"
    ".filter((item) => item.checkVisibility({ visibilityProperty: true })).map((item) => item.id)"
)

CUT = "return [...document.querySelectorAll('.tile p')].filter((p) => p.scrollWidth > p.clientWidth).length"
"""How many numbers of tiles are cut."""


@pytest.fixture
def page(browser, tmp_path):
    return Page(browser, paper_run(), tmp_path)


def test_every_control_is_reached_by_tab_and_shows_that_it_is(page):
    reached, controls = {}, set(page.browser.execute_script(CONTROLS))
    for _ in range(45):
        page.press(TAB)
        name, style, width = page.browser.execute_script(FOCUSED)
        reached[name] = (style, width)
        if controls <= set(reached):
            break
    assert controls <= set(reached)
    assert all(reached[name][0] != "none" and reached[name][1] >= 2 for name in controls)


def test_controls_have_names_for_those_who_cannot_see_them(page):
    nodes = page.browser.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    roles = {"button", "slider", "combobox", "spinbutton", "application"}
    names = [
        node["name"]["value"]
        for node in nodes
        if node.get("role", {}).get("value") in roles and not node.get("ignored")
    ]
    assert len(names) >= 15
    assert all(name.strip() for name in names)
    assert {"Play", "Story", "Heat map", "Zoom in", "Time"} <= set(names)


def test_the_keys_alone_will_do(page):
    page.press(SPACE)
    page.until("page.time() > 1")
    page.press(SPACE)
    time = page.ask("page.time()")
    assert time > 1
    page.pause(0.1)
    assert page.ask("page.time()") == time
    page.press(RIGHT)
    assert page.ask("page.time()") == round(time) + 1
    page.press(LEFT, LEFT)
    assert page.ask("page.time()") == pytest.approx(round(time) - 1, abs=0.02)
    page.press("n")
    assert page.ask("page.time()") == pytest.approx(page.ask("page.header.stops[0].time"))
    page.press(END)
    assert page.ask("page.time()") == pytest.approx(page.run.T, abs=0.05)
    page.press(HOME)
    assert page.ask("page.time()") == 0
    speed = page.ask("page.player.speed")
    page.press(UP)
    assert page.ask("page.player.speed") > speed
    page.press(DOWN)
    assert page.ask("page.player.speed") == speed


def test_keys_switch_views(page):
    for key, name in (("h", "heat"), ("d", "theme")):
        before = page.attribute(name, "aria-pressed")
        page.press(key)
        assert page.attribute(name, "aria-pressed") != before
    page.press("?")
    assert page.browser.find_element("id", "keys").is_displayed()
    page.press(ESCAPE)
    assert not page.browser.find_element("id", "keys").is_displayed()


def test_a_robot_that_is_followed_stays_in_the_middle(page):
    page.seek(100)
    page.press("f")
    page.frame()
    box = page.browser.execute_script(
        "const f = document.getElementById('floor'); return [f.clientWidth, f.clientHeight]"
    )
    for time in (100, 300, 700):
        page.seek(time)
        assert page.ask("page.drawn()[0]") == pytest.approx([box[0] / 2, box[1] / 2], abs=1)
    assert page.attribute("follow", "value") == "0"
    page.press("f")
    assert page.ask("page.chosen()") == 1
    page.press(ESCAPE)
    assert page.ask("page.chosen()") == -1


def test_zooming_and_moving_the_view_by_key_and_by_mouse(page):
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.actions.wheel_input import ScrollOrigin

    scale = page.ask("page.scale()")
    page.press("+")
    assert page.ask("page.scale()") > scale
    page.press("0")
    assert page.ask("page.scale()") == pytest.approx(scale)
    floor = page.browser.find_element("id", "floor")
    ActionChains(page.browser).scroll_from_origin(ScrollOrigin.from_element(floor), 0, -300).perform()
    assert page.ask("page.scale()") > scale
    page.frame()
    before = page.ask("page.drawn()[0]")
    ActionChains(page.browser).drag_and_drop_by_offset(floor, 60, 25).perform()
    page.frame()
    after = page.ask("page.drawn()[0]")
    assert [after[0] - before[0], after[1] - before[1]] == pytest.approx([60, 25], abs=2)


def test_two_fingers_zoom(page):
    scale = page.ask("page.scale()")

    def touch(kind, *points):
        fingers = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)]
        page.browser.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": fingers})

    touch("touchStart", (500, 300))
    touch("touchStart", (500, 300), (600, 300))
    touch("touchMove", (450, 300), (650, 300))
    touch("touchEnd")
    page.frame()
    assert page.ask("page.scale()") == pytest.approx(2 * scale, rel=0.2)


def test_pointing_at_a_robot_tells_what_it_does(page):
    from selenium.webdriver.common.action_chains import ActionChains

    page.seek(200)
    page.frame()
    x, y = page.ask("page.drawn()[0]")
    box = page.browser.find_element("id", "stage").rect
    ActionChains(page.browser).move_by_offset(0, 0).perform()
    page.browser.execute_cdp_cmd(
        "Input.dispatchMouseEvent", {"type": "mouseMoved", "x": box["x"] + 1 + x, "y": box["y"] + 1 + y}
    )
    page.frame()
    assert "Robot 0: driving loaded" in page.text("tip")
    assert "task 0, item 11" in page.text("tip")
    assert "battery" in page.text("tip")


@pytest.mark.parametrize(("width", "high"), [(360, 780), pytest.param(390, 844, marks=pytest.mark.long)])
def test_it_fits_a_phone(page, width, high):
    page.enlarge(width, high, deviceScaleFactor=2, mobile=True)
    assert page.browser.execute_script("return document.documentElement.scrollWidth") <= width
    heights = [item["bottom"] - item["top"] for item in boxes(page, "button, select")]
    assert min(heights) >= 44
    robots = page.ask("page.drawn()")
    assert all(0 < x < width for x, _ in robots)
    legend = boxes(page, "#legend li")
    assert len(legend) >= 8
    assert max(item["bottom"] for item in legend) <= high
    covered(page)
    # nor is anything covered with a robot's panel, the heat map and a message
    page.press("n", "n", "h")
    page.pause(0.1)
    assert page.browser.find_element("id", "robot").is_displayed()
    assert max(item["bottom"] for item in boxes(page, "#legend li")) <= high
    covered(page)
    assert page.browser.execute_script(CUT) == 0
    # each step of the scale stands beside its colour
    assert max(item["bottom"] - item["top"] for item in boxes(page, "#scale span")) < 24


@pytest.mark.parametrize(
    ("width", "high"),
    [(1400, 900), *(pytest.param(*size, marks=pytest.mark.long) for size in ((1024, 700), (390, 844)))],
)
def test_two_runs_fit_any_screen(browser, tmp_path, width, high):
    page = Page(browser, people_run(), tmp_path, beside=people_run())
    page.enlarge(width, high, mobile=width < 500)
    assert page.browser.execute_script("return document.documentElement.scrollWidth") <= width
    assert page.browser.execute_script(CUT) == 0
    assert max(item["bottom"] for item in boxes(page, "#legend li")) <= high
    assert len(boxes(page, ".stage")) == 2
    covered(page)


def boxes(page, selector):
    """Where the elements are that are shown, in the order of the page."""
    script = (
        "return [...document.querySelectorAll(arguments[0])].map((item) => item.getBoundingClientRect())"
        ".filter((box) => box.width && box.height)"
        ".map(({left, top, right, bottom}) => ({left, top, right, bottom}))"
    )
    return list(page.browser.execute_script(script, selector))


def covered(page):
    """No part of the page lies on another: floors, legend, notes, buttons, tiles, panel and tables."""
    parts = boxes(
        page,
        ".stage, h1, .caption, #legend li, #scale, #said, #course, button:not(.link), select, output, .tile, #stations",
    )
    parts = [box for box in parts if box["bottom"] - box["top"] > 1]
    panel = boxes(page, "#robot")
    for i, one in enumerate(parts):
        for other in parts[:i]:
            wide = min(one["right"], other["right"]) - max(one["left"], other["left"])
            high = min(one["bottom"], other["bottom"]) - max(one["top"], other["top"])
            assert wide <= 1 or high <= 1, (one, other)
    tiles = boxes(page, ".tile, .stage, #legend")
    assert all(
        box["bottom"] <= item["top"] + 1
        or item["bottom"] <= box["top"] + 1
        or box["right"] <= item["left"] + 1
        or item["right"] <= box["left"] + 1
        for box in panel
        for item in tiles
    )


@pytest.mark.parametrize(("wish", "dark"), [("dark", True), pytest.param("light", False, marks=pytest.mark.long)])
def test_it_is_dark_or_light_as_the_reader_wishes(page, wish, dark):
    feature = {"features": [{"name": "prefers-color-scheme", "value": wish}]}
    page.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", feature)
    page.frame()
    page.frame()

    def shade():
        return sum(page.pixel(3, 3))

    assert (shade() < 200) is dark
    assert page.attribute("theme", "aria-pressed") == ("true" if dark else "false")
    page.click("theme")
    page.frame()
    assert (shade() < 200) is not dark


HOSTILE = '</script><script>window.hacked = 1</script><img src=x onerror="window.hacked = 2">\'&amp;'
HEBREW = "מחסן <b>"


def hostile_run():
    """A line and a way back, whose nodes and parts have names made to break pages."""
    nodes = {HOSTILE: [0.0, 0.0], HEBREW: [10.0, 0.0], "\u2028`${1}`": [10.0, 6.0], "'\"\\": [0.0, 6.0]}
    names = list(nodes)
    changes = {
        "name": HOSTILE + HEBREW,
        "description": HOSTILE,
        "units": {"length": "<b>", "time": "'\"</script>"},
        "layout": {
            "nodes": nodes,
            "edges": [[a, b] for a, b in zip(names, names[1:] + names[:1], strict=True)],
            "storage": [{"edge": [names[1], names[2]], "offset": 3.0}],
            "bays": {HOSTILE: {"at": [HOSTILE]}},
        },
        "fleet": {"size": 1, "robot": {"radius": 0.4, "speed": 1.5}},
    }
    model = busy(**changes)
    del model["run"]
    model["tasks"] = {"goods": [0, 0], "unload_at": [names[3]], "load_time": 1.0, "unload_time": 1.0}
    return dw.simulate(dw.load(model))


def test_names_are_shown_as_text_whatever_they_are(browser, tmp_path):
    run = hostile_run()
    page = Page(browser, run, tmp_path)
    assert browser.execute_script("return window.hacked") is None
    assert browser.title == " ".join(f"{run.model.name}: replay".split())
    assert browser.find_element("id", "name").get_attribute("textContent") == run.model.name
    assert browser.execute_script("return document.querySelectorAll('bdi#name > *, img').length") == 0
    box = browser.find_element("id", "stage").rect
    texts = []
    page.seek(run.T)
    for node in range(4):
        x, y = page.ask("page.screen(...page.header.nodes[arguments[0]].slice(1))", node)
        point = {"type": "mouseMoved", "x": box["x"] + 1 + x, "y": box["y"] + 1 + y}
        browser.execute_cdp_cmd("Input.dispatchMouseEvent", point)
        page.frame()
        texts.append(browser.find_element("id", "tip").get_attribute("textContent"))
    assert all(f"Node {name}" in text for name, text in zip(run.layout.graph.nodes, texts, strict=True))
    page.press("n", "h", "f")
    page.frame()
    assert browser.execute_script("return window.hacked") is None
    assert page.complaints() == []
    assert page.requests() == []


def test_a_notebook_shows_it_in_a_frame(browser, tmp_path):
    notebook = tmp_path / "notebook.html"
    notebook.write_text(
        f"<!DOCTYPE html><meta charset='utf-8'><body>{paper_run().replay()._repr_html_()}</body>", "utf-8"
    )
    browser.get_log("browser")
    browser.get(notebook.as_uri())
    browser.switch_to.frame(browser.find_element("css selector", "iframe"))
    assert isinstance(browser.execute_async_script(READY), int | float)
    assert browser.execute_script("return desimReplay.positions(100).length") == 6
    browser.switch_to.default_content()
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []
