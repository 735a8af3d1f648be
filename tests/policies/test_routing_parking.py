"""Routing against brute force, congestion and detours; parking by hand; the choice of stations."""

import itertools

import networkx as nx
import pytest

import desim_warehouse as dw
from desim_warehouse.policies import BayView, Roads, RobotView, create
from desim_warehouse.policies.routing import CongestionAware
from desim_warehouse.world import World

MULTIBOTS = dw.load("models/multibots.yaml")


def roads(world, queued=None, waits=None):
    shown = world.routes.roads
    return Roads(
        shown.graph,
        shown.oracle,
        {edge: (waits or {}).get(edge, 0.0) for edge in shown.graph.edges},
        lambda edge: (queued or {}).get(edge, 0),
        shown.speed,
        shown.node_time,
        shown.contact,
    )


def cost_of(world, way, waits):
    edges = itertools.pairwise(way)
    graph = world.layout.graph
    return sum(graph.edges[edge]["length"] / 4 + 1.5 + waits.get(edge, 0.0) for edge in edges)


@pytest.mark.parametrize("name", ["shortest", "fastest", "congestion-aware"])
@pytest.mark.parametrize("waits", [{}, {("G", "H"): 100.0, ("C", "D"): 33.0, ("N", "M"): 20.0}])
def test_no_way_is_cheaper(name, waits):
    world = World(MULTIBOTS)
    policy, shown = create("routing", name, {}), roads(world, waits=waits)
    felt = waits if name == "congestion-aware" else {}
    graph = world.layout.graph
    for origin, goal in itertools.permutations("ACEGHLMPR", 2):
        best = min(cost_of(world, way, felt) for way in nx.all_simple_paths(graph, origin, goal))
        assert cost_of(world, policy.route(origin, goal, shown), felt) == pytest.approx(best)


def test_highways_is_algorithm_1_as_the_paper_gives_it():
    world = World(MULTIBOTS)
    policy, shown = create("routing", "highways", {}), roads(world)
    assert "".join(policy.route("A", "O", shown)) == "ABCDJPO"
    assert "".join(policy.route("I", "M", shown)) == "IJPONM"


def test_a_queue_turns_a_robot_to_another_way():
    world = World(MULTIBOTS)
    free = list(CongestionAware().route("G", "P", roads(world)))
    edge = (free[0], free[1])
    assert edge in (("G", "H"), ("G", "A"))
    other = list(CongestionAware().route("G", "P", roads(world, queued={edge: 20})))
    assert other[1] != free[1]
    assert list(CongestionAware(queues=0).route("G", "P", roads(world, queued={edge: 20}))) == free


BUSY = {
    "fleet.size": 30,
    "layout.bays.charging.places": 5,
    "tasks.goods": {"random": 150},
    "tasks.unload_at": ["M", "O", "R"],
    "tasks.station_choice": "nearest",
    "battery.threshold": 4.5,
    "battery.reserve": 9,
    "policies.routing": "congestion-aware",
}


@pytest.mark.parametrize(
    ("policy", "changes"), [({"name": "congestion-aware", "detours": 0}, True), ("fastest", False)]
)
def test_routes_follow_traffic_also_where_nobody_decides_again_on_the_way(policy, changes):
    world = World(MULTIBOTS.replace({**BUSY, "policies.routing": policy}), 2)
    taken = {}
    original = world.routes.route

    def route(origin, goal, *how):
        lanes = original(origin, goal, *how)
        taken.setdefault((origin, goal), set()).add(tuple(lane.edge for lane in lanes))
        return lanes

    world.routes.route = route
    world.run()
    assert any(len(routes) > 1 for routes in taken.values()) is changes


def test_detours_are_taken_and_limited_and_work_still_ends():
    taken = []

    world = World(MULTIBOTS.replace(BUSY), 2)
    original = world.routes.detour

    def detour(node, route, index, stop):
        way = original(node, route, index, stop)
        if way is not None:
            taken.append(node)
            assert way[-1] is route[-1] or stop is None
        return way

    world.routes.detour = detour
    world.run()
    assert world.dispatcher.done == 150
    assert taken


BAYS = [BayView("A", 1, 1, 2), BayView("C", 2, 0, 0), BayView("F", 1, 0, 0)]


