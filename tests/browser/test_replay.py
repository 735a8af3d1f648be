"""The replay page in a real browser: it plays the log, by mouse and by keyboard, and asks nothing of the network."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from desim_warehouse.report.positions import Positions
from tests.browser.pages import Page
from tests.report.replay.floors import RUNS, busy_run, jammed_run, paper_run, spurs_run

if TYPE_CHECKING:
    from pathlib import Path

    import desim_warehouse as dw


@pytest.fixture
def page(browser: Any, tmp_path: Path) -> Page:
    return Page(browser, paper_run(), tmp_path)


def waits(run: dw.Run) -> list[tuple[float, float, int]]:
    """Begin, end and robot of all collisions."""
    return [(row[0] - row[6], row[0], row[2]) for row in run.record.rows if row[1] == "collision"]


@pytest.mark.parametrize("name", RUNS)
def test_it_loads_and_plays_offline_without_a_complaint_or_a_request(browser: Any, tmp_path: Path, name: str) -> None:
    page = Page(browser, RUNS[name](), tmp_path)
    for button in ("heat", "palette", "theme", "help", "play"):
        page.click(button)
    page.pause(0.3)
    page.click("play")
    page.frame()
    assert page.complaints() == []
    assert page.requests() == []


@pytest.mark.parametrize("name", RUNS)
def test_robots_are_drawn_within_a_pixel_of_where_the_log_has_them(browser: Any, tmp_path: Path, name: str) -> None:
    run = RUNS[name]()
    page, where = Page(browser, run, tmp_path), Positions(run)
    scale = page.ask("page.scale()")
    for time in np.random.default_rng(20).uniform(0, run.record.end, 20):
        expected = where.points(float(time))
        assert np.abs(np.array(page.ask("page.positions(arguments[0])", float(time))) - expected).max() * scale < 1
        drawn = np.array(page.ask("page.drawn()")) / scale
        assert np.ptp(drawn - expected, axis=0).max() * scale < 1


def test_what_is_drawn_is_on_the_canvas_in_the_colour_of_its_state(page: Page) -> None:
    colours = {"empty": [0, 98, 163], "loaded": [213, 94, 0]}
    seen = set()
    page.enlarge(2000, 1600)
    radius = 12.5 * page.ask("page.scale()")
    for time in (200, 300, 560, 800):
        page.seek(time)
        headings = Positions(page.run).headings(time)
        for (x, y), state, heading in zip(page.ask("page.drawn()"), page.ask("page.states()"), headings, strict=True):
            if state in colours:
                beside = 0.77 * radius  # clear of number, square, head and rim
                found = page.pixel(x - beside * math.sin(heading), y + beside * math.cos(heading))
                assert found == pytest.approx(colours[state], abs=30)
                seen.add(state)
    assert seen == set(colours)


def test_a_two_way_lane_is_one_line_with_its_present_direction(browser: Any, tmp_path: Path) -> None:
    run = spurs_run()
    page, where = Page(browser, run, tmp_path), Positions(run)
    # those of the trunk, not the two lanes side by side
    pairs = [[where.edges.source[edge] for edge in pair] for pair in page.ask("page.header.two_way")]
    assert sorted(pairs) == [["a", "b"], ["b", "c"], ["b", "shelf"], ["c", "pack"]]
    edges, seen = list(run.layout.graph.edges), set()
    for time in np.linspace(20, run.record.end, 60):
        page.seek(float(time))
        on = [edges[edge] for edge in where.at(float(time))[0] if edge < len(edges)]
        used = {edge for edge in on if run.layout.graph.edges[edge]["two_way"]}
        assert {tuple(edge) for edge in page.ask("page.directions()")} == used
        assert not any(edge[::-1] in used for edge in used)
        seen |= used
    assert len(seen) == 8  # every lane in both directions, at one time or another
    assert "two-way lane, free" in page.text("legend")


def test_playing_moves_robots_and_pausing_stops_them(page: Page) -> None:
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


def test_a_run_plays_to_its_end_and_again_from_its_start(page: Page) -> None:
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


def test_scrubbing_moves_robots(page: Page) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    before = page.ask("page.drawn()")
    slider = page.browser.find_element("id", "scrub")
    ActionChains(page.browser).move_to_element(slider).click().perform()
    page.frame()
    assert page.ask("page.time()") == pytest.approx(page.run.T / 2, rel=0.05)
    assert all(math.dist(a, b) > 5 for a, b in zip(before, page.ask("page.drawn()"), strict=True))
    assert "step" in page.attribute("scrub", "aria-valuetext")


@pytest.mark.parametrize("make", [paper_run, busy_run, jammed_run])
def test_jumping_to_a_collision_lands_on_one(browser: Any, tmp_path: Path, make: Any) -> None:
    run = make()
    page = Page(browser, run, tmp_path)
    last = 0.0
    for _ in range(4):
        page.click("next")
        page.frame()
        time, robot = page.ask("page.time()"), page.ask("page.chosen()")
        assert time > last
        assert robot in page.ask("page.waiting()")
        assert any(begin <= time <= end and who == robot for begin, end, who in waits(run))
        assert f"Robot {robot} waits" in page.browser.find_element("id", "status").get_attribute("textContent")
        last = time
    page.click("previous")
    assert page.ask("page.time()") < last


def test_every_collision_can_be_jumped_to_and_after_the_last_that_is_said(page: Page) -> None:
    jumps = []
    for _ in range(page.run.S):
        page.click("next")
        jumps.append(page.ask("page.time()"))
    assert len(set(jumps)) == page.run.S
    page.click("next")
    assert page.ask("page.time()") == jumps[-1]
    assert page.browser.find_element("id", "status").get_attribute("textContent") == "No further collision"


def test_jumping_to_a_rotation_lands_on_one(browser: Any, tmp_path: Path) -> None:
    run = jammed_run()
    page = Page(browser, run, tmp_path)
    for time, robots, _ in run.record.rings[:3]:
        page.press("r")
        page.frame()
        assert page.ask("page.time()") == pytest.approx(time, abs=0.05)
        assert page.ask("page.chosen()") == robots[0]


@pytest.mark.parametrize("name", RUNS)
def test_the_strip_ends_with_the_indicators_of_the_run(browser: Any, tmp_path: Path, name: str) -> None:
    run = RUNS[name]()
    page = Page(browser, run, tmp_path)
    page.seek(run.record.end)
    value = {key: float(page.indicator(key).replace(",", "")) for key in ("T", "S", "C", "delivered", "throughput")}
    assert value["T"] == pytest.approx(run.T, abs=0.06)
    assert (value["S"], value["C"], value["delivered"]) == (run.S, run.C, run.kpis["tasks"])
    assert value["throughput"] == pytest.approx(run.kpis["throughput_per_hour"], abs=0.06)
    assert sum(page.ask("page.deliveredAt()").values()) == run.kpis["tasks"]


def test_the_heat_map_holds_the_counted_waiting_of_the_log(browser: Any, tmp_path: Path) -> None:
    run = busy_run()
    page = Page(browser, run, tmp_path)
    page.seek(run.record.end)
    heat = page.ask("page.heat()")
    expected = dict.fromkeys(run.layout.graph.edges, 0.0)
    where: dict[int, tuple[str, str] | None] = {}
    for row in run.record.rows:
        if row[1] in ("enter", "parked", "docked"):
            where[row[2]] = row[5]
        elif row[1] == "collision" and (edge := row[5] or where.get(row[2])) is not None and row[0] >= run.record.begin:
            expected[edge] += row[6]
    assert max(expected.values()) > 10
    assert heat == pytest.approx(list(expected.values()), abs=0.1)


def test_a_window_starts_and_ends_where_it_should(browser: Any, tmp_path: Path) -> None:
    run = busy_run()
    page, where = Page(browser, run, tmp_path, start=300, end=420), Positions(run)
    for time in (300, 333.3, 420):
        page.seek(time)
        assert page.ask("page.time()") == pytest.approx(time, abs=0.01)
        off = np.array(page.ask("page.positions(arguments[0])", time)) - where.points(time)
        assert np.abs(off).max() * page.ask("page.scale()") < 1
    page.seek(1000)
    assert page.ask("page.time()") == pytest.approx(420, abs=0.01)
    counted = sum(run.record.begin <= end <= 420 for _, end, _ in waits(run))
    assert page.indicator("S") == str(counted)


def test_the_paper_s_palette_can_be_asked_for(browser: Any, tmp_path: Path) -> None:
    page = Page(browser, paper_run(), tmp_path, palette="paper")
    page.enlarge(2000, 1600)
    page.seek(300)
    radius, headings = 12.5 * page.ask("page.scale()"), Positions(page.run).headings(300)
    robot = page.ask("page.states()").index("empty")
    (x, y), heading = page.ask("page.drawn()")[robot], headings[robot]
    beside = 0.77 * radius
    found = page.pixel(x - beside * math.sin(heading), y + beside * math.cos(heading))
    assert found == pytest.approx([0, 0, 255], abs=30)
    assert page.attribute("palette", "aria-pressed") == "true"
