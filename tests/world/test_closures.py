"""Edges that are closed or slow at times: who waits, for how long, what it is counted as, and which detour pays."""

import math

import pytest

import desim_warehouse as dw
from desim_warehouse.outcome.chains import lost_to
from desim_warehouse.questions.check import check
from desim_warehouse.study.suspects import suspects
from tests.auditor import audit
from tests.recount import differences
from tests.world.test_zones import LOOP, on

pytestmark = pytest.mark.usefixtures("brief_probes")


def closed(*members, at, **more):
    """LOOP with one robot and one good, and a closure of some members at some stretches of the run."""
    return dw.load(
        LOOP,
        {
            "fleet.size": 1,
            "tasks.goods": [0],
            "calendars": {"works": {"between": [list(stretch) for stretch in at]}},
            "traffic.closures": {"works": {"members": list(members), "hours": "works", "tasks": "go"}},
            **more,
        },
    )


@pytest.mark.parametrize(
    ("at", "enters", "waits"),
    [
        ((5, 50), 51, 41),  # at the stop line, 1 before B, at 9; at 50 it sets out
        ((9, 50), 51, 41),
        ((9.5, 50), 10, 0),  # it has set out for the edge: node and room are its own
        ((15, 50), 10, 0),  # it is on the edge, and drives on and out
        ((2, 9), 10, 0),  # opens as it comes
    ],
)
def test_a_robot_waits_at_the_stop_line_for_an_edge_to_open_and_drives_on_if_it_is_on_it(at, enters, waits):
    run = dw.simulate(closed(["B", "C"], at=[at]))
    assert on(run, ("B", "C"))[0] == pytest.approx((enters, enters + 20))
    assert run.kpis["waiting_closed"] == waits
    assert (run.S, run.kpis["waiting"]) == (0, 0)  # no collision
    assert run.kpis["share_waiting_closed"] == pytest.approx(waits / run.T)
    assert audit(run) == differences(run) == []


def test_a_queue_before_a_closed_edge_waits_for_that_in_the_account():
    """In the log robot 0 waits for the edge, 1 and 2 for the robot ahead; until it opens at 50 all wait for it."""
    run = dw.simulate(closed(["B", "C"], at=[(5, 50)], **{"fleet.size": 3, "tasks.goods": [0, 0, 0]}))
    first = run.waits[run.waits["start"] < 50]
    assert list(zip(first["robot"], first["cause"], strict=True))[-3:] == [
        (0, "waiting_closed"),
        (1, "waiting"),
        (2, "waiting"),
    ]
    assert run.kpis["waiting_closed"] == 41
    robots = run.account("robot")
    assert list(robots["waiting_closed"]) == pytest.approx([50 - start for start in first["start"].iloc[-3:]])
    assert robots["waiting_closed"].iloc[0] == 41
    assert robots.sum(axis=1).to_numpy() == pytest.approx(run.T)
    lost = {root.cause: time for root, (time, _) in lost_to(run.history).items()}
    assert lost["waiting_closed"] == pytest.approx(robots["waiting_closed"].sum())
    assert run.account("hour")["waiting_closed"].sum() == pytest.approx(lost["waiting_closed"])
    both = run.account("edge")["waiting_closed"].sum() + run.account("node")["waiting_closed"].sum()
    assert both == pytest.approx(lost["waiting_closed"])
    (closures,) = [suspect for suspect in suspects(run) if suspect.name == "closures"]
    assert closures.waited == pytest.approx(both / (3 * run.T))
    assert audit(run) == differences(run) == []


def test_a_closed_node_closes_the_edges_that_lead_to_it():
    """C is closed: the robot waits before B; E>A and the others stay open."""
    run = dw.simulate(closed("C", at=[(0, 50)]))
    assert on(run, ("B", "C"))[0][0] == 51
    assert {row[5] for row in run.record.rows if row[1] == "edge_closed"} == {("B", "C")}


