"""A page has one window: tiles, story, terminal and JSON agree, for the whole run, a part of it, and a saved run."""

import re
from functools import cache

import pytest

import desim_warehouse as dw
from desim_warehouse.folders import gallery
from desim_warehouse.outcome.resources import resources
from desim_warehouse.replay import _counted_from, replay, window
from desim_warehouse.replay.payload import payload
from desim_warehouse.replay.scale import scale_of
from desim_warehouse.replay.stops import better, stops
from desim_warehouse.replay.tiles import figures, tiles
from tests.report.replay.floors import busy_run, due_run

LENGTHS = {
    "goods-to-person": 420.0,
    "sorting": 300.0,
    "e-commerce": 1200.0,
    "hospital": 2400.0,
    "mezzanine": 2400.0,
    "milk-run": 2400.0,
    "pallets": 2400.0,
}
"""Seconds, of which the last two thirds are counted."""
LARGE = ("goods-to-person", "sorting")
HOUR = 3600.0


@cache
def short(name):
    length = LENGTHS[name]
    changes = {"run.length": length, "run.warm_up": length / 3, "log": "all", "fleet.start_energy": 0.9}
    return dw.simulate(dw.load(gallery()[name], changes), seed=4)


def counted(run, start=None, end=None):
    """The history that a page of this window shows, and the window's steps."""
    first, last = window(run.history, start, end)
    history = run.history.since(_counted_from(run.history, first, last))
    return history, scale_of(history, first, last)


def shown(run, start=None, end=None):
    """What tiles show at the end of a window, and the last sentence of its story."""
    history, scale = counted(run, start, end)
    at_end = figures(history, tiles(history), scale)
    return at_end, stops(history, resources(history), scale, at_end)[-1]["said"]


def delivered(message):
    return int(re.search(r"In all: ([\d,]+) (?:load|line)s? delivered", message)[1].replace(",", ""))


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.long] * (name in LARGE)) for name in LENGTHS])
def test_a_window_that_is_the_whole_run_shows_the_run_s_own_indicators(name):
    run = short(name)
    at_end, totals = shown(run, None, run.record.end)
    assert at_end["tasks"] == run.kpis["tasks"] == delivered(totals) > 0
    compared = at_end.keys() & {"on_time", "share_waiting", "throughput_per_hour"}
    assert "throughput_per_hour" in compared
    for key in compared:
        assert at_end[key] == pytest.approx(run.kpis[key], abs=1e-9), key
    assert (at_end, totals) == shown(run)


@pytest.mark.parametrize("name", [pytest.param("sorting", marks=pytest.mark.long), "e-commerce"])
def test_a_saved_run_cut_short_shows_what_a_run_of_that_length_has(name, tmp_path):
    run = short(name)
    cut = LENGTHS[name] * 0.8
    saved = dw.load_run(run.save(tmp_path / name))
    shorter = dw.simulate(run.model, seed=4, until=cut)
    (first, totals), (second, shorter_totals) = shown(saved, None, cut), shown(shorter)
    assert first["tasks"] == second["tasks"] == shorter.kpis["tasks"]
    assert first.get("on_time") == second.get("on_time") == shorter.kpis.get("on_time")
    assert first["throughput_per_hour"] == pytest.approx(shorter.kpis["throughput_per_hour"])
    assert totals.split(",")[0] == shorter_totals.split(",")[0]


@pytest.mark.parametrize(
    ("start", "end", "begin"),
    [
        (400.0, 700.0, 400.0),  # from its start on
        (20.0, 700.0, 60.0),  # from the end of the warm-up on
        (0.0, 900.0, 60.0),
        (10.0, 50.0, 10.0),  # all of it in the warm-up
    ],
)
def test_a_window_counts_from_its_start_or_from_the_end_of_the_warm_up(start, end, begin):
    run = busy_run()
    inside = [task for task in run.history.delivered if begin <= task.delivered <= end]
    at_end, totals = shown(run, start, end)
    assert at_end["tasks"] == delivered(totals) == len(inside)
    assert at_end["throughput_per_hour"] == pytest.approx(len(inside) * HOUR / (end - begin))
    assert counted(run, start, end)[0].begin == begin


def test_a_page_says_from_when_it_counts():
    run = busy_run()
    header, columns = payload(run.history, 0.0, run.record.end)
    assert header["begin"] == 60
    assert header["at_end"]["tasks"] == len(columns["tasks_time"]) == run.kpis["tasks"]
    assert '"begin":60' in replay(run.history, end=run.record.end).html.replace(" ", "")


def test_the_better_of_two_runs_is_found_in_their_windows():
    """Beside a run with orders that are due, one that is cut before its first task is delivered does less."""
    run = due_run()
    first = min(task.delivered for task in run.history.counted_deliveries)
    early, whole = ({"throughput_per_hour": shown(run, None, end)[0]["throughput_per_hour"]} for end in (first, None))
    assert better([run.history, run.history], [early, whole])[0] in "AB"
    assert better([run.history, run.history], [whole, whole]) == "Both do the same."
