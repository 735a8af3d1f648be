"""The replay page in a real browser: it plays the log, by mouse and by keyboard, and asks nothing of the network."""

import math
import re

import numpy as np
import pytest
from PIL import Image

import desim_warehouse as dw
from desim_warehouse.answer import numbers, words
from desim_warehouse.outcome.chains import QUEUES, TRAFFIC
from desim_warehouse.outcome.halts import halts
from desim_warehouse.outcome.pieces import pieces
from desim_warehouse.outcome.positions import Positions
from desim_warehouse.outcome.resources import resources
from tests.browser.pages import READY, Opened, Page
from tests.daily import some
from tests.report.replay.floors import (
    RUNS,
    WALLS,
    busy,
    busy_run,
    due_run,
    grid_run,
    jammed_run,
    paper_run,
    people_run,
    spurs_run,
)
from tests.run.halls import RING
from tests.run.test_halts import LOW_TOGETHER

ESCAPE = "\ue00c"


@pytest.fixture
def page(browser, tmp_path):
    return Page(browser, paper_run(), tmp_path)


def waits(run):
    """Begin, end and robot of all collisions."""
    return [(row[0] - row[6], row[0], row[2]) for row in run.record.rows if row[1] == "collision"]


@pytest.mark.parametrize("name", some(RUNS, 12))
def test_it_loads_and_plays_offline_without_a_complaint_or_a_request(browser, tmp_path, name):
    page = Page(browser, RUNS[name](), tmp_path)
    for button in ("heat", "theme", "help", "play"):
        page.click(button)
    page.pause(0.3)
    page.click("play")
    page.frame()
    assert page.complaints() == []
    assert page.requests() == []


@pytest.mark.parametrize("name", some(RUNS, 5))
def test_robots_are_drawn_within_a_pixel_of_where_the_log_has_them(browser, tmp_path, name):
    run = RUNS[name]()
    page, where = Page(browser, run, tmp_path), Positions(run.history)
    scale = page.ask("page.scale()")
    times = np.random.default_rng(20).uniform(0, run.record.end, 20).tolist()
    shown = page.ask("arguments[0].map((time) => [page.positions(time), page.drawn()])", times)
    for time, (positions, drawn) in zip(times, shown, strict=True):
        expected = where.points(time)
        assert np.abs(np.array(positions) - expected).max() * scale < 1
        assert np.ptp(np.array(drawn) / scale - expected, axis=0).max() * scale < 1


def test_closed_edges_and_people_are_drawn_and_a_robot_says_what_it_waits_for(browser, tmp_path):
    run = people_run()
    page = Page(browser, run, tmp_path)
    assert {"closed", "person in the aisle"} <= set(page.text("legend").splitlines())
    for cause, reason in (("waiting_closed", "for a lane to open"), ("waiting_person", "for a person")):
        wait = max((one for one in run.history.waits if one.cause == cause), key=lambda one: one.end - one.start)
        time = (wait.start + wait.end) / 2
        page.ask("page.positions(arguments[0])", time)
        now = [one for one in run.history.blocked if one.start <= time < one.end]
        assert sorted(page.ask("page.blocked()")) == sorted([*one.edge, one.visit >= 0] for one in now)
        page.tap(*page.ask("page.drawn()")[wait.robot])
        assert re.search(rf"waits \S+ \w+(?: \d+ s)? {reason} until \d\d:\d\d", page.text("robot"))
        page.press(ESCAPE)
    assert page.complaints() == []


def test_what_is_drawn_is_on_the_canvas_in_the_colour_of_its_state(page):
    colours = {"empty": [0, 98, 163], "loaded": [213, 94, 0]}
    seen = set()
    page.enlarge(2000, 1600)
    radius = 12.5 * page.ask("page.scale()")
    for time in (200, 300, 560, 800):
        page.seek(time)
        headings = Positions(page.run.history).headings(time)
        for (x, y), state, heading in zip(page.ask("page.drawn()"), page.ask("page.states()"), headings, strict=True):
            if state in colours:
                beside = 0.77 * radius  # clear of number, square, head and rim
                colour = page.pixel(x - beside * math.sin(heading), y + beside * math.cos(heading))
                assert colour == pytest.approx(colours[state], abs=30)
                seen.add(state)
    assert seen == set(colours)