def test_it_waits_in_its_bay_for_an_edge_that_is_too_short_to_stand_on():
    """A>B is 1.5 long, below 2 D: in the bay it is in nobody's way, on A it would be."""
    layout = {**LOOP["layout"], "nodes": {**LOOP["layout"]["nodes"], "B": [1.5, 0]}}
    run = dw.simulate(closed(["A", "B"], at=[(0, 50)], layout=layout))
    assert on(run, ("A", "B"))[0][0] == 50
    assert run.waits.loc[0, ["start", "end", "node", "cause"]].tolist() == [0, 50, "A", "waiting_closed"]
    assert audit(run) == differences(run) == []


@pytest.mark.parametrize(("at", "enters"), [((5, 50), 51.5), ((10.5, 50), 50)])
def test_it_does_not_go_onto_the_node_before_a_short_edge_that_is_closed(at, enters):
    """B>C is 1.5 long. Closed at 5, the robot waits D before B until 50; closed as it drives onto B, it waits there."""
    layout = {**LOOP["layout"], "nodes": {**LOOP["layout"]["nodes"], "C": [11.5, 0]}}
    enters = enters if at[0] == 10.5 else 51
    at = (9.5, 50) if at[0] == 10.5 else at
    run = dw.simulate(closed(["B", "C"], at=[at], layout=layout))
    assert on(run, ("B", "C"))[0][0] == enters
    assert audit(run) == differences(run) == []


SPUR = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [40, 0]},
        "edges": [{"from": a, "to": b, "two_way": True} for a, b in (("A", "B"), ("B", "C"))],
        "storage": [{"edge": ["B", "C"], "offset": 10.0}],
        "bays": {"home": {"at": ["A"], "places": 1}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {"goods": [0], "unload_at": ["A"], "load_time": 5, "unload_time": 1},
    "policies": {"routing": "shortest"},
}


def test_who_is_in_what_is_closed_turns_round_there_and_comes_out():
    """The closure comes while it loads, at 30; it drives to C and back, and out of both edges that are closed."""
    over = {
        "calendars": {"works": {"between": [[32, 500]]}},
        "traffic.closures": {"works": {"members": [["A", "B"], ["B", "C"]], "hours": "works"}},
    }
    assert dw.simulate(dw.load(SPUR, over)).T == dw.simulate(dw.load(SPUR)).T


def test_a_closure_that_never_ends_stalls_a_run_and_the_message_names_the_edge():
    """From 5 on for ever: in 5 time units it could have been passed, so a check cannot know."""
    model = closed(["B", "C"], at=[(5, 1e12)], calendars={"works": {"every": 1e9, "lasts": 1e9, "first": 5}})
    with pytest.raises(dw.SimulationError, match=r"closed, and never open again: B>C \(traffic.closures\)"):
        dw.simulate(model)


def test_a_closure_of_the_whole_run_that_cuts_something_off_is_an_error_before_it():
    model = closed(["B", "C"], at=[(0, 1000)], **{"run.length": 1000})
    errors = [item.problem for item in check(model).errors]
    assert any("traffic.closures.works: closed for the whole run" in text and "[CUT_OFF]" in text for text in errors)
    with pytest.raises(dw.CheckError, match="CUT_OFF"):
        dw.simulate(model)


@pytest.mark.parametrize(
    ("members", "message"),
    [
        ([["A", "C"]], "no such edge"),
        (["X"], "no such node"),
        (["A>B"], r"no such node .*; an edge is written \[A, B\]"),
        ([], "members"),
    ],
)
def test_what_is_not_there_is_refused(members, message):
    with pytest.raises(dw.ModelError, match=message):
        closed(*members, at=[(0, 1)])


def test_a_calendar_that_is_not_there_is_refused():
    with pytest.raises(dw.ModelError, match=r"traffic.closures.x.hours: no such calendar .*did you mean 'night'"):
        dw.load(
            LOOP,
            {
                "calendars": {"night": {"open": ["22:00-06:00"]}},
                "traffic.closures": {"x": {"members": ["B"], "hours": "nigt"}},
            },
        )


def test_an_edge_in_an_intersection_cannot_be_closed():
    zone = {"traffic.zones": {"narrow": {"members": [["B", "C"]], "rule": "one-robot"}}}
    with pytest.raises(dw.CheckError, match=r"B>C lies in an intersection.*CLOSURE"):
        dw.simulate(closed(["B", "C"], at=[(0, 1)], **zone))


