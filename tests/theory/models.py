"""Warehouses with a formula: robots and stations as servers, chargers as repairmen, rings and crossings as roads.

In queues robots are fast and far apart, so that no one is in another's way: what is left is the queue of the textbook.
"""

import math
from itertools import pairwise

from tests.theory.formulas import repairmen
from tests.world.test_pods import HALL

FAST = {"radius": 0.05, "speed": 1000}
TRIANGLE = {
    "nodes": {"A": [0, 0], "B": [50, 0], "C": [50, 50]},
    "edges": [["A", "B"], ["B", "C"], ["C", "A"]],
    "storage": [{"edge": ["A", "B"], "offset": 25}],
    "bays": {"home": {"at": ["A"]}},
}
AROUND = 100 + 50 * math.sqrt(2)
CABIN, DOORS = 12.0, 4.0
RIDING = CABIN + DOORS + DOORS + CABIN + DOORS + DOORS
"""Of a lift whose cabin is called down for each robot: down, doors open, closed, up, open, closed."""
ROUND = AROUND / FAST["speed"]
"""Driving time from A round to A."""


# Queues


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


def station_that_serves(load, service, servers, tasks, robots=15, unload=None):
    """Robots abound; tasks queue in the station at A, which has few servers; `unload`: a distribution of that mean."""
    length = tasks * service / servers / load
    return {
        "layout": {**TRIANGLE, "stations": {"desk": {"at": ["A"], "places": robots, "servers": servers}}},
        "fleet": {"size": robots, "robot": FAST},
        "tasks": {
            "goods": {"poisson": 3600 * load * servers / service},
            "unload_at": ["A"],
            "load_time": 0,
            "unload_time": unload or service,
        },
        "run": {"length": length, "warm_up": length / 10},
        "log": "tasks",
    }


def robot_before_people(rate, stay, away, rounds):
    """A robot that drives round passes an aisle that people visit; it is `away` from the aisle for that long."""
    return {
        "layout": TRIANGLE,
        "fleet": {"size": 1, "robot": FAST},
        "tasks": {"goods": {"saturated": 1}, "unload_at": ["A"], "load_time": 0, "unload_time": away - ROUND},
        "people": {"pickers": {"aisles": [["B", "C"]], "per_hour": 3600 * rate, "stay": {"exponential": stay}}},
        "run": {"length": rounds * (away + stay), "warm_up": away},
    }


def flows_at_a_station(load, times, tasks, robots=15):
    """Several flows, equally many tasks of each, meet at a station with one server; each has its own time there."""
    mean = sum(times.values()) / len(times)
    length = tasks * mean / load
    return {
        "layout": {**TRIANGLE, "stations": {"desk": {"at": ["A"], "places": robots, "servers": 1}}},
        "fleet": {"size": robots, "robot": FAST},
        "tasks": {
            "load_time": 0,
            "unload_time": 0,
            "flows": {
                name: {
                    "from": "storage",
                    "to": "desk",
                    "unload_time": time,
                    "arrivals": {"poisson": 3600 * load / mean / len(times)},
                }
                for name, time in times.items()
            },
        },
        "run": {"length": length, "warm_up": length / 10},
        "log": "tasks",
    }


def near_and_far(near, far, unload, load, tasks):
    """Goods near and far, 3 of 4 near, in seconds there and back; one robot."""
    slow = {"radius": 0.05, "speed": 100}
    rate = load / (0.75 * near + 0.25 * far + unload)
    length = tasks / rate
    return {
        "layout": {
            "nodes": {"A": [0, 0], "B": [near * 50, 0], "C": [0, far * 50]},
            "edges": [["A", "B"], ["B", "A"], ["A", "C"], ["C", "A"]],
            "storage": [{"edge": ["A", "B"], "offset": 50}, {"edge": ["A", "C"], "offset": 50}],
            "bays": {"home": {"at": ["A"]}},
        },
        "fleet": {"size": 1, "robot": slow},
        "tasks": {
            "goods": {"poisson": 3600 * rate},
            "popularity": {"weights": [3, 1]},
            "unload_at": ["A"],
            "load_time": 0,
            "unload_time": unload,
        },
        "run": {"length": length, "warm_up": length / 10},
        "log": "tasks",
    }


