"""Robots and stations as the servers of queueing theory.

Robots are fast and far apart here, so that no one is in another's way: what is left is a queue with a textbook formula.
"""

import math

import numpy as np
import pytest

from tests.theory.estimate import agrees, means

LONG = pytest.mark.long
FAST = {"radius": 0.05, "speed": 1000}
TRIANGLE = {
    "nodes": {"A": [0, 0], "B": [50, 0], "C": [50, 50]},
    "edges": [["A", "B"], ["B", "C"], ["C", "A"]],
    "storage": [{"edge": ["A", "B"], "offset": 25}],
    "bays": {"home": {"at": ["A"]}},
}
ROUND = (100 + 50 * math.sqrt(2)) / FAST["speed"]
"""Driving time from A round to A."""


def m_d_c_wait(rate, service, servers):
    """Mean wait of M/D/c, exactly: whoever is served now is gone one service time later (Crommelin 1932)."""
    most = servers + 400
    arrivals = np.array(
        [math.exp(n * math.log(rate * service) - rate * service - math.lgamma(n + 1)) for n in range(most)]
    )
    present = np.zeros(most)
    present[0] = 1.0
    for _ in range(5000):
        left = np.concatenate(([present[: servers + 1].sum()], present[servers + 1 :]))
        after = np.convolve(left, arrivals)[:most]
        if abs(after - present).max() < 1e-14:
            break
        present = after
    queue = sum((n - servers) * present[n] for n in range(servers, most))
    return queue / rate


def test_the_formula_for_one_server_is_that_of_pollaczek_and_khinchine():
    assert m_d_c_wait(0.07, 10.0, 1) == pytest.approx(0.7 * 10.0 / (2 * (1 - 0.7)), rel=1e-9)


def robots_that_serve(load, service, robots, tasks, layout=TRIANGLE, **more):
    """Tasks arrive at random; a robot is busy for `service` with each, mostly with unloading in a station at A."""
    length = tasks * service / robots / load
    layout = {**layout, "stations": {"desk": {"at": ["A"], "places": robots, "servers": robots}}}
    return {
        "layout": layout,
        "fleet": {"size": robots, "robot": FAST},
        "tasks": {
            "goods": {"poisson": 3600 * load * robots / service},
            "unload_at": ["A"],
            "load_time": 0,
            "unload_time": service - ROUND,
            **more,
        },
        "run": {"length": length, "warm_up": length / 10},
        "log": "tasks",
    }


@pytest.mark.parametrize(("load", "tasks"), [(0.3, 500), (0.5, 1200), pytest.param(0.7, 8_000, marks=LONG)])
def test_one_robot_is_the_server_of_m_d_1(load, tasks):
    """Its wait is that of Pollaczek and Khinchine."""
    service = 10.0
    wait = m_d_c_wait(load / service, service, 1)
    agrees(means(robots_that_serve(load, service, 1, tasks), "cycle_time_mean"), service + wait)


@pytest.mark.parametrize(
    ("robots", "load", "tasks"), [(2, 0.6, 1600), (5, 0.7, 1200), pytest.param(5, 0.8, 5_000, marks=LONG)]
)
def test_robots_are_the_servers_of_m_d_c(robots, load, tasks):
    """The service is long against driving: robots that leave the bay together differ by a ten thousandth of it."""
    service = 1000.0
    wait = m_d_c_wait(load * robots / service, service, robots)
    agrees(means(robots_that_serve(load, service, robots, tasks), "cycle_time_mean"), service + wait)


def station_that_serves(load, service, servers, tasks, robots=15):
    """Robots abound; tasks queue in the station at A, which has few servers."""
    length = tasks * service / servers / load
    return {
        "layout": {**TRIANGLE, "stations": {"desk": {"at": ["A"], "places": robots, "servers": servers}}},
        "fleet": {"size": robots, "robot": FAST},
        "tasks": {
            "goods": {"poisson": 3600 * load * servers / service},
            "unload_at": ["A"],
            "load_time": 0,
            "unload_time": service,
        },
        "run": {"length": length, "warm_up": length / 10},
        "log": "tasks",
    }


@pytest.mark.parametrize(
    ("servers", "load", "tasks"), [(1, 0.4, 1000), (3, 0.6, 800), pytest.param(3, 0.75, 4_000, marks=LONG)]
)
def test_a_station_is_the_server_of_m_d_c(servers, load, tasks):
    """Robots come to the station a fixed time after the task: arrivals there are as random as the tasks'."""
    service = 1000.0
    formula = ROUND + service + m_d_c_wait(load * servers / service, service, servers)
    agrees(means(station_that_serves(load, service, servers, tasks), "cycle_time_mean"), formula)


