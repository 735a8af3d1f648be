"""Breakdowns: due by the time in operation, found where a robot looks round; it stands there until it is repaired.

A ring A > B > C > D > A of four edges of 30, speed 1, D = 1. The robot is at its good (10 beyond A) at 10, leaves it at
13, passes B at 33, is on C at 63, free at 68, and in its bay at A at 128.
"""

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.check import check
from desim_warehouse.questions.run.words import sentences
from tests.auditor import audit
from tests.recount import differences

near = pytest.approx


def ring(breakdowns=None, goods=(0,), **changes):
    model = {
        "layout": {
            "nodes": {"A": [0, 0], "B": [30, 0], "C": [30, 30], "D": [0, 30]},
            "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
            "storage": [{"edge": ["A", "B"], "offset": 10}],
            "bays": {"home": {"at": ["A"]}},
        },
        "fleet": {"size": 1, "robot": {"radius": 0.5, "speed": 1}},
        "tasks": {"goods": list(goods), "unload_at": ["C"], "load_time": 3, "unload_time": 5},
    }
    if breakdowns:
        model["fleet"]["robot"]["breakdowns"] = breakdowns
    return dw.load(model, changes)


def states(run, robot=0):
    return [(near(span.start), span.state) for span in run.history.changes[robot]][1:]


def test_without_breakdowns_a_run_has_no_trace_of_them():
    run = dw.simulate(ring())
    assert near(128) == run.T
    assert not {"breakdowns", "availability", "share_broken"} & run.kpis.keys()
    assert not {"broken", "breakdowns"} & set(run.robots.columns)
    assert "broken" not in run.account("robot").columns


def test_a_breakdown_takes_effect_at_the_next_look_and_does_not_put_off_the_next():
    """Due at 20, found at 32, at the stop line before B; due again 20 later on the clock, which is late by 12 then.

    The clock: 20 is due, 32 when it is found and stops; from the repair at 39 on it runs again. 40 is due at 47, found
    at 39 + 30 at the stop line before C, with the clock at 62: so 60 is due as well, and it breaks down again at once.
    The clock is at 62 at 83 then, 80 is due at 101: on C it unloads (84 to 89), and is found before D, at 118, with the
    clock at 97. Repaired at 125; 100 is due at 128, found before A at 155 with 127, and 120 as well, up to 169. In its
    bay at 170, with the clock at 128.
    """
    run = dw.simulate(ring({"every": 20, "repair": 7}))
    assert states(run) == [
        (0, "empty"),
        (10, "loading"),
        (13, "loaded"),
        (32, "broken"),
        (39, "loaded"),
        (69, "broken"),
        (76, "loaded"),
        (76, "broken"),
        (83, "loaded"),
        (84, "unloading"),
        (89, "returning"),
        (118, "broken"),
        (125, "returning"),
        (155, "broken"),
        (162, "returning"),
        (162, "broken"),
        (169, "returning"),
        (170, "idle"),
    ]
    assert near(128 + 6 * 7) == run.T
    assert run.kpis["breakdowns"] == 6
    assert run.kpis["share_broken"] == near(42 / 170)
    assert run.kpis["availability"] == near(128 / 170)
    assert run.account("robot")["broken"].sum() == near(42)
    assert run.deterministic


def test_the_time_in_a_bay_does_not_count():
    """In operation from 0 to 128 and from 1000 on: 150 is reached at 1022, found at the stop line before B at 1032."""
    run = dw.simulate(ring({"every": 150, "repair": 7}, goods=[0, {"good": 0, "release": 1000}]))
    assert [span for span in states(run) if span[1] == "broken"] == [(1032, "broken")]


def test_a_robot_that_is_due_in_its_bay_breaks_down_on_the_node_as_it_comes_out():
    run = dw.simulate(ring({"every": 105, "repair": 7}, **{"fleet.first_exit_time": 110}))
    assert states(run)[:4] == [(0, "empty"), (110, "broken"), (117, "empty"), (127, "loading")]
    assert run.account("node")["broken"].to_dict() == {"A": near(7), "B": 0, "C": 0, "D": 0}