def test_a_two_way_lane_is_one_line_with_its_present_direction(browser, tmp_path):
    run = spurs_run()
    page, where = Page(browser, run, tmp_path), Positions(run.history)
    # those of the trunk, not the two lanes side by side
    pairs = [[where.edges.source[edge] for edge in pair] for pair in page.ask("page.header.two_way")]
    assert sorted(pairs) == [["a", "b"], ["b", "c"], ["b", "shelf"], ["c", "pack"]]
    edges, seen = list(run.layout.graph.edges), set()
    times = np.linspace(20, run.record.end, 60).tolist()
    shown = page.ask("arguments[0].map((time) => (page.seek(time), page.directions()))", times)
    for time, directions in zip(times, shown, strict=True):
        on = [edges[edge] for edge in where.at(time)[0] if edge < len(edges)]
        used = {edge for edge in on if run.layout.graph.edges[edge]["two_way"]}
        assert {tuple(edge) for edge in directions} == used
        assert not any(edge[::-1] in used for edge in used)
        seen |= used
    assert len(seen) == 8  # every lane in both directions, at one time or another
    assert "two-way lane, free" in page.text("legend")


def test_on_a_grid_shelves_cells_with_goods_and_aisles_are_told_apart(browser, tmp_path):
    run = grid_run()
    page, graph = Page(browser, run, tmp_path), run.layout.graph
    assert "no lane: shelf or wall" in page.text("legend")
    page.seek(run.record.end)  # everything is fetched, and the robots are in their bays
    stores = {place.edge[0] for place in run.layout.storage}
    zones = {*run.layout.bays, *run.layout.stations}
    off = 0.35  # of a cell: beside the lanes that meet in its middle

    def colours(places):
        at = page.ask("arguments[0].map((at) => page.screen(...at))", [(x + off, y + off) for x, y in places])
        return set(map(tuple, page.pixels(at)))

    cells = {node: (data["x"], data["y"]) for node, data in graph.nodes(data=True)}
    painted = [
        colours([place for node, place in cells.items() if node in stores]),
        colours([place for node, place in cells.items() if node not in stores | zones]),
        colours([(float(x), float(y)) for x, y in WALLS]),
    ]
    assert [len(one) for one in painted] == [1, 1, 1]
    light, lightest, dark = (sum(next(iter(one))) for one in painted)
    assert lightest > light + 30 > dark + 60


@pytest.mark.long  # every day by keys alone, in test_replay_reach.py
def test_playing_moves_robots_and_pausing_stops_them(page):
    before = page.ask("page.drawn()")
    page.click("play")
    page.until("page.time() > 5")
    page.click("play")
    page.frame()
    after, time = page.ask("page.drawn()"), page.ask("page.time()")
    assert time > 5
    assert all(math.dist(a, b) > 1 for a, b in zip(before, after, strict=True))
    page.pause(0.2)
    assert page.ask("page.time()") == time
    assert page.ask("page.drawn()") == after


def test_a_run_plays_to_its_end_and_again_from_its_start(page):
    page.seek(page.run.T - 1)
    page.browser.find_element("css selector", "#speed option:last-child").click()
    page.click("play")
    page.until("!page.player.playing")
    page.frame()
    assert page.ask("page.time()") == pytest.approx(page.run.T, abs=0.1)
    assert page.attribute("play", "aria-label") == "Play"
    page.browser.find_element("css selector", "#speed option").click()
    page.click("play")
    page.until("page.time() > 0 && page.time() < page.header.end / 2")
    assert page.ask("page.time()") < page.run.T / 2
    assert page.ask("page.player.playing")


def test_scrubbing_moves_robots(page):
    from selenium.webdriver.common.action_chains import ActionChains

    before = page.ask("page.drawn()")
    slider = page.browser.find_element("id", "scrub")
    ActionChains(page.browser).move_to_element(slider).click().perform()
    page.frame()
    assert page.ask("page.time()") == pytest.approx(page.run.T / 2, rel=0.05)
    assert all(math.dist(a, b) > 5 for a, b in zip(before, page.ask("page.drawn()"), strict=True))
    assert "step" in page.attribute("scrub", "aria-valuetext")