@pytest.mark.parametrize(
    ("name", "node", "home", "last", "chosen"),
    [
        ("home", "M", "F", "A", "F"),
        ("home", "M", "B", "C", "A"),  # home is full: M > G > A is nearest
        ("stay", "M", "A", "C", "C"),
        ("stay", "M", "F", "D", "A"),
        ("nearest", "M", "F", "F", "A"),
        ("nearest", "B", "A", "A", "C"),
        ("spread", "M", "A", "A", "C"),  # nobody at C and F; C is nearer
        ("spread", "D", "A", "A", "F"),
    ],
)
def test_parking_policies_choose_as_worked_by_hand(name, node, home, last, chosen):
    world = World(MULTIBOTS)
    robot = RobotView(0, node, home, 5.0, 10.0, 3.5, last)
    assert create("parking", name, {}).choose(robot, BAYS, world.travel) == chosen


def stations(choice, goods, **more):
    changes = {"tasks.unload_at": ["M", "R"], "tasks.station_choice": choice, "tasks.goods": goods, "fleet.size": 4}
    run = dw.simulate(MULTIBOTS.replace({**changes, **more}), 7)
    return {row[3]: row[4] for row in run.record.rows if row[1] == "unloading"}


def test_the_nearest_station_is_counted_from_the_good():
    travel = World(MULTIBOTS).travel
    storage = World(MULTIBOTS).layout.storage
    for task, node in stations("nearest", [0, 20, 40, 79]).items():
        end = storage[[0, 20, 40, 79][task]].edge[1]
        assert node == min("MR", key=lambda name: travel.ways.time(end, name))


def test_the_least_loaded_station_has_the_fewest_robots_on_their_way():
    used = stations("least-loaded", [0, 0, 0, 0])
    assert sorted(used.values()) == ["M", "M", "R", "R"]


def test_a_random_station_depends_on_the_task_and_the_seed_alone():
    goods = list(range(20))
    one = stations("random", goods)
    assert one == stations("random", goods, **{"fleet.size": 2, "policies.allocation": "nearest"})
    assert set(one.values()) == {"M", "R"}


def test_decisions_are_collected_for_an_interval():
    goods = [{"good": i, "release": 10 * i} for i in range(6)]
    run = dw.simulate(MULTIBOTS.replace({"tasks.goods": goods, "policies.interval": 100}))
    given = [row[0] for row in run.record.rows if row[1] == "assigned"]
    assert given == [0, 100, 100, 100, 100, 100]


def test_until_the_next_decision_a_robot_in_a_station_has_unloaded_and_its_server_is_free():
    """Goods 0 and 1 come to M with two robots, decided on every 100 s: 20 s of unloading each, and no more."""
    inside = {"layout.stations": {"pack": {"at": ["M"], "places": 2, "servers": 2}}, "fleet.size": 2, "log": "all"}
    often = MULTIBOTS.replace({**inside, "tasks.goods": [0, 1], "tasks.unload_at": ["M", "M"]})
    seldom = often.replace({"policies.interval": 100})
    run = dw.simulate(seldom)
    assert run.robots["unloading"].sum() == dw.simulate(often).robots["unloading"].sum() == 2 * 20
    delivered = {row[2]: row[0] for row in run.record.rows if row[1] == "delivered"}
    begun = {row[2]: row[0] for row in run.record.rows if row[1] == "awaiting"}
    left = {row[2]: row[0] for row in run.record.rows if row[1] == "returning"}
    assert begun == delivered
    assert all(at % 100 == 0 for at in left.values())
    waited = sum(left[robot] - delivered[robot] for robot in (0, 1))
    assert 0 < waited < 200
    assert run.robots["awaiting"].sum() == pytest.approx(waited)
    assert run.kpis["share_awaiting"] == pytest.approx(waited / (2 * run.T))
    assert "share_awaiting" not in dw.simulate(often).kpis


def test_a_robot_that_unloads_in_a_station_can_take_the_next_task_for_the_same_station():
    inside = {"layout.stations": {"pack": {"at": ["M"], "places": 1}}, "fleet.size": 1, "tasks.goods": [0, 1, 2]}
    run = dw.simulate(MULTIBOTS.replace(inside))
    docked = [row for row in run.record.rows if row[1] == "docked"]
    assert len(docked) == 3
    assert len([row for row in run.record.rows if row[1] == "parked"]) == 1