def test_in_a_station_it_breaks_down_when_it_sets_off():
    """Due at 65, while it unloads from 63 to 68: it is in nobody's way on C until 75."""
    stations = {"layout.stations": {"pack": {"at": ["C"]}}}
    run = dw.simulate(ring({"every": 65, "repair": 7}, **stations))
    assert states(run)[3:6] == [(63, "unloading"), (68, "returning"), (68, "broken")]
    assert near(75) == next(row[0] for row in run.record.rows if row[1] == "enter" and row[5] == ("C", "D"))


def test_in_the_lane_it_breaks_down_where_it_loaded():
    run = dw.simulate(ring({"every": 12, "repair": 7}))
    assert states(run)[2:5] == [(13, "loaded"), (13, "broken"), (20, "loaded")]


def test_on_short_lanes_it_breaks_down_on_the_next_node():
    """Ten edges of 1.5 round a ring: the robot holds the node on which it stands; due at 2.2, it is there at 3."""
    nodes = {f"n{i}": [0, i] for i in range(10)}
    edges = [{"from": f"n{i}", "to": f"n{(i + 1) % 10}", "length": 1.5} for i in range(10)]
    layout = {"nodes": nodes, "edges": edges, "storage": [{"node": "n5"}], "bays": {"home": {"at": ["n0"]}}}
    run = dw.simulate(ring({"every": 2.2, "repair": 7}, **{"layout": layout, "tasks.unload_at": ["n8"]}))
    broken = [time for time, state in states(run) if state == "broken"]
    assert broken[:2] == [3, 3 + 7 + 1.5]
    assert run.account("edge")["broken"]["n1>n2"] == near(7)


def test_robots_behind_it_wait_for_the_repair():
    """Robot 0 stands before B, at 29, from 32 to 82. The other has loaded at 17, comes up to 28 at 35, and waits.

    Robot 0 is through B at 83; the other moves up from 82 on and is D behind.
    """
    kinds = {"old": {"count": 1, "breakdowns": {"every": 20, "repair": 50}}}
    run = dw.simulate(ring(goods=[0, 0], **{"fleet.size": 2, "fleet.kinds": kinds, "run.length": 90}))
    assert states(run)[3:5] == [(32, "broken"), (82, "loaded")]
    behind = run.waits[run.waits.start > 20].iloc[0]
    assert tuple(behind[["start", "end", "robot", "other", "edge"]]) == (35, 82, 1, 0, "A>B")
    assert run.robots.broken.to_list() == [near(50), 0]
    assert run.robots.breakdowns.to_list() == [1, 0]


def test_nobody_pushes_a_robot_that_breaks_down_as_room_opens_before_it():
    """Robot 1 is due at the very instant at which robot 0 drives on before it: it stands where it stands.

    Robot 0 comes to its good at 10 and goes on at once; robot 1, which left 1 later, is 1 behind it, at 9, after 9.
    """
    kinds = {"new": {"count": 1}, "old": {"count": 1, "breakdowns": {"every": 9, "repair": 50}}}
    model = ring(goods=[0, 0], **{"fleet.size": 2, "fleet.kinds": kinds, "tasks.load_time": 0})
    run = dw.simulate(model)
    assert states(run, 1)[1] == (10, "broken")
    drives = [(row[0], row[6]) for row in run.record.rows if row[1] == "drive" and row[2] == 1]
    assert not [drive for drive in drives if 10 < drive[0] < 60]


def test_a_recall_that_comes_while_it_is_broken_is_heeded_after_the_repair():
    """At the threshold at 100, in the middle of a repair from 29 to 129: the good is given back then, at B."""
    changes = {
        "layout.storage": [{"edge": ["C", "D"], "offset": 10}],
        "tasks.unload_at": ["A"],
        "battery": {"capacity": 400, "threshold": 300, "consumption": 1, "charge_rate": 10},
        "run.length": 140,
    }
    run = dw.simulate(ring({"every": 20, "repair": 100}, **changes))
    returned = next(row for row in run.record.rows if row[1] == "returned")
    assert (near(129), 0, "B") == (returned[0], returned[2], returned[4])
    assert states(run)[1:] == [(29, "broken"), (129, "empty"), (130, "returning")]