def test_a_click_on_the_course_of_the_run_moves_the_floor_there(page):
    before, run = page.ask("page.drawn()"), page.run
    plot = page.browser.find_element("css selector", "#course .plot").rect
    at = {"x": plot["x"] + plot["width"] / 2, "y": plot["y"] + 5, "button": "left", "clickCount": 1}
    page.browser.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": "mousePressed", **at})
    page.browser.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": "mouseReleased", **at})
    page.frame()
    assert page.ask("page.time()") == pytest.approx(run.T / 2, rel=0.01)
    assert all(math.dist(a, b) > 5 for a, b in zip(before, page.ask("page.drawn()"), strict=True))
    line = page.browser.find_element("css selector", "#course .now").rect
    assert line["x"] + 1 == pytest.approx(at["x"], abs=1)
    slider = page.browser.find_element("id", "scrub").rect  # its thumb, 16 wide, stands above the line
    assert slider["x"] + 8 == pytest.approx(plot["x"], abs=1)
    assert slider["width"] - 16 == pytest.approx(plot["width"], abs=1)


def test_the_standstill_of_a_run_is_the_first_stop_of_its_story(browser, tmp_path):
    run = dw.simulate(dw.load(RING, {**LOW_TOGETHER, "run.length": "2 h"}), 1)
    page = Page(browser, run, tmp_path)
    page.click("story")
    page.frame()
    longest = max(halts(run.history), key=lambda halt: halt.end - halt.start)
    assert longest.start < page.ask("page.time()") < longest.end
    assert page.text("said").startswith("Deliveries stood still from ")
    assert page.text("said") in page.text("course")
    assert "nothing delivered" in page.text("course")


SAID_ALIKE = {"count", "share", "lost", "chargers", "time"}
"""Forms of tiles whose text is that of the run's own table, in the same unit and digits."""


@pytest.mark.parametrize("name", some([*RUNS, "due"], 6))
def test_the_tiles_end_with_the_indicators_of_the_run(browser, tmp_path, name):
    run = {**RUNS, "due": due_run}[name]()
    page = Page(browser, run, tmp_path)
    page.seek(run.record.end)
    tiles, header = page.ask("page.tiles()"), page.ask("page.header")
    near = {"share": 1e-6, "time": header["tick"], "rate": 1e-6, "lost": 1e-6, "chargers": 1e-3}
    for key, _, form, _ in header["tiles"]:
        if key != "battery":
            assert tiles[key] == pytest.approx(run.kpis[key], abs=near.get(form, 0))
    texts = {
        key: words.value(key, run.kpis[key], run.model) for key, _, form, _ in header["tiles"] if form in SAID_ALIKE
    }
    assert texts
    assert texts == {key: page.indicator(key) for key in texts}


ROWS = "return [...document.querySelectorAll('#stations tbody tr')].map((row) => row.innerText)"


def test_stations_and_chargers_show_who_queues_and_how_much_they_are_used(browser, tmp_path):
    run = busy_run()
    page, expected = Page(browser, run, tmp_path), resources(run.history)
    for time in (200.0, 550.0, run.record.end):
        page.seek(time)
        drawn = page.ask("page.resources()")
        rows = page.browser.execute_script(ROWS)
        assert len(drawn) == len(rows) == len(expected) == 8
        for item, row, one in zip(drawn, rows, expected, strict=True):
            used = one.utilisation(run.history.begin, time)
            queue = one.queue[1][np.searchsorted(one.queue[0], time, side="right") - 1]
            assert (item["kind"], item["node"], item["queue"]) == (one.kind, one.node, queue)
            assert item["utilisation"] == pytest.approx(used, abs=1e-3)
            assert one.zone in row
            assert f"{round(100 * used)} %" in row or used < 0.1
    assert max(item["queue"] for item in drawn) >= 0


def test_the_heat_map_has_the_part_of_the_time_that_was_lost_where_robots_stood(browser, tmp_path):
    run = busy_run()
    page = Page(browser, run, tmp_path)
    page.click("heat")
    page.seek(run.record.end)
    begin, end = run.record.begin, run.record.end
    expected = dict.fromkeys(run.layout.graph.edges, 0.0)
    for wait in run.history.waits:
        if wait.on is not None:
            expected[wait.on] += max(min(wait.end, end) - max(wait.start, begin), 0.0)
    shares = [time / (end - begin) for time in expected.values()]
    assert max(shares) > 0.01
    assert page.ask("page.heat()") == pytest.approx(shares, abs=1e-3)
    assert page.text("scale").split(":")[1].split("\n") == ["", "1 to 5 %", "5 to 20 %", "over 20 %", "no colour"]


