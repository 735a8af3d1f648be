"""Servers and chargers over time: in use, and robots that queue for them."""

import json
import math

import pytest

import desim_warehouse as dw
from desim_warehouse.outcome.loads import loads
from desim_warehouse.outcome.resources import area, resources, steps, use_of_stations
from desim_warehouse.questions.run import words as run_words
from tests.report.replay.floors import busy_run, tired_run
from tests.world.test_flows import RING

OUT = {
    "fast": {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 0, "tasks": 9}]}},
    "slow": {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 40, "tasks": 3}]}, "unload_time": 25},
}


def test_counts_over_time_and_the_area_below_them():
    """One from 2 to 5, another from 3 to 4; what begins as another ends changes nothing."""
    curve = steps([(2.0, 1), (5.0, -1), (3.0, 1), (4.0, -1), (4.5, 1), (4.5, -1)])
    assert curve == ([0.0, 2.0, 3.0, 4.0, 5.0], [0, 1, 2, 1, 0])
    assert area(curve, 0, 10) == 4
    assert area(curve, 2.5, 3.5) == pytest.approx(0.5 + 1)
    assert area(curve, 7, 9) == 0
    assert steps([(0.0, 1), (1.0, -1)]) == ([0.0, 1.0], [1, 0])


def line(servers):
    """Two robots that fetch a good each from the same lane, one behind the other, for a station that takes long."""
    model = {
        "layout": {
            "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 10], "D": [0, 10]},
            "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
            "storage": [{"edge": ["A", "B"], "offset": 10}],
            "bays": {"home": {"at": ["D"], "places": 2}},
            "stations": {"pack": {"at": ["B"], "places": 2, "servers": servers}},
        },
        "fleet": {"size": 2, "robot": {"radius": 0.4, "speed": 1.0, "margin": 0.2}},
        "tasks": {"goods": [0, 0], "unload_at": ["B"], "load_time": 5, "unload_time": 40},
    }
    return dw.simulate(dw.load(model))


def test_a_server_is_in_use_while_robots_unload_and_the_others_queue():
    run = line(servers=1)
    (station,) = resources(run.history)
    assert (station.kind, station.zone, station.node, station.number) == ("station", "pack", "B", 1)
    spans = [span for robot in run.history.states for span in robot if span.state in ("unloading", "queueing")]
    (first, second), (queued,) = (
        sorted((span.start, span.end) for span in spans if span.state == state) for state in ("unloading", "queueing")
    )
    # the second comes while the first is served, waits for the rest of it, and is served at once
    assert first[0] < queued[0] < first[1] == queued[1] == second[0]
    assert station.busy == ([0.0, first[0], second[1]], [0, 1, 0])
    assert station.queue == ([0.0, *queued], [0, 1, 0])
    assert station.utilisation(0, run.T) == pytest.approx(80 / run.T)
    assert station.mean_queue(0, run.T) == pytest.approx((queued[1] - queued[0]) / run.T)
    assert math.isnan(station.utilisation(5, 5))


def test_with_two_servers_nobody_queues():
    (station,) = resources(line(servers=2).history)
    assert max(station.busy[1]) == 2
    assert station.queue == ([0.0], [0])


@pytest.mark.parametrize("make", [busy_run, tired_run])
def test_queues_add_up_to_the_time_queued_of_the_run(make):
    run = make()
    begin, end = run.history.begin, run.history.end
    for kind, indicator in (("station", "station_wait"), ("chargers", "charger_wait")):
        queued = sum(area(one.queue, begin, end) for one in resources(run.history) if one.kind == kind)
        assert queued == pytest.approx(run.kpis.get(indicator, 0.0), abs=1e-6)


@pytest.mark.parametrize("over", [{}, {"run.warm_up": 130}, {"layout.stations.pack.work_time": 30}])
def test_servers_are_in_use_for_as_long_at_every_level_of_the_log(over):
    """A robot that begins in the warm-up, or is at it at the end, counts as far as it is in the counted time."""
    model = dw.load(RING, {"tasks.flows": OUT, "fleet.size": 3, "run.length": 401, **over})
    in_full = dw.simulate(model.replace({"log": "all"}))
    begin, end = in_full.history.begin, in_full.history.end
    by_account = {one.zone: one.utilisation(begin, end) for one in resources(in_full.history) if one.kind == "station"}
    assert by_account["pack"] > by_account["dock"] > 0
    for level in ("all", "moves", "tasks"):
        run = dw.simulate(model.replace({"log": level}))
        servers = [load for load in loads(run.history, run.kpis) if load.group.kind == "servers"]
        assert {load.group.zone: load.mean for load in servers} == pytest.approx(by_account)
        assert run_words.sentences(run) == run_words.sentences(in_full)


@pytest.mark.parametrize("level", ["all", "tasks"])
def test_servers_in_use_are_kept_with_a_run(level, tmp_path):
    """A run of before 0.4.0 has no such tallies: with the whole log they are read from that, else nothing is said."""
    run = dw.simulate(dw.load(RING, {"tasks.flows": OUT, "fleet.size": 3, "log": level}))
    folder = run.save(tmp_path / "run")
    assert run_words.sentences(dw.load_run(folder)) == run_words.sentences(run)
    content = json.loads((folder / "run.json").read_text())
    del content["log"]["stations"]
    (folder / "run.json").write_text(json.dumps(content))
    use = use_of_stations(dw.load_run(folder).history)
    assert use == (pytest.approx(use_of_stations(run.history)) if level == "all" else {})