@pytest.mark.long
def test_how_busy_a_robot_is():
    """Of a server's time the part `load` goes into service."""
    agrees(means(robots_that_serve(0.6, 10.0, 1, tasks=5000), lambda run: 1 - run.kpis["share_idle"]), 0.6)


@pytest.mark.long
def test_how_many_queue_at_a_station():
    """By Little's law the rate times the mean wait; the share of queueing robots shows it."""
    load, service, robots = 0.4, 1000.0, 12
    model = station_that_serves(load, service, 1, tasks=16_000, robots=robots)
    queue = load / service * m_d_c_wait(load / service, service, 1)
    agrees(means(model, lambda run: robots * run.kpis["share_queueing"]), queue)


def test_two_service_times_are_m_g_1():
    """Goods near and far, 3 of 4 near: Pollaczek (1930) and Khinchine (1932) need only two moments of the service."""
    near, far, unload, load = 4.0, 10.0, 1.0, 0.4
    slow = {"radius": 0.05, "speed": 100}
    model = {
        "layout": {
            "nodes": {"A": [0, 0], "B": [near * 50, 0], "C": [0, far * 50]},
            "edges": [["A", "B"], ["B", "A"], ["A", "C"], ["C", "A"]],
            "storage": [{"edge": ["A", "B"], "offset": 50}, {"edge": ["A", "C"], "offset": 50}],
            "bays": {"home": {"at": ["A"]}},
        },
        "fleet": {"size": 1, "robot": slow},
        "tasks": {"popularity": {"weights": [3, 1]}, "unload_at": ["A"], "load_time": 0, "unload_time": unload},
        "log": "tasks",
    }
    times, parts = np.array([near + unload, far + unload]), np.array([0.75, 0.25])
    mean, square = times @ parts, times**2 @ parts
    rate = load / mean
    length = 2400 / rate
    model["tasks"]["goods"] = {"poisson": 3600 * rate}
    model["run"] = {"length": length, "warm_up": length / 10}
    agrees(means(model, "cycle_time_mean"), mean + rate * square / (2 * (1 - load)))


def test_a_queue_is_as_long_as_its_rate_times_its_wait():
    """Little's law: tasks open at a time, counted from released and delivered rows, are rate times cycle time."""

    def open_on_average(run):
        begin, end = run.model.run.warm_up, run.T
        area = sum(
            (1 if row[1] == "released" else -1) * (end - max(row[0], begin))
            for row in run.record.rows
            if row[1] in {"released", "delivered"}
        )
        return area / (end - begin)

    def by_little(run):
        return run.kpis["throughput_per_hour"] / 3600 * run.kpis["cycle_time_mean"]

    runs = means(
        robots_that_serve(0.7, 1000.0, 3, tasks=1500), lambda run: (open_on_average(run), by_little(run)), runs=3
    )
    for counted, told in runs:
        assert told == pytest.approx(counted, rel=0.03)


def crews(robots, service, think):
    """A closed line: robots drive round in `think` and are served at one desk, one after the other."""
    slow = {"radius": 0.05, "speed": (100 + 50 * math.sqrt(2)) / think}
    length = 400 * (think + service)
    return {
        "layout": {**TRIANGLE, "stations": {"desk": {"at": ["A"], "places": robots, "servers": 1}}},
        "fleet": {"size": robots, "robot": slow},
        "tasks": {"goods": {"saturated": robots}, "unload_at": ["A"], "load_time": 0, "unload_time": service},
        "run": {"length": length, "warm_up": length / 4},
        "log": "tasks",
    }


@pytest.mark.parametrize("robots", [1, 2, 3, 4, 5, 8])
def test_a_closed_line_is_d_d_1(robots):
    """Nothing is random: n robots get n tasks done a round as long as the desk is not the bottleneck (n <= 4 here)."""
    service, think = 10.0, 30.0
    run = means(crews(robots, service, think), lambda run: run, runs=1)[0]
    rate = min(robots / (think + service), 1 / service)
    assert run.kpis["throughput_per_hour"] == pytest.approx(3600 * rate, rel=0.005)
    wait = max(robots * service - (think + service), 0.0)
    assert run.kpis["share_queueing"] == pytest.approx(wait / max(robots * service, think + service), abs=0.005)