def test_who_waits_for_an_edge_on_two_way_lanes_holds_nobody_else_in_their_bays():
    """Robot 0 waits two hours for the spur X; robot 1 fetches from Y all the while, long past what patience allows."""
    spurs = {"A": [-20, 0], "B": [20, 0], "X": [0, 20], "Y": [0, -20]}
    model = {
        "layout": {
            "nodes": {"C": [0, 0], **spurs},
            "edges": [{"from": "C", "to": name, "two_way": True} for name in spurs],
            "storage": [{"edge": ["C", "X"], "offset": 10}, {"edge": ["C", "Y"], "offset": 10}],
            "bays": {"home": {"at": ["A", "B"], "places": 1}},
            "stations": {"packing": {"at": ["B"], "places": 2}},
        },
        "fleet": {"size": 2, "start": ["A", "B"], "robot": {"radius": 0.5, "speed": 1}},
        "tasks": {"goods": [0, *[1] * 40], "unload_at": ["packing"], "load_time": 5, "unload_time": 5},
        "policies": {"routing": "shortest"},
        "calendars": {"works": {"between": [[0, 7200]]}},
        "traffic": {"closures": {"works": {"members": [["C", "X"]], "hours": "works", "tasks": "go"}}},
    }
    run = dw.simulate(dw.load(model))
    delivered = [task.delivered for task in run.history.delivered]
    assert run.kpis["waiting_closed"] > 7000
    assert 2000 < delivered[-2] < 4000  # one after the other, without a break
    assert delivered[-1] > 7200
    assert audit(run) == differences(run) == []


# Slow zones


def test_in_a_slow_zone_a_robot_is_slow_and_keeps_its_pace_where_it_is_already():
    """B>C takes 20 at full speed. From 15 on it is slow: the first time the robot is on it by then, later it is not."""
    over = {"fleet.size": 1, "tasks.goods": [0], "calendars": {"works": {"between": [[15, 120]]}}}
    slow = {"traffic.slow": {"works": {"members": [["B", "C"]], "speed": 0.5, "hours": "works"}}}
    run = dw.simulate(dw.load(LOOP, {**over, **slow}))
    assert on(run, ("B", "C")) == [pytest.approx((10, 30)), pytest.approx((106.5685424949238, 146.5685424949238))]
    assert audit(run) == differences(run) == []
    always = dw.simulate(dw.load(LOOP, {**over, "traffic.slow": {"works": {"members": ["C"], "speed": 0.5}}}))
    assert on(always, ("B", "C"))[0] == pytest.approx((10, 50))


def slow(stretches, speed=0.5, **more):
    """LOOP with a good on the far side, and B>C slow at times."""
    over = {"fleet.size": 1, "tasks.goods": [0], "calendars": {"works": {"between": stretches}}, **more}
    return dw.load(
        LOOP, {**over, "traffic.slow": {"works": {"members": [["B", "C"]], "speed": speed, "hours": "works"}}}
    )


@pytest.mark.parametrize(
    ("at", "leaves"), [((9.5, 60), 50), ((10, 60), 50), ((0, 9.5), 30), ((0, 10), 30), ((0, 11), 50)]
)
def test_its_speed_is_of_the_instant_at_which_it_enters_and_not_at_which_it_sets_out(at, leaves):
    """At 9 it is at the stop line, and node and room are its own; at 10 it enters B>C, which takes 20 or 40."""
    run = dw.simulate(slow([list(at)]))
    assert on(run, ("B", "C"))[0] == pytest.approx((10, leaves))
    assert audit(run) == []


def test_where_it_has_to_brake_for_the_zone_it_does_so_before_it():
    """From a stand it is at B at 11; braking from 1 to 0.5 before it takes 0.25 more, and so does going on."""
    run = dw.simulate(slow([[10.5, 200]], **{"fleet.robot.acceleration": 0.5, "fleet.robot.deceleration": 0.5}))
    assert on(run, ("B", "C"))[0] == pytest.approx((11.25, 51.5))
    assert audit(run) == []