def crews(robots, service, think):
    """A closed line: robots drive round in `think` and are served at one desk, one after the other."""
    length = 400 * (think + service)
    return {
        "layout": {**TRIANGLE, "stations": {"desk": {"at": ["A"], "places": robots, "servers": 1}}},
        "fleet": {"size": robots, "robot": {"radius": 0.05, "speed": AROUND / think}},
        "tasks": {"goods": {"saturated": robots}, "unload_at": ["A"], "load_time": 0, "unload_time": service},
        "run": {"length": length, "warm_up": length / 4},
        "log": "tasks",
    }


# Breakdowns


def breaks_down(model, every, repair):
    """A model in which every robot breaks down."""
    robot = {**model["fleet"]["robot"], "breakdowns": at_random(every, repair)}
    return {**model, "fleet": {**model["fleet"], "robot": robot}}


def at_random(every, repair):
    """Failures and repairs, both times exponential."""
    return {"every": {"exponential": every}, "repair": {"exponential": repair}}


def crews_that_break_down(robots, every, repair, length):
    """A closed line of robots."""
    return {**breaks_down(crews(robots, 10.0, 30.0), every, repair), "run": {"length": length}}


def round_as_service(service, load, tasks, every, repair):
    """Tasks arrive at random for one robot that serves by driving, `service` for a round; it may break down on it."""
    length = tasks * service / load
    model = {
        "layout": TRIANGLE,
        "fleet": {"size": 1, "robot": {"radius": 0.05, "speed": AROUND / service}},
        "tasks": {"goods": {"poisson": 3600 * load / service}, "unload_at": ["A"], "load_time": 0, "unload_time": 0},
        "run": {"length": length, "warm_up": length / 10},
        "log": "tasks",
    }
    return breaks_down(model, every, repair)


def with_outages(model, every, repair):
    """A model in which every charger fails now and then."""
    home = {**model["layout"]["bays"]["home"], "outages": at_random(every, repair)}
    return {**model, "layout": {**model["layout"], "bays": {"home": home}}}


# Chargers

PETALS = 40
PETAL_SPEED = 1000.0


def petal_times(mean):
    """The times round the petals."""
    times = []
    for i in range(PETALS):
        low, high = (-math.log(1 - part) if part < 1 else math.inf for part in (i / PETALS, (i + 1) / PETALS))
        upper = (high + 1) * math.exp(-high) if math.isfinite(high) else 0.0
        times.append(PETALS * ((low + 1) * math.exp(-low) - upper) * mean)
    return times


def petals(mean):
    """Rings of two nodes at A; the times round them are about exponential: the means of equal parts of that law."""
    nodes, edges, storage = {"A": [0.0, 0.0]}, [], []
    for i, time in enumerate(petal_times(mean)):
        angle, half = 2 * math.pi * i / PETALS, time * PETAL_SPEED / 2
        nodes[f"P{i}"] = [half * math.cos(angle), half * math.sin(angle)]
        ends = ("A", f"P{i}"), (f"P{i}", "A")
        edges += [{"from": a, "to": b, "side_by_side": True} for a, b in ends]
        storage.append({"edge": ["A", f"P{i}"], "offset": half / 2})
    return {"nodes": nodes, "edges": edges, "storage": storage}


def fleet_with_one_charger(robots, up, swap, rounds):
    """After every task a robot needs a new battery; one is swapped at a time."""
    length = rounds * (up + swap)
    layout = petals(up)
    layout["bays"] = {"home": {"at": ["A"], "chargers": 1}}
    return {
        "layout": layout,
        "fleet": {"size": robots, "robot": {"radius": 0.05, "speed": PETAL_SPEED}},
        "tasks": {"goods": {"saturated": robots}, "unload_at": ["A"], "load_time": 0, "unload_time": 0},
        "battery": {"capacity": 1e4, "threshold": 0, "consumption": 1, "charge_rate": 1},
        "policies": {"charging": {"name": "swap", "time": swap, "level": 1 - 2e-6}},
        "run": {"length": length, "warm_up": length / 10},
        "log": "tasks",
    }