def test_words_about_a_moment_go_when_the_clock_leaves_it(browser, tmp_path):
    page = Page(browser, busy_run(), tmp_path)
    page.press("n")
    page.frame()
    assert " the busiest, " in page.text("said")
    page.seek(page.ask("page.time()") + 60)
    page.frame()
    assert page.text("said") == ""


def test_a_page_in_a_hidden_frame_loads_without_a_complaint(browser, tmp_path):
    busy_run().replay(tmp_path / "replay.html")
    outer = tmp_path / "outer.html"
    outer.write_text('<iframe src="replay.html" style="display: none"></iframe>', encoding="utf-8")
    opened = Opened(browser, outer)
    browser.switch_to.frame(0)
    try:
        assert isinstance(browser.execute_async_script(READY), int | float)
        assert opened.complaints() == []
    finally:
        browser.switch_to.default_content()


@pytest.mark.parametrize("make", some([jammed_run, paper_run, busy_run], 3))
def test_the_story_stops_where_it_says_and_ends_with_the_totals(browser, tmp_path, make):
    page = Page(browser, make(), tmp_path)
    stops = page.ask("page.header.stops")
    for stop in stops:
        page.press("n")
        page.frame()
        status = page.browser.find_element("id", "status").get_attribute("textContent")
        assert status.startswith(stop["said"])
        if stop["time"] is None:
            continue
        assert page.ask("page.time()") == pytest.approx(stop["time"], abs=1e-6)
        box = page.browser.find_element("id", "floor").rect
        for robot in stop.get("robots", []):
            x, y = page.ask(f"page.drawn()[{robot}]")
            assert 0 < x < box["width"]
            assert 0 < y < box["height"]
        if len(stop.get("robots", [])) == 1:
            assert f"{stop['said']} It waits " in status
    assert stops[-1]["said"].startswith("In all: ")
    assert page.text("counted").startswith("Totals for the whole run")
    page.press("n")
    assert page.ask("page.time()") < page.run.record.end


def test_a_click_pins_the_panel_of_a_robot(browser, tmp_path):
    run = paper_run()
    page = Page(browser, run, tmp_path)
    page.seek(200)
    robot = page.ask("page.states()").index("loaded")
    page.tap(*page.ask("page.drawn()[arguments[0]]", robot))
    panel = page.browser.find_element("id", "robot")
    assert panel.is_displayed()
    assert page.ask("page.chosen()") == robot
    tasks = [one for one in run.history.assignments if one.robot == robot and one.start <= 200 < one.end]
    task = run.history.tasks[tasks[0].task]
    assert f"Robot {robot}" in panel.text
    assert "driving loaded" in panel.text
    assert f"Task {task.number}, item {task.good}, to \u2068{task.station}\u2069" in panel.text
    assert re.search(r"Battery \d+ %", panel.text)
    # the route is where it drives until it unloads
    route = page.ask("page.route()")
    until = next(span.end for span in run.history.states[robot] if span.start <= 200 < span.end)
    entered = [row.edge for row in run.history.rows("enter") if row.robot == robot and 200 < row.time <= until]
    assert [edge[0] for edge in entered if edge] == route[: len(entered)]
    assert route[-1] == task.station
    assert all(name in panel.text for name in (route[0], route[-1]))
    # it stays when time goes on and tells the news; a click beside robots closes it
    page.seek(until + 1)
    assert panel.is_displayed()
    assert "unloading" in panel.text
    page.tap(3, 3)
    assert not panel.is_displayed()


def test_two_runs_play_side_by_side_on_one_clock(browser, tmp_path):
    run = paper_run()
    other = dw.simulate(dw.load("models/multibots.yaml", {"fleet.size": 3}))
    page = Page(browser, run, tmp_path, beside=other)
    captions = [item.text for item in page.browser.find_elements("class name", "caption")]
    assert captions == ["A: 6 robots", "B: 3 robots"]
    for time in (150.0, 700.0):
        for who, one in (("page", run), ("page.beside", other)):
            off = np.array(page.ask(f"{who}.positions(arguments[0])", time)) - Positions(one.history).points(time)
            assert np.abs(off).max() * page.ask("page.scale()") < 1
    assert other.T > run.T
    page.seek(1e9)  # the shorter run stands at its end
    assert page.ask("page.time()") == pytest.approx(other.T)
    for who, one in (("page", run), ("page.beside", other)):
        assert page.ask(f"{who}.tiles().tasks") == one.kpis["tasks"]
        assert page.ask(f"{who}.tiles().S") == one.S
    values = page.browser.find_elements("css selector", "[data-key=S] span")
    assert [value.text for value in values] == [str(run.S), str(other.S)]
    boxes = [item.rect for item in page.browser.find_elements("class name", "stage")]
    assert boxes[0]["x"] + boxes[0]["width"] <= boxes[1]["x"] or boxes[0]["y"] + boxes[0]["height"] <= boxes[1]["y"]
    # both views move together, as their floors are the same
    page.click("zoom-in")
    assert page.ask("page.scale()") == pytest.approx(page.ask("page.beside.scale()"))
    assert page.complaints() == []
    assert page.requests() == []