def test_a_battery_may_be_flat_before_the_repair_is_over():
    battery = {"capacity": 300, "threshold": 100, "consumption": 1, "charge_rate": 10}
    with pytest.raises(dw.BatteryError, match=r"flat at time 300, on edge A>B at 29, broken"):
        dw.simulate(ring({"every": 20, "repair": 500}, battery=battery))


def test_a_broken_robot_draws_what_a_standing_one_does():
    spent = {"standing": 0.5, "empty": 1, "loaded": 2, "handling": 3}
    battery = {"capacity": 4000, "threshold": 100, "consumption": spent, "charge_rate": 10}
    without = dw.simulate(ring(battery=battery))
    run = dw.simulate(ring({"every": 20, "repair": 7}, battery=battery))
    assert run.kpis["energy"] == near(without.kpis["energy"] + 6 * 7 * 0.5)


# Delays


def test_a_delay_at_every_node_is_a_node_time():
    delayed = dw.simulate(ring(**{"fleet.robot.delays": {"share": 1, "time": 4}}))
    assert delayed.record.rows == dw.simulate(ring(**{"traffic.node_time": 4})).record.rows
    assert near(128 + 4 * 4) == delayed.T
    assert delayed.deterministic


def test_a_robot_is_delayed_at_a_share_of_the_nodes():
    """Round and round: of some 4000 nodes a quarter cost 2 each, on average; nobody is delayed twice at one."""
    lifelong = {"tasks.goods": {"saturated": 1}, "run.length": 125_000}
    delays = {"share": 0.25, "time": {"exponential": 2}}
    run = dw.simulate(ring(**lifelong, **{"fleet.robot.delays": delays}), 5)
    passed = run.kpis["moves"]
    lost = run.T - run.kpis["distance"] - run.kpis["tasks"] * 8
    assert lost / passed == pytest.approx(0.5, rel=0.1)


def test_delays_and_turns_add_up():
    both = {"traffic.turn_time": 3, "fleet.robot.delays": {"share": 1, "time": 4}}
    turning = dw.simulate(ring(**{"traffic.turn_time": 3}))
    assert near(turning.T + 4 * 4) == dw.simulate(ring(**both)).T


# Chance


def busy(**changes):
    """Tasks that arrive and times of handling are drawn; two robots on the ring, with batteries."""
    given = {
        "fleet.size": 2,
        "tasks.goods": {"poisson": 60},
        "tasks.load_time": {"lognormal": {"mean": 3, "cv": 0.5}},
        "tasks.unload_time": {"exponential": 5},
        "battery": {"capacity": 4000, "threshold": 1000, "consumption": 1, "charge_rate": 5},
        "run.length": 20_000,
    }
    return dw.simulate(ring(**{**given, **changes}), 3)


def test_a_robot_breaks_down_at_the_same_times_in_a_larger_fleet():
    breakdowns = {"every": {"exponential": 900}, "repair": {"exponential": 100}}

    def repairs(size):
        run = busy(**{"fleet.size": size, "fleet.robot.breakdowns": breakdowns, "tasks.goods": {"saturated": 3}})
        return [near(span.end - span.start) for span in run.history.changes[0] if span.state == "broken"]

    few, many = repairs(1), repairs(2)
    shorter = min(len(few), len(many))
    assert shorter > 5
    assert few[:shorter] == many[:shorter]


# What is said of it


def test_check_says_what_estimates_leave_out():
    """Neither robots without batteries draw energy, nor chargers that nobody needs fail."""
    kinds = {"old": {"count": 1, "breakdowns": {"every": 3600, "repair": 400}}}
    bays = {"home": {"at": ["A"], "outages": {"every": 3600, "repair": 60}}}
    report = check(ring(**{"fleet.size": 2, "fleet.kinds": kinds, "layout.bays": bays}))
    sentence = "robots of kind old fail every 1 h and take 6.667 min to repair: 90 % of their time is left"
    assert [fact for fact in report.facts if "repair" in fact] == [sentence]
    assert "robots that were broken begin anew what they did; estimates leave this out" in report.facts