def fleet_with_spare_batteries(robots, spare, up, charge, rounds):
    """After every task a robot swaps its battery at once, if a spare one is full; each charges for the same time.

    Energy is drawn by loading alone, which takes no time to speak of.
    """
    model = fleet_with_one_charger(robots, up, 0, rounds)
    model["layout"]["bays"]["home"]["chargers"] = robots
    model["tasks"]["load_time"] = 1e-3
    draws = {"standing": 0, "empty": 0, "loaded": 0, "handling": 1e5}
    model["battery"] |= {"consumption": draws, "charge_rate": 100 / charge}
    model["policies"]["charging"]["batteries"] = spare
    return model


def fleet_on(chargers, robots, consumption, charge_rate, length=1e5):
    """Robots that always have work, and a battery that lasts for some dozen rounds of it."""
    return {
        "layout": {**TRIANGLE, "bays": {"home": {"at": ["A"], "chargers": chargers}}},
        "fleet": {"size": robots, "robot": {"radius": 0.05, "speed": 100}},
        "tasks": {"goods": {"saturated": robots}, "unload_at": ["A"], "load_time": 28, "unload_time": 0},
        "battery": {"capacity": 1000, "threshold": 600, "consumption": consumption, "charge_rate": charge_rate},
        "run": {"length": length, "warm_up": length / 5},
        "log": "tasks",
    }


def work_at_random(load, robots, consumption, charge_rate, tasks=1500):
    """Robots that serve at random, with batteries that last for some of it."""
    model = robots_that_serve(load, 1000.0, robots, tasks)
    battery = {"capacity": 5000, "threshold": 1000, "consumption": consumption, "charge_rate": charge_rate}
    return {**model, "battery": battery}


# Roads: robots keep D apart, so at speed v nothing lets more than v / D of them pass; who turns or crosses needs more

D, SPEED = 1.0, 2.0
ROBOT = {"radius": 0.4, "margin": 0.2, "speed": SPEED}


def oval(around, robots, *, node_time=0.0, unload_time=0.0):
    """A closed ring of four nodes; every robot drives round it without end, a good in each round."""
    side = around / 4
    length = 60 * around / SPEED
    return {
        "layout": {
            "nodes": {"A": [0, 0], "B": [side, 0], "C": [side, side], "E": [0, side]},
            "edges": [["A", "B"], ["B", "C"], ["C", "E"], ["E", "A"]],
            "storage": [{"edge": ["B", "C"], "offset": side / 2}],
            "bays": {"home": {"at": ["A"]}},
        },
        "fleet": {"size": robots, "robot": ROBOT},
        "tasks": {"goods": {"saturated": robots}, "unload_at": ["E"], "load_time": 0, "unload_time": unload_time},
        "traffic": {"node_time": node_time},
        "run": {"length": length, "warm_up": length / 2},
        "log": "moves",
    }


def street(robots):
    """Robots leave a bay at A for the good at the far end, two straight edges and a corner away."""
    nodes = {"A": [0, 0], "B": [40, 0], "C": [80, 0], "E": [80, 40], "F": [0, 40]}
    names = [*nodes, "A"]
    return {
        "layout": {
            "nodes": nodes,
            "edges": [[a, b] for a, b in pairwise(names)],
            "storage": [{"edge": ["E", "F"], "offset": 40}],
            "bays": {"home": {"at": ["A"]}},
        },
        "fleet": {"size": robots, "robot": ROBOT},
        "tasks": {"goods": [0] * robots, "unload_at": ["A"], "load_time": 0, "unload_time": 0},
        "log": "moves",
    }