@pytest.mark.parametrize(("motion", "late"), [({}, 0), ({"fleet.robot.acceleration": 1000}, 0.01)])
@pytest.mark.parametrize(("opens", "enters"), [(100, (100, 300)), (150, (150, 350)), (1000, (182, 211))])
def test_a_robot_that_waits_before_the_zone_has_the_speed_of_when_it_enters(opens, enters, motion, late):
    """The first enters at 10 at 0.1, and is at the stop line at 200. From 10.5 on the zone is not slow.

    So the second would enter at 182, and be D behind the first there. But the zone is slow again from `opens` on, and
    at 0.1 it may enter at any time.
    """
    both = {"fleet.size": 2, "tasks.goods": [0, 0], **motion}
    run = dw.simulate(slow([[0, 10.5], [opens, 2000]], 0.1, **both))
    assert on(run, ("B", "C"))[:2] == [pytest.approx((10, 210), abs=late), pytest.approx(enters, abs=late + 1e-9)]
    assert audit(run) == []


# Routes round a closure


FORK = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [30, 0], "D": [40, 0], "u": [10, 10], "v": [30, 10], "E": [20, -20]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["B", "u"], ["u", "v"], ["v", "C"], ["D", "E"], ["E", "A"]],
        "storage": [{"edge": ["C", "D"], "offset": 5.0}],
        "bays": {"home": {"at": ["A"], "places": 1}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}},
    "tasks": {"goods": [0], "unload_at": ["A"], "load_time": 0, "unload_time": 1},
    "policies": {"routing": "congestion-aware"},
}


@pytest.mark.slow
@pytest.mark.parametrize("routing", ["highways", "shortest", "fastest", "congestion-aware"])
def test_a_slow_zone_that_always_holds_is_a_speed_limit_to_routes_and_estimates_too(routing):
    """B>C takes 200 at 0.1, so whoever chooses by time goes round; the hand calculation and batteries know it."""
    over = {"policies.routing": routing, "battery": {"capacity": 1e4, "threshold": 100}}
    over["battery"] |= {"consumption": 1.0, "charge_rate": 10}
    slow = dw.load(FORK, {**over, "traffic.slow": {"works": {"members": [["B", "C"]], "speed": 0.1}}})
    limit = dw.load(FORK, {**over, "layout.edges.1": {"from": "B", "to": "C", "speed": 0.1}})
    assert dw.simulate(slow).kpis == dw.simulate(limit).kpis
    assert on(dw.simulate(slow), ("u", "v")) or routing in ("shortest", "highways")
    assert check(slow).lines == check(limit).lines


@pytest.mark.parametrize(
    ("until", "routing", "round_it"),
    [
        (32, "congestion-aware", True),  # it would be at B at 10, and wait 22; the way round is 20 longer
        (29, "congestion-aware", False),  # it waits 19
        (32, "shortest", True),
        (29, "highways", False),
        (10, "congestion-aware", False),
    ],
)
def test_a_new_route_goes_round_an_edge_that_is_closed_longer_than_the_way_round_takes(until, routing, round_it):
    over = {
        "calendars": {"works": {"between": [[0, until]]}},
        "traffic.closures": {"works": {"members": [["B", "C"]], "hours": "works", "tasks": "go"}},
        "policies.routing": routing,
    }
    run = dw.simulate(dw.load(FORK, over))
    assert bool(on(run, ("u", "v"))) == round_it
    assert run.kpis["waiting_closed"] == (0 if round_it else max(until - 9, 0) if until > 10 else 1)


@pytest.mark.parametrize(("detours", "round_it"), [(1, True), (0, False)])
def test_a_robot_that_is_held_up_before_an_edge_takes_a_detour(detours, round_it):
    """Nobody knows that somebody comes at 5; who sees them at the stop line expects 50 more, half of a stay of 100."""
    over = {
        "people": {"pickers": {"aisles": [["B", "C"]], "times": [5], "stay": 100}},
        "policies.routing": {"name": "congestion-aware", "detours": detours},
    }
    run = dw.simulate(dw.load(FORK, over))
    assert bool(on(run, ("u", "v"))) == round_it
    assert run.kpis["waiting_person"] == (0 if round_it else 105 - 9)


