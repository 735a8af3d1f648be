"""The verdict that fewer robots under way would do more: said only where one run shows it."""

from types import SimpleNamespace

import pytest

import desim_warehouse as dw
from desim_warehouse.outcome import verdicts
from desim_warehouse.outcome.verdicts import Window, windows
from tests.world.crowded import crowded, waves


def shown(monkeypatch, stretches, waiting=0.5):
    monkeypatch.setattr(verdicts, "windows", lambda _: stretches)
    log = SimpleNamespace(robots=[{}])
    return verdicts.past_knee(SimpleNamespace(counted=100.0, log=log, totals={"waiting": 100 * waiting}))


def band(under_way, done, count=6, apart=0.1):
    return [Window(under_way, done + apart * (rank % 3 - 1)) for rank in range(count)]


def test_windows_with_fewer_robots_that_do_more_show_it(monkeypatch):
    cap, many, gain = shown(monkeypatch, [*band(30, 6.0), *band(60, 4.0), *band(20, 5.0)])
    assert (cap, many) == (30, 60)
    assert gain == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("why", "stretches", "waiting"),
    [
        ("fewer do less", [*band(30, 4.0), *band(60, 6.0)], 0.5),
        ("as much, with chance", [*band(30, 6.1, apart=0.5), *band(60, 6.0, apart=0.5)], 0.5),
        ("hardly more", [*band(30, 6.2, apart=0.001), *band(60, 6.0, apart=0.001)], 0.5),
        ("too few windows with fewer", [*band(30, 6.0, count=5), *band(60, 4.0)], 0.5),
        ("too few windows with all", [*band(30, 6.0), *band(60, 4.0, count=5)], 0.5),
        ("nearly as many", [*band(52, 6.0), *band(60, 4.0)], 0.5),
        ("hardly anybody waits", [*band(30, 6.0), *band(60, 4.0)], 0.1),
        ("nothing happened", [], 0.5),
    ],
)
def test_nothing_else_does(monkeypatch, why, stretches, waiting):
    assert shown(monkeypatch, stretches, waiting) is None, why


def test_a_run_past_its_knee_after_hours_with_fewer_robots_says_so():
    run = dw.simulate(dw.load(waves(60, 0, calm=1.15, length=1200, burst=900)), 0)
    assert [verdict.text for verdict in run.verdicts] == [
        "past the knee: at most 26 robots under way (traffic.most_out) would get more done than 60 do",
    ]


@pytest.mark.parametrize(
    ("robots", "calm", "length"),
    [(22, 0.9, 700), *(pytest.param(*case, 2000, marks=pytest.mark.long) for case in ((30, 1.1), (22, 0.9)))],
)
def test_the_same_hours_with_a_fleet_of_the_right_size_do_not(robots, calm, length):
    run = dw.simulate(dw.load(waves(robots, 1, calm=calm, length=length, burst=length)), 1)
    assert run.verdicts == []


def test_a_run_in_which_all_are_always_under_way_cannot_show_it():
    run = dw.simulate(dw.load(crowded(60, run={"length": 600, "warm_up": 200})))
    assert [verdict.code for verdict in run.verdicts] == ["JAMMED"]


def test_windows_hold_all_robots_under_way_and_all_goods():
    run = dw.simulate(dw.load(crowded(20, run={"length": 600, "warm_up": 200})))
    stretches = windows(run.history)
    length = run.history.counted / len(stretches)
    assert all(19.99 < window.under_way <= 20 + 1e-9 for window in stretches)
    rows = [row for row in run.record.rows if row[1] in {"loaded", "delivered"} and row[0] >= 200]
    assert sum(window.done for window in stretches) * length == pytest.approx(len(rows))