def test_a_picture_is_saved_as_it_is_on_the_screen(browser, tmp_path):
    page = Page(browser, paper_run(), tmp_path)
    folder = tmp_path / "downloads"
    browser.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(folder)})
    page.seek(300)
    page.click("picture")
    saved = folder / "MultiBots-300.png"
    for _ in range(600):  # half a minute, on a busy machine
        if saved.exists():
            break
        page.pause(0.05)
    box = page.browser.find_element("id", "floor").rect
    with Image.open(saved) as picture:
        assert picture.width == round(2 * (box["width"] + 2 * 14))  # 14: its edges
        assert picture.height > 2 * box["height"]
        robot = page.ask("page.states()").index("empty")
        (x, y), heading = page.ask("page.drawn()")[robot], Positions(page.run.history).headings(300)[robot]
        beside = 0.77 * 12.5 * page.ask("page.scale()")
        point = (2 * (14 + x - beside * math.sin(heading)), 2 * (50 + y + beside * math.cos(heading)))
        colour = picture.convert("RGB").getpixel((round(point[0]), round(point[1])))
    assert colour == pytest.approx((0, 98, 163), abs=30)
    assert page.ask("page.drawn()")[robot] == [x, y]  # the page is as it was
    assert page.complaints() == []


def test_robots_can_be_seen_where_they_are_small_on_the_floor(browser, tmp_path):
    run = busy_run()
    page, where = Page(browser, run, tmp_path), Positions(run.history)
    page.enlarge(500, 500)
    page.seek(300)
    on_lanes = where.at(300.0)[0] < where.edges.real
    radii = np.array(page.ask("page.radii()"))
    assert 0.4 * page.ask("page.scale()") < 5
    assert on_lanes.sum() > 5
    assert (radii[on_lanes] == 5).all()
    assert (radii[~on_lanes] <= 5).all()  # not over those in the next slots


def test_a_window_starts_and_ends_where_it_should(browser, tmp_path):
    run = busy_run()
    page, where = Page(browser, run, tmp_path, start=300, end=420), Positions(run.history)
    for time in (300, 333.3, 420):
        page.seek(time)
        assert page.ask("page.time()") == pytest.approx(time, abs=0.01)
        off = np.array(page.ask("page.positions(arguments[0])", time)) - where.points(time)
        assert np.abs(off).max() * page.ask("page.scale()") < 1
    page.seek(1000)
    assert page.ask("page.time()") == pytest.approx(420, abs=0.01)
    counted = sum(300 <= task.delivered <= 420 for task in run.history.delivered)
    assert page.indicator("tasks") == str(counted)


@pytest.mark.long  # every day the colours of the other palette, and of both in tests/report/test_palette.py
def test_the_paper_s_palette_can_be_asked_for(browser, tmp_path):
    page = Page(browser, paper_run(), tmp_path, palette="paper")
    page.enlarge(2000, 1600)
    page.seek(300)
    radius, headings = 12.5 * page.ask("page.scale()"), Positions(page.run.history).headings(300)
    robot = page.ask("page.states()").index("empty")
    (x, y), heading = page.ask("page.drawn()")[robot], headings[robot]
    beside = 0.77 * radius
    colour = page.pixel(x - beside * math.sin(heading), y + beside * math.cos(heading))
    assert colour == pytest.approx([0, 0, 255], abs=30)