def test_policies_see_for_how_long_edges_are_closed():
    seen = []

    class Looks:
        def route(self, origin, goal, roads):
            seen.append([roads.closed_for(("B", "C"), after) for after in (0.0, 10.0, 30.0, 60.0)])
            return roads.oracle("length").way(origin, goal)

    from desim_warehouse.world import World

    over = {
        "calendars": {"works": {"between": [[5, 25], [40, 1e12]]}},
        "traffic.closures": {"works": {"members": [["B", "C"]], "hours": "works"}},
    }
    world = World(dw.load(FORK, over))
    world.routes.policy = Looks()
    world.routes.route("A", "D")
    assert seen == [[0.0, 15.0, 0.0, pytest.approx(1e12 - 60)]]
    assert math.isfinite(seen[0][3])


@pytest.mark.parametrize(("detours", "asked"), [("", 0), ("    detours = 2\n", 2)])
def test_a_policy_of_the_users_own_is_asked_on_the_way_as_often_as_it_says(tmp_path, detours, asked):
    """Somebody is on B>C from 5 to 105, and the robot is held up before it from 9 on."""
    from desim_warehouse.world import World

    file = tmp_path / "own.py"
    route = "    def route(self, a, b, roads):\n        return roads.oracle('length').way(a, b)\n"
    file.write_text(f"class Own:\n{detours}{route}", encoding="utf-8")
    people = {"pickers": {"aisles": [["B", "C"]], "times": [5], "stay": 100}}
    world = World(dw.load(FORK, {"people": people, "policies.routing": f"{file}:Own"}), 0)
    assert world.routes.detours == asked


# Tasks behind a closure


def behind(model, *between, members=(("B", "C"),), **over):
    """A model with a closure that holds tasks back, by default."""
    closures = {"works": {"members": [list(edge) for edge in members], "hours": "works"}}
    return dw.load(
        model, {"calendars.works": {"between": [list(one) for one in between]}, "traffic.closures": closures, **over}
    )


BOTH = (("B", "C"), ("u", "v"))
EVERY = ("highways", "shortest", "fastest", "congestion-aware")


def rows(run, *kinds):
    return [(row[0], row[1]) for row in run.record.rows if row[1] in kinds]


@pytest.mark.parametrize(
    ("routing", "until", "assigned", "picked"),
    [
        *((name, 200, 0, 55) for name in EVERY)  # they go round by u and v, 20 longer
    ],
)
def test_a_task_waits_until_there_is_an_open_way_to_its_good(routing, until, assigned, picked):
    run = dw.simulate(behind(FORK, (0, until), **{"policies.routing": routing, "fleet.exit_time": 0}))
    assert rows(run, "assigned", "loading") == [(assigned, "assigned"), (picked, "loading")]
    assert run.kpis["waiting_closed"] == 0
    assert audit(run) == differences(run) == []


@pytest.mark.parametrize("routing", EVERY)
@pytest.mark.parametrize(
    ("until", "picked", "waits"),
    [
        (28, 54, 19),  # at the stop line at 9: 19 to wait are less than 20 more to drive
        (30, 55, 0),  # 21 are more
    ],
)
def test_a_robot_goes_round_where_it_would_wait_for_longer_than_that_takes(routing, until, picked, waits):
    run = dw.simulate(behind(FORK, (0, until), **{"policies.routing": routing, "fleet.exit_time": 0}))
    assert rows(run, "loading") == [(picked, "loading")]
    assert run.kpis["waiting_closed"] == waits
    assert audit(run) == differences(run) == []


def test_a_robot_on_its_way_turns_off_at_the_next_node_and_the_task_waits():
    """It closes at 5, on the way from A to B at 10; by u and w it is home at 40. At 200 it sets out again, for 35."""
    layout = {**FORK["layout"], "nodes": {**FORK["layout"]["nodes"], "w": [0, 10]}}
    layout["edges"] = [*layout["edges"], ["u", "w"], ["w", "A"]]
    over = {"policies.routing": "shortest", "layout": layout}
    run = dw.simulate(behind(FORK, (5, 200), members=BOTH, **over))
    events = rows(run, "assigned", "returned", "parked", "loading")
    assert events[:5] == [(0, "assigned"), (5, "returned"), (40, "parked"), (200, "assigned"), (235, "loading")]
    assert run.kpis["waiting_closed"] == 0
    assert audit(run) == differences(run) == []