def crossing(robots):
    """Two rings that cross in X at right angles; every robot keeps to its own, as its goods are nearer there."""
    far = 20 * D
    east, south = ["X", "E1", "E2", "E3", "E4", "X"], ["X", "S1", "S2", "S3", "S4", "X"]
    return {
        "layout": {
            "nodes": {
                "X": [0, 0],
                "E1": [far, 0],
                "E2": [far, -far],
                "E3": [-far, -far],
                "E4": [-far, 0],
                "S1": [0, far],
                "S2": [far * 1.5, far],
                "S3": [far * 1.5, -far * 1.5],
                "S4": [0, -far * 1.5],
            },
            "edges": [[a, b] for ring in (east, south) for a, b in pairwise(ring)],
            "storage": [{"edge": ["E1", "E2"], "offset": far / 2}, {"edge": ["S1", "S2"], "offset": far / 2}],
            "bays": {"east": {"at": ["E1"]}, "south": {"at": ["S1"]}},
        },
        "fleet": {"size": 2 * robots, "robot": ROBOT},
        "tasks": {
            "goods": {"saturated": 8 * robots},
            "unload_at": ["E1", "S1"] * robots,
            "load_time": 0,
            "unload_time": 0,
        },
        "policies": {"allocation": "nearest"},
        "run": {"length": 2000, "warm_up": 500},
        "log": "moves",
    }


# Lifts


def upstairs(robots, away, length):
    """All robots ride up in one lift, work `away` on average, at random times, and come down by a ramp.

    The cabin has to come down for each, and loading takes as long as its doors to close behind the one before.
    """
    nodes = {"hall": [0, 0], "below": [10, 0], "above": [10, 50], "ward": [0, 50]}
    lanes = [("hall", "below"), ("below", "hall"), ("above", "ward"), ("ward", "above")]
    return {
        "layout": {
            "nodes": nodes,
            "edges": [*({"from": a, "to": b, "side_by_side": True} for a, b in lanes), ["ward", "hall"]],
            "storage": [{"node": "hall"}],
            "lifts": {"main": {"nodes": ["below", "above"], "ride": CABIN, "doors": DOORS}},
            "bays": {"home": {"at": ["hall"]}},
            "stations": {"ward": {"at": ["ward"], "places": robots, "servers": robots}},
        },
        "fleet": {"size": robots, "robot": FAST},
        "tasks": {
            "goods": {"saturated": 2 * robots},
            "unload_at": ["ward"],
            "load_time": DOORS,
            "unload_time": {"exponential": away},
        },
        "traffic": {"node_time": 0},
        "run": {"length": length, "warm_up": length / 20},
        "log": "tasks",
    }


# People who pick into robots


def robots_that_wait_for_pickers(robots, pickers, away, pick, tasks):
    """Robots that fetch from a lane of their own, where they wait for a picker, and unload for `away` at random.

    Pickers are everywhere at once, and serve robots in the order in which they came; picks take `pick` at random.
    """
    nodes, edges, storage, flows = {"A": [0.0, 0.0]}, [], [], {}
    for number in range(robots):
        angle, far = 2 * math.pi * number / robots, f"P{number}"
        nodes[far] = [10 * math.cos(angle), 10 * math.sin(angle)]
        edges += [{"from": a, "to": b, "side_by_side": True} for a, b in (("A", far), (far, "A"))]
        storage.append({"edge": ["A", far], "offset": 5})
        mine = [float(other == number) for other in range(robots)]
        flow = {"from": {"popularity": {"weights": mine}}, "to": ["hall"], "arrivals": {"saturated": 2}}
        flows[f"f{number}"] = {**flow, "kinds": [f"k{number}"]}
    length = tasks / repairmen(robots, pickers, away, pick)
    return {
        "layout": {
            "nodes": nodes,
            "edges": edges,
            "storage": storage,
            "bays": {"home": {"at": ["A"], "places": robots}},
            "stations": {"hall": {"at": ["A"], "places": robots, "servers": robots}},
        },
        "fleet": {"size": robots, "robot": FAST, "kinds": {f"k{number}": {"count": 1} for number in range(robots)}},
        "tasks": {"flows": flows, "load_time": {"exponential": pick}, "unload_time": {"exponential": away}},
        "pickers": {"count": pickers, "speed": 1e9, "choose": "longest-waiting"},
        "policies": {"allocation": "nearest"},
        "run": {"length": 1.1 * length, "warm_up": 0.1 * length},
        "log": "tasks",
    }


# Goods to person


def hall_of_pods(lines, pod, share):
    """A hall of 170 pods with so many orders of one line open at a station; of 1,000 items, so that all differ."""
    pods = {**HALL["pods"], "items": 1000, "per_pod": round(1000 * share), "orders": lines}
    return {**HALL, "pods": pods, "policies": {**HALL["policies"], "pod": pod}}