def test_a_robot_that_hardly_ever_breaks_down_has_no_10_of_10_hours_left():
    """A minute in 10,000 is 0.01 % of the time."""
    breaks = {"every": "9999 min", "repair": "1 min", "clear": "1 min"}
    (line,) = [line for line in check(ring(breaks, **{"run.length": "10 h"})).sentences if "for work" in line]
    assert line == "Breakdowns leave a robot over 99.9 % of its time for work."


def test_the_report_says_how_often_robots_broke_down():
    answer = sentences(dw.simulate(ring({"every": 20, "repair": 7})))
    assert "Robots broke down 6 times; their availability was 75.3 %." in answer
    assert "broke down" not in " ".join(sentences(dw.simulate(ring())))


def test_a_breakdown_at_every_moment_is_an_error():
    with pytest.raises(dw.ModelError, match=r"fleet.robot.breakdowns.every.*no time at all \(got 0\)"):
        ring({"every": {"constant": 0}, "repair": 7})


def test_a_robot_that_waits_for_a_repair_holds_back_no_departures_on_two_way_lanes():
    """A star of two-way lanes: robot 0 stands before X for 9,000, robot 1 wants into its lane and waits for as long.

    Robot 2, whose way does not lead there, sets out at 5,000 as if nothing were wrong.
    """
    spurs = {"P": [0, 20], "Q": [20, 0], "R": [-20, 0], "S": [0, -20]}
    layout = {
        "nodes": {"X": [0, 0], **spurs},
        "edges": [{"from": spur, "to": "X", "two_way": True} for spur in spurs],
        "storage": [{"node": "R"}, {"node": "P"}, {"node": "R"}],
        "bays": {"home": {"at": ["P", "S", "Q"]}},
    }
    fleet = {
        "size": 3,
        "start": ["P", "S", "Q"],
        "robot": {"radius": 0.5, "speed": 1},
        "kinds": {"old": {"count": 1, "breakdowns": {"every": 15, "repair": 9000}}},
    }
    goods = [{"good": 0, "to": "Q"}, {"good": 1, "to": "Q"}, {"good": 2, "release": 5000, "to": "Q"}]
    model = ring(**{"layout": layout, "fleet": fleet, "tasks.goods": goods, "tasks.unload_at": ["Q"]})
    run = dw.simulate(model)
    taken = {row[3]: (row[2], row[0]) for row in run.record.rows if row[1] == "loading"}
    assert states(run)[1] == (19, "broken")
    assert taken[2] == (2, near(5040))


def test_a_task_that_repairs_make_it_give_back_is_tried_with_more_energy_each_time():
    """Every repair draws 30 that nobody planned for, so what looks enough for the way to the good never is."""
    battery = {"capacity": 500, "threshold": 0, "consumption": 1, "charge_rate": 5, "reserve": 1000}
    changes = {
        "layout.storage": [{"edge": ["C", "D"], "offset": 10}],
        "tasks.unload_at": ["D"],
        "battery": battery,
        "fleet.start_energy": 0.36,
        "policies.charging": {"name": "opportunity", "minimum": 0.2, "margin": 0},
    }
    run = dw.simulate(ring({"every": 20, "repair": 30}, **changes))
    began = [row.value for row in run.history.rows("assigned")]
    assert run.kpis["tasks"] == 1
    # 160: 60 to the good, and 100 below which nobody works; then 5 % of the capacity more each time.
    assert began == pytest.approx([180, 160, 185, 210, 235], abs=0.01)


# Cleared off the lanes


def two_on_the_ring(clear, **more):
    """Robot 0 breaks down before B, at 29, from 32 to 82 (see above), and is off the lanes after a time."""
    kinds = {"old": {"count": 1, "breakdowns": {"every": 20, "repair": 50, "clear": clear}}}
    return ring(goods=[0, 0], **{"fleet.size": 2, "fleet.kinds": kinds, "run.length": 90, **more})


