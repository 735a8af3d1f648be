"""On two-way lanes work ends, too: networks of every shape, batteries that recall robots, routes that change."""

import random

import pytest

import desim_warehouse as dw
from desim_warehouse.world.traffic.deadlock.plan import Plan
from tests.auditor import audit
from tests.laws.two_way import KINDS, Slots, network


def model(kind, seed):
    """A whole model on a random network: goods on lanes, bays and stations beside nodes, unloading in the lane."""
    draw = random.Random(f"model {kind} {seed}")
    graph = network(kind, draw)
    nodes = list(graph)
    size = draw.randint(2, 25)
    homes = draw.sample(nodes, draw.randint(1, min(3, len(nodes))))
    unload = draw.sample(nodes, draw.randint(1, min(3, len(nodes))))
    edges = [{"from": a, "to": b, "length": length} for a, b, length in graph.edges(data="length")]
    speeds = random.Random(f"speeds {kind} {seed}")
    if speeds.random() < 0.3:  # other limits there than back
        edges = [{**edge, "speed": speeds.choice((0.3, 0.6, 1.0))} for edge in edges]
    battery = {"capacity": 4000.0, "threshold": 0.0, "consumption": 1, "charge_rate": 20, "reserve": 1e9}
    charging = "threshold"
    if draw.random() < 0.5:
        charging = {"name": "reach-aware", "margin": draw.choice([0.1, 0.4])}
    else:
        battery["threshold"] = 4000.0 - draw.randint(50, 800)
    places = []
    for _ in range(draw.randint(1, 8)):
        a, b, length = draw.choice(list(graph.edges(data="length")))
        places.append({"edge": [a, b], "offset": round(length * draw.uniform(0.05, 0.95), 3)})
    return {
        "layout": {
            "nodes": {name: [data["x"], data["y"]] for name, data in graph.nodes(data=True)},
            "edges": edges,
            "storage": places,
            "bays": {"home": {"at": homes, "places": -(-size // len(homes)) + draw.choice([0, 1])}},
            "stations": {f"s{i}": {"at": [node], "places": 2} for i, node in enumerate(unload) if draw.random() < 0.5},
        },
        "fleet": {"size": size, "robot": {"radius": 0.5, "speed": 1.0}, "exit_time": draw.choice([0.0, 1.5])},
        "tasks": {
            "goods": {"random": draw.randint(1, 60)},
            "unload_at": unload,
            "station_choice": draw.choice(["nearest", "random", "least-loaded"]),
            "load_time": 2.0,
            "unload_time": 3.0,
        },
        "traffic": {"node_time": draw.choice([0.0, 0.4])},
        "battery": battery if draw.random() < 0.6 else None,
        "policies": {
            "routing": draw.choice(["shortest", {"name": "congestion-aware", "detours": draw.randint(1, 3)}]),
            "charging": charging,
            "parking": draw.choice(["home", "nearest", "stay", "spread"]),
        },
    }


def all_come_home(kind, seeds):
    for seed in seeds:
        slots = Slots(kind, seed).run()
        assert not slots.stalled, seed
        assert slots.problems == [], seed


@pytest.mark.parametrize("kind", KINDS)
def test_robots_on_two_way_lanes_all_come_home(kind):
    """200 networks with 2 to 50 robots; what happened is held against the log, too."""
    all_come_home(kind, range(25))


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("first", range(25, 1300, 25))
def test_robots_on_five_thousand_networks_all_come_home(kind, first):
    all_come_home(kind, range(first, first + 25))


@pytest.mark.parametrize(("kind", "seed"), [("ring", 6), ("bridges", 28)])
def test_the_claim_that_the_plan_begins_with_must_be_looked_at_again(kind, seed, monkeypatch):
    """Those whose moves come first by the plan may have been refused for robots that have not moved since."""
    monkeypatch.setattr(Plan, "first", lambda _: None)
    assert Slots(kind, seed).run().stalled


@pytest.mark.parametrize("kind", KINDS)
def test_without_the_rule_they_are_stuck(kind):
    """So the law says something: of fleets of five and more nearly all end face to face (146 of 160)."""
    runs = [Slots(kind, seed, rule="stop", recalls=False, trips=40) for seed in range(40)]
    runs = [run for run in runs if len(run.robots) >= 5]
    stuck = 0
    for run in runs:
        try:
            stuck += run.run().stalled
        except dw.SimulationError:
            stuck += 1
    assert stuck >= 0.7 * len(runs)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [*range(5), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(5, 400))])
def test_every_task_ends_on_two_way_lanes(kind, seed):
    run = dw.simulate(dw.load(model(kind, seed)), seed)
    assert run.kpis["tasks"] == run.model.tasks.goods.random
    assert audit(run) == []