def test_it_goes_on_where_its_way_home_is_closed_too():
    run = dw.simulate(behind(FORK, (5, 200), members=BOTH, **{"policies.routing": "shortest"}))
    assert rows(run, "returned") == []
    assert run.kpis["waiting_closed"] == 200 - 9


def test_on_two_way_lanes_it_declares_its_way_home_first():
    """Closed at 5, at B at 20 and home at 40; from 100 on all is as without the closure, where it takes 86."""
    run = dw.simulate(behind(SPUR, (5, 100)))
    assert rows(run, "returned", "parked")[:2] == [(5, "returned"), (40, "parked")]
    assert dw.simulate(dw.load(SPUR)).T + 100 == run.T
    assert audit(run) == differences(run) == []


def test_it_turns_off_for_a_task_only_once():
    """It sets out at 100 again, on the way at 105, and is at the stop line before B from 119 to 300."""
    run = dw.simulate(behind(SPUR, (5, 100), (105, 300)))
    assert [time for time, _ in rows(run, "returned")] == [5]
    assert run.kpis["waiting_closed"] == 300 - 119
    assert audit(run) == differences(run) == []


def test_a_task_behind_closures_that_are_never_open_together_is_not_held_back():
    over = {
        "calendars": {"even": {"every": 100, "lasts": 50}, "odd": {"every": 100, "lasts": 50, "first": 50}},
        "traffic.closures": {
            "first": {"members": [["A", "B"]], "hours": "even"},
            "second": {"members": [["B", "C"]], "hours": "odd"},
        },
    }
    run = dw.simulate(dw.load(SPUR, over))
    assert rows(run, "assigned")[0][0] == 0
    assert run.kpis["waiting_closed"] > 0
    assert audit(run) == []


def test_while_a_station_is_cut_off_nothing_is_fetched_for_it():
    run = dw.simulate(behind(LOOP, (0, 500), members=[("C", "D")], **{"tasks.goods": [0], "fleet.size": 1}))
    assert rows(run, "assigned") == [(500, "assigned")]


@pytest.mark.parametrize(("tasks", "message"), [("hold", "tasks there wait until it opens"), ("go", "wait before it")])
def test_check_says_what_is_cut_off_and_for_how_long(tasks, message):
    closure = {"works": {"members": [["C", "D"]], "hours": "works", "tasks": tasks}}
    over = {"traffic.closures": closure, "run.length": 1000}
    [finding] = [
        item for item in check(behind(LOOP, (100, 400), (900, 1200), **over)).findings if "works" in item.place
    ]
    assert finding.code == "CLOSED_GOODS"
    assert "closed 6.667 min of the run and up to 5 min at a time: " in finding.text
    assert "1 storage place, with 100 % of the tasks, and D cannot be reached" in finding.text
    assert message in finding.text


def test_check_counts_what_is_put_away_behind_a_closure_and_how_often_flows_go_there():
    """Of 40 tasks an hour 10 put goods away at the place that is cut off, one of two for a fourth of the visits."""
    flows = {
        "in": {"from": "packing", "to": {"popularity": {"weights": [1, 0]}}, "arrivals": {"poisson": 10}},
        "out": {"from": {"popularity": {"weights": [0, 1]}}, "to": "packing", "arrivals": {"poisson": 30}},
    }
    storage = [{"edge": ["D", "E"], "offset": 5}, {"edge": ["A", "B"], "offset": 5}]
    tasks = {"flows": flows, "load_time": 1, "unload_time": 1}
    over = {"layout.storage": storage, "tasks": tasks, "run.length": 1000}
    model = behind(LOOP, (100, 400), members=[("C", "D")], **over)
    finding = next(item for item in check(model).findings if item.code == "CLOSED_GOODS")
    assert "1 storage place, with 25 % of the visits to storage, and " in finding.text