def test_a_robot_that_is_cleared_is_in_nobodys_way_and_comes_back_at_the_node_ahead():
    """The other comes up at 35, goes on at 37, and is on B>C from 39 on; robot 0 is back on B at 82, and goes on."""
    run = dw.simulate(two_on_the_ring(5))
    assert states(run)[3:5] == [(32, "broken"), (82, "loaded")]
    assert [row[:5] for row in run.record.rows if row[1] == "cleared"] == [(37, "cleared", 0, 0, "B")]
    entered = {row[2]: row[0] for row in run.record.rows if row[1] == "enter" and row[5] == ("B", "C")}
    assert entered == {1: near(39), 0: near(82)}
    behind = run.waits[run.waits.start > 20].iloc[0]
    assert tuple(behind[["start", "end", "robot", "other"]]) == (35, 37, 1, 0)
    assert run.robots.broken.to_list() == [near(50), 0]
    assert run.robots.distance[0] == near(29 + 8)  # of A>B, and of B>C, 1 short of its end
    assert audit(run) == differences(run) == []


def test_a_repair_that_is_over_sooner_is_made_where_it_stands():
    assert dw.simulate(two_on_the_ring(50)).record.rows == dw.simulate(two_on_the_ring(60)).record.rows
    assert not [row for row in dw.simulate(two_on_the_ring(60)).record.rows if row[1] == "cleared"]


def test_it_waits_until_there_is_room_where_it_comes_back():
    """B>C is 1.5 long, too short to stand on, and the other unloads on C for 100: robot 0 comes back after that."""
    over = {"tasks.unload_time": 100, "layout.nodes.C": [30, 1.5], "run.length": 400}
    run = dw.simulate(two_on_the_ring(5, **over))
    entered = {row[2]: row[0] for row in run.record.rows if row[1] == "enter" and row[5] == ("B", "C")}
    assert entered[1] < 82
    assert entered[0] > 140
    assert audit(run) == differences(run) == []


def test_a_robot_that_has_still_to_stop_on_its_lane_drives_it_again():
    """Robot 1 breaks down behind robot 0 at 10, 1 before its good, is off A>B at 15, and back on A at 60."""
    kinds = {"new": {"count": 1}, "old": {"count": 1, "breakdowns": {"every": 8, "repair": 50, "clear": 5}}}
    run = dw.simulate(ring(goods=[0, 0], **{"fleet.size": 2, "fleet.kinds": kinds, "tasks.load_time": 33}))
    broken = next(span for span in states(run, 1) if span[1] == "broken")
    [cleared, *_] = [row for row in run.record.rows if row[1] == "cleared"]
    assert (cleared[0], cleared[4]) == (broken[0].expected + 5, "A")
    assert [row[0] for row in run.record.rows if row[1] == "enter" and row[2] == 1 and row[5] == ("A", "B")][:2] == [
        near(1),
        near(broken[0].expected + 50),
    ]
    assert audit(run) == differences(run) == []


FORK = {
    "nodes": {"A": [0, 0], "B": [10, 0], "C": [30, 0], "D": [40, 0], "u": [10, 10], "v": [30, 10], "E": [20, -20]},
    "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["B", "u"], ["u", "v"], ["v", "C"], ["D", "E"], ["E", "A"]],
    "storage": [{"edge": ["C", "D"], "offset": 5.0}],
    "bays": {"home": {"at": ["A"]}},
}