def test_it_opens_at_the_end_of_the_warm_up_with_the_figures_of_the_whole_run(browser, tmp_path):
    run = busy_run()
    page = Page(browser, run, tmp_path)
    assert page.ask("page.time()") == pytest.approx(run.record.begin)
    assert not page.ask("page.player.playing")
    assert page.text("counted").startswith("Totals for the whole run, warm-up excluded.")
    shown = {key: page.indicator(key) for key, *_ in page.ask("page.header.tiles")}
    assert not {"0", "–"} & set(shown.values())
    assert shown["tasks"] == f"{run.kpis['tasks']:,}"
    page.seek(run.record.begin / 2)
    assert page.text("counted") == "Warm-up: nothing is counted yet."
    page.seek(run.record.end)
    assert page.text("counted") == "Counted so far after the warm-up."


@pytest.mark.long  # every day without a browser, in tests/js
def test_a_robot_is_watched_at_a_speed_that_the_eye_can_follow(browser, tmp_path):
    run = busy_run()
    page = Page(browser, run, tmp_path)
    speed, fastest, units = page.ask("page.player.speed"), run.model.fleet.fastest, run.model.units
    nodes = np.array([node[1:] for node in page.ask("page.header.nodes")])
    crossing = np.ptp(nodes, axis=0).max() / fastest * units.seconds / speed
    a_frame = fastest * speed / units.seconds / 60 * page.ask("page.scale()")
    assert 4 < crossing < 10
    assert a_frame < 2 * max(page.ask("page.radii()"))
    words = [one["words"] for one in page.ask("page.player.speeds")]
    assert sum("watch" in one for one in words) == sum("in a minute" in one for one in words) == 1


def test_a_click_says_the_chain_of_waits_to_its_root(browser, tmp_path):
    run = jammed_run()
    page, history = Page(browser, run, tmp_path), run.history
    link = next(
        (first, second)
        for first in history.waits
        for second in history.waits
        if first.other == second.robot and max(first.start, second.start) + 0.2 < min(first.end, second.end)
    )
    time = (max(link[0].start, link[1].start) + min(link[0].end, link[1].end)) / 2
    page.seek(time)
    page.tap(*page.ask("page.drawn()")[link[0].robot])
    sentence = page.text("robot")
    assert page.ask("page.chosen()") == link[0].robot
    assert f"robot {link[1].robot}, which waits " in sentence
    assert f"robot {link[1].other}, which " in sentence
    assert page.complaints() == []


def test_the_list_of_what_robots_waited_for_has_its_sums_and_leads_to_the_longest(browser, tmp_path):
    run = busy_run()
    page = Page(browser, run, tmp_path)
    rows = page.browser.find_elements("css selector", "#lost tbody tr")
    table = run.lost_time
    assert len(rows) == (table["share"] >= 0.001).sum() < len(table)
    for row, (_, root) in zip(rows, table.head(3).iterrows(), strict=False):
        assert root["root_at"] in row.text
        share = numbers.PERCENT.value(root["share"])
        assert row.text.endswith(f"{numbers.duration(root['time'], run.model.units.time)}, {share}")
    rows[0].find_element("tag name", "button").click()
    page.frame()
    robot, time = page.ask("page.chosen()"), page.ask("page.time()")
    doing = {piece.part for piece in pieces(run.history)[robot] if piece.start <= time <= piece.end}
    assert doing & {*TRAFFIC, *QUEUES}
    assert "the longest wait" in page.text("said")


def test_a_station_of_the_table_is_shown_on_the_floor(browser, tmp_path):
    page = Page(browser, busy_run(), tmp_path)
    button = page.browser.find_element("css selector", "#stations tbody button")
    button.click()
    page.frame()
    assert page.text("said").startswith(button.text)


@pytest.mark.parametrize(
    "widths", [(390, 1280), pytest.param((390, 1024, 1280, 1400, 1920), marks=pytest.mark.long)], ids=["two", "all"]
)
def test_long_names_of_stations_stay_in_their_box_on_any_screen(browser, tmp_path, widths):
    layout = busy()["layout"] | {"stations": {"goods_out_at_the_north_gate_2": {"at": ["J"], "places": 3}}}
    run = dw.simulate(dw.load(busy(layout=layout, tasks=busy()["tasks"] | {"unload_at": ["J"] * 16})), seed=1)
    page = Page(browser, run, tmp_path)
    ends = (
        "return ['#stations table', '#stations section', 'html'].map("
        "(one) => document.querySelector(one).getBoundingClientRect().right)"
    )
    for width in widths:
        page.enlarge(width, 900, mobile=width == 390)
        table, box, screen = page.browser.execute_script(ends)
        assert table <= box <= screen <= width