HALL = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 20], "D": [0, 20]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"node": "B"}],
        "bays": {"p": {"at": ["A"], "places": 2}},
        "stations": {"w": {"at": ["C"], "places": 2}},
    },
    "calendars": {
        "c": {"every": 600, "lasts": 480},
        "rest": {"every": 600, "lasts": 120, "first": 480},
        "late": {"every": 600, "lasts": 480, "first": 120},
    },
    "traffic": {"closures": {"x": {"members": [["B", "C"]], "hours": "c"}}},
    "fleet": {"size": 2, "robot": {"radius": 0.3, "speed": 1}},
    "tasks": {"goods": [0, 0, 0], "unload_at": ["w"], "load_time": 1, "unload_time": 1},
}


@pytest.mark.parametrize(
    ("fleet", "closure", "tasks", "refused"),
    [
        ("c", "c", "hold", True),  # the only way is closed whenever robots work
        ("rest", "c", "hold", False),
        ("late", "c", "hold", False),  # open from 480 to 600, at work from 120 to 600
        ("c", "rest", "hold", False),
        ("c", "c", "go", False),  # they are sent all the same, and wait before it
    ],
)
def test_robots_that_work_only_while_the_way_is_closed_are_refused_before_a_run(fleet, closure, tasks, refused):
    over = {"fleet.hours": fleet, "traffic.closures.x.hours": closure, "traffic.closures.x.tasks": tasks}
    model = dw.load(HALL, over)
    errors = [item.text for item in check(model).errors]
    assert bool(errors) is refused
    if refused:
        assert "these never meet: fleet.hours, 'c'; traffic.closures.x.hours, 'c'" in errors[0]
        with pytest.raises(dw.CheckError, match="HOURS_NEVER_MEET"):
            dw.simulate(model)
    else:
        assert dw.simulate(model).kpis["tasks"] == 3


def test_three_calendars_of_which_each_two_meet_are_refused_too():
    """At work up to 2500, with a way from 2200 on, and a station that is open up to 1000: once round takes 800."""
    calendars = {
        "early": {"every": 6000, "lasts": 2500},
        "shut": {"every": 6000, "lasts": 2200},
        "short": {"every": 6000, "lasts": 1000},
    }
    closures = {"x": {"members": [["B", "C"]], "hours": "shut"}}
    three = {"fleet.hours": "early", "layout.stations.w.hours": "short", "traffic.closures": closures}
    [error] = check(dw.load(HALL, {"calendars": calendars, **three})).errors
    assert "never meet: fleet.hours, 'early'; layout.stations.w.hours, 'short'; traffic.closures.x" in error.text
    for key in three:
        two = {**three, key: {} if key == "traffic.closures" else None}
        assert not check(dw.load(HALL, {"calendars": calendars, **two})).errors, key


def test_a_stall_says_what_closures_and_hours_keep_back():
    """The goods lie in a spur that is closed whenever robots work."""
    layout = {**HALL["layout"], "nodes": {**HALL["layout"]["nodes"], "S": [40, 0]}, "storage": [{"edge": ["B", "S"]}]}
    layout["storage"][0]["offset"] = 10
    layout["edges"] = [*layout["edges"], {"from": "B", "to": "S", "two_way": True}]
    closures = {"x": {"members": [["B", "S"]], "hours": "c"}}
    model = dw.load(HALL, {"layout": layout, "fleet.hours": "c", "traffic.closures": closures})
    with pytest.raises(dw.SimulationError, match=r"hours of robots and open ways \(traffic.closures: x\) do not meet"):
        dw.simulate(model)


def test_a_run_in_which_nothing_is_asked_for_says_so():
    flow = {"f": {"from": "storage", "to": "w", "arrivals": {"schedule": [{"at": 5, "tasks": 1}]}}}
    tasks = {"demand": 0.1, "flows": flow, "load_time": 1, "unload_time": 1}
    with pytest.raises(dw.SimulationError, match=r"0 of 0 tasks .*no task was ever asked for"):
        dw.simulate(dw.load({**HALL, "tasks": tasks, "traffic": {}, "calendars": {}}))