@pytest.mark.parametrize(
    ("repair", "routing", "round_it"),
    [
        (90, "congestion-aware", True),  # half of it is expected to be left, and the way round is 20 longer
        (30, "congestion-aware", False),
        (90, "shortest", False),
    ],
)
def test_new_routes_go_round_a_broken_robot(repair, routing, round_it):
    """Robot 0 breaks down before C, at 29; robot 1 sets out at 40."""
    kinds = {"old": {"count": 1, "breakdowns": {"every": 20, "repair": repair}}}
    over = {
        "layout": FORK,
        "fleet.size": 2,
        "fleet.kinds": kinds,
        "tasks.unload_at": ["A"],
        "policies.routing": routing,
    }
    run = dw.simulate(ring(goods=[0, {"good": 0, "release": 40}], **over))
    assert (29, "broken") in states(run)
    assert bool([row for row in run.record.rows if row[2] == 1 and row[5] == ("u", "v")]) == round_it
    assert audit(run) == differences(run) == []


@pytest.mark.parametrize(
    ("repair", "routing", "given"),
    [
        (90, "congestion-aware", {1: 128, 2: 41}),  # 45 are expected to be left, and D is 40 away
        (70, "congestion-aware", {1: 40}),  # robot 0 does the other one
        (90, "shortest", {1: 40}),
    ],
)
def test_tasks_to_which_all_ways_lead_past_a_broken_robot_wait_for_its_repair(repair, routing, given):
    """Robot 0 breaks down on C > D at 38, when it has loaded; good 1 lies behind it, good 2 on another way home."""
    layout = {**FORK, "edges": [*FORK["edges"], ["u", "A"]]}
    layout["storage"] = [*FORK["storage"], {"edge": ["D", "E"], "offset": 5.0}, {"edge": ["B", "u"], "offset": 5.0}]
    over = {
        "layout": layout,
        "fleet.size": 2,
        "fleet.kinds": {"old": {"count": 1, "breakdowns": {"every": 36, "repair": repair}}},
        "tasks.unload_at": ["A"],
        "policies.routing": routing,
    }
    goods = [0, {"good": 1, "release": 40}, {"good": 2, "release": 41}]
    run = dw.simulate(ring(goods=goods, **over))
    assert (38, "broken") in states(run)
    assigned = {row[3]: row[0] for row in run.record.rows if row[1] == "assigned" and row[2] == 1}
    assert assigned == given
    assert audit(run) == differences(run) == []


def test_check_warns_of_lanes_that_are_blocked_for_long():
    def said(**breakdowns):
        findings = check(ring({"every": 1e5, **breakdowns})).findings
        return [(item.place, item.text) for item in findings if item.code == "LANES_BLOCKED"]

    text = "a robot that breaks down blocks its lane for 600 s on average, until it is repaired"
    assert said(repair=600) == [("fleet.robot.breakdowns.repair", text)]
    assert said(repair=600, clear=120) == said(repair=300) == []


def test_room_on_a_two_way_lane_that_a_cleared_robot_gives_back_goes_to_one_that_waits_at_the_other_end():
    """Robot 0 breaks down on X at 110, out of its bay, with room on the lane of 20 to Y, and is off X at 115.

    Robot 1 comes out at Y at 110, too, and finds no room. It sets out at 115, and not when robot 0 is repaired, at 160.
    """
    layout = {
        "nodes": {"X": [0, 0], "Y": [20, 0], "V": [-20, 0]},
        "edges": [{"from": "X", "to": "Y", "two_way": True}, {"from": "X", "to": "V", "two_way": True}],
        "storage": [{"node": "Y"}, {"node": "V"}],
        "bays": {"home": {"at": ["X", "Y"]}},
    }
    old = {"count": 1, "breakdowns": {"every": 105, "repair": 50, "clear": 5}}
    over = {
        "layout": layout,
        "fleet.size": 2,
        "fleet.start": ["X", "Y"],
        "fleet.kinds": {"old": old},
        "fleet.first_exit_time": 110,
        "tasks.unload_at": ["X"],
    }
    run = dw.simulate(ring(goods=[0, 1], **over))
    assert states(run)[1] == (110, "broken")
    assert [row[0] for row in run.record.rows if row[1] == "cleared"] == [115]
    entered = [row[0] for row in run.record.rows if row[1] == "enter" and row[2] == 1 and row[5] == ("Y", "X")]
    assert entered[0] == near(115)
    assert audit(run) == differences(run) == []
