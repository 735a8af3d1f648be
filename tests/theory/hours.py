"""Warehouses with calendars and buffers that have a formula, and the values that it gives."""

from tests.theory.models import AROUND, FAST, ROUND, TRIANGLE, station_that_serves

EVERY = 2000.0


def calendar(share):
    """Open at the beginning of every period, for a part of it."""
    return {"open": {"every": EVERY, "lasts": share * EVERY}}


def queue_in_open_hours(load, share, tasks):
    """Tasks arrive and are served only while the station is open: M/M/1 on a clock that stands still meanwhile."""
    made = station_that_serves(load, 1000.0, 1, tasks, unload={"exponential": 1000})
    made["calendars"] = calendar(share)
    made["tasks"]["goods"]["hours"] = "open"
    made["layout"]["stations"]["desk"] |= {"hours": "open", "at_close": "pause"}
    length = made["run"]["length"] / share
    return {**made, "run": {"length": length, "warm_up": length / 10}}


def work_at_all_times(share, robots, tasks, where):
    """Tasks arrive at all times, robots or their station work only in their hours; there are enough of both."""
    length = tasks * 100.0
    made = {
        "calendars": calendar(share),
        "layout": {**TRIANGLE, "stations": {"desk": {"at": ["A"], "places": robots, "servers": robots}}},
        "fleet": {"size": robots, "robot": FAST},
        "tasks": {"goods": {"poisson": 36}, "unload_at": ["A"], "load_time": 0, "unload_time": 10},
        "run": {"length": length, "warm_up": length / 10},
        "log": "tasks",
    }
    (made["fleet"] if where == "robots" else made["layout"]["stations"]["desk"])["hours"] = "open"
    return made


def wait_for_hours(share):
    """Mean wait of who comes at any time, until it is open: half of what is closed, if it comes then."""
    return (1 - share) ** 2 * EVERY / 2


def busy_station(lasts, service, at_close):
    """More robots than the one server can do with, which are there whenever it opens."""
    length = 50 * EVERY
    return {
        "calendars": {"open": {"every": EVERY, "lasts": lasts}},
        "layout": {**TRIANGLE, "stations": {"desk": {"at": ["A"], "places": 8, "hours": "open", "at_close": at_close}}},
        "fleet": {"size": 8, "robot": {"radius": 0.05, "speed": AROUND / 30}},
        "tasks": {"goods": {"saturated": 8}, "unload_at": ["A"], "load_time": 0, "unload_time": service},
        "run": {"length": length, "warm_up": length / 5},
        "log": "tasks",
    }


def full_buffer(places, workers, unload, work, tasks):
    """Robots are always there; unloading and the work on the load units take exponential times."""
    desk = {"at": ["A"], "places": 8, "buffer": places, "workers": workers, "work_time": {"exponential": work}}
    length = tasks * (unload + work / workers)
    return {
        "layout": {**TRIANGLE, "stations": {"desk": desk}},
        "fleet": {"size": 8, "robot": FAST},
        "tasks": {
            "goods": {"saturated": 8},
            "unload_at": ["A"],
            "load_time": 0,
            "unload_time": {"exponential": unload},
        },
        "run": {"length": length, "warm_up": length / 10},
        "log": "tasks",
    }


def through_a_buffer(places, workers, unload, work):
    """Load units per time unit: M/M/c/K, whose arrivals are the unloadings, as long as there is a place."""
    weights = [1.0]
    for held in range(1, places + 1):
        weights.append(weights[-1] * work / unload / min(held, workers))
    return (1 - weights[-1] / sum(weights)) / unload


SERVICE = 10 + ROUND
