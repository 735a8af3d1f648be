"""What `why` says where nothing is wrong, where a run fails, and where ups and downs of the day are the cause."""

import json
import math

import pytest

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.model.steady import evenly, without_breaks
from desim_warehouse.questions.why import why
from desim_warehouse.study.held_up import Health
from desim_warehouse.study.suspects import left_out, suspects
from tests.docs import pages


def drafted(over, **needs):
    wanted = {"size": (24, 20), "stations": 1, **needs}
    model = dw.Model.model_validate(read_yaml(draft(Draft(wanted.pop("size"), **wanted)), "draft").data)
    return model.replace({"run.length": "2 h", "run.warm_up": "20 min", "fleet.start_energy": 1, **over})


def answer(model, indicator=None):
    diagnosis = why(model, indicator=indicator)
    return diagnosis, diagnosis.answer.answer[0]


# Healthy


@pytest.mark.parametrize("orders", [20, pytest.param(60, marks=pytest.mark.long)])
def test_a_warehouse_with_idle_robots_and_all_on_time_is_held_up_by_nothing(orders):
    """Handling a tenth shorter gains a tenth of 30 s by arithmetic: that is no bottleneck."""
    diagnosis, sentence = answer(
        drafted(
            {"fleet.start_energy": "settled", "battery.capacity": 15, "run.length": "80 min"},
            orders=orders,
            robots=8,
            chargers=6,
        )
    )
    assert sentence.startswith("There is no bottleneck: robots idle ")
    assert " 100 % on time." in sentence
    assert "andling" not in sentence
    assert not diagnosis.is_held_up
    handling = next(gain for suspect, gain in diagnosis.ranked if suspect.name == "handling")
    assert not handling.competes
    assert 0 < handling.low < 3 < handling.high
    assert {gain.n for gain in diagnosis.gains.gains} == {5}  # no more runs than that takes


@pytest.mark.parametrize(
    ("state", "held_up"),
    [
        (Health(0.8, 0.01, 1.0, 0.0), False),
        (Health(0.8, 0.01, (19 + 0.89) / 20, 0.0), False),  # a bad day of twenty
        (Health(0.8, 0.01, 0.97, 0.0), True),
        (Health(0.8, 0.03, 1.0, 0.0), True),
        (Health(0.2, 0.0, 1.0, 0.0), True),
        (Health(0.8, 0.0, None, 0.05), False),
        (Health(0.8, 0.0, None, 0.2), True),
        (Health(0.8, 0.0, 0.0, 0.0), True),
    ],
)
def test_held_up_is_who_is_late_waits_or_has_no_robot_to_spare(state, held_up):
    assert state.is_held_up == held_up


@pytest.mark.long
def test_fewer_robots_and_the_same_warehouse_is_held_up():
    diagnosis, sentence = answer(
        drafted({"tasks.goods": {"poisson": 100, "due_within": 120}}, orders=100, robots=3, chargers=3)
    )
    assert diagnosis.is_held_up
    assert sentence.startswith("The number of robots is the main bottleneck. One robot more (+33.3 %): ")
    assert " per 10 %" in sentence


# Work that piles up


@pytest.mark.long
def test_a_worker_too_few_is_named():
    """A load takes 45 s and comes every 22.5 s: half of them are left."""
    model = dw.load(
        {
            "layout": {
                "blocks": {"columns": 4, "rows": 2, "block_depth": 6, "goods_size": 1.2, "aisle_width": 1.8},
                "bays": {"parking": {"along": "north"}},
                "stations": {"packing": {"at": ["L"], "servers": 2, "unload_time": 5, "work_time": 45}},
            },
            "fleet": {"size": 6, "robot": {"radius": 0.35, "speed": 1.2}},
            "tasks": {
                "load_time": 8,
                "unload_time": 5,
                "flows": {"o": {"from": "storage", "to": "packing", "arrivals": {"poisson": 160}, "due_within": 600}},
            },
            "run": {"length": 7200},
        }
    )
    diagnosis, sentence = answer(model)
    assert sentence.startswith("Packers are the main bottleneck. One worker more at each node of packing (+100 %): ")
    # what was equal in ten runs has no bound, and none is said
    assert " per 10 %" in sentence
    assert all(suspect.beside or (gain.same and math.isnan(gain.high)) for suspect, gain in diagnosis.ranked[1:])


# Ups and downs


FLOOR = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [30, 0], "C": [30, 10], "E": [0, 10]},
        "edges": [["A", "B"], ["B", "C"], ["C", "E"], ["E", "A"]],
        "storage": [{"edge": ["B", "C"], "offset": 5}],
        "bays": {"home": {"at": ["A"]}},
        "stations": {"desk": {"at": ["E"], "servers": 2}},
    },
    "fleet": {"size": 2, "robot": {"radius": 0.3, "speed": 1}},
    "tasks": {
        "load_time": 5,
        "unload_time": 5,
        "flows": {"orders": {"from": "storage", "to": "desk", "arrivals": {"poisson": 40}, "due_within": "10 min"}},
    },
    "run": {"length": "4 h", "warm_up": "1 h"},
}
ARRIVALS = "tasks.flows.orders.arrivals"


def test_peaks_are_a_suspect_and_named():
    """A ring of 80 m and two robots do some 70 tasks an hour: 180 in ten minutes of each forty wait for an hour."""
    profile = {"profile": {"per_hour": [120, 20, 20, 20], "every": "15 min"}}
    model = dw.load(FLOOR, {ARRIVALS: profile, "run.length": "2 h"})
    diagnosis, sentence = answer(model, indicator="cycle_time_p95")
    assert sentence.startswith("Peaks are the main bottleneck. ")
    assert diagnosis.ranked[0][0].overrides == {f"{ARRIVALS}": {"poisson": 45.0}}


@pytest.mark.parametrize(
    ("arrivals", "even"),
    [
        ({"poisson": 40}, None),
        ({"profile": {"per_hour": [30]}}, None),
        # of hours 1 to 4 of the run, which are counted
        ({"profile": {"per_hour": [900, 30, 60, 90]}}, {"poisson": 60}),
        # 2 of the 3 hours: the flow has orders in 2 of them, 30 and 60
        ({"profile": {"per_hour": [900, 30, 60, 90]}, "hours": [[0, 10800]]}, {"poisson": 45}),
        (
            {"schedule": [{"at": 3600, "tasks": 3}, {"at": 18000, "tasks": 9}]},
            {"schedule": [{"at": 0, "tasks": 1}, {"at": 4800, "tasks": 1}, {"at": 9600, "tasks": 1}]},
        ),
        ({"saturated": 3}, None),
    ],
)
def test_arrivals_are_spread_evenly_at_their_rate(arrivals, even):
    over = {}
    arrivals = dict(arrivals)
    if "hours" in arrivals:
        over = {"calendars": {"day": {"between": arrivals.pop("hours")}}, "tasks.flows.orders.hours": "day"}
    changes = evenly(dw.load(FLOOR, {**over, ARRIVALS: arrivals}))
    assert changes == ({} if even is None else {ARRIVALS: even})


@pytest.mark.parametrize(
    ("calendar", "whole", "more"),
    [
        # 8:00 to 12:00 is the run
        ({"open": ["08:00-12:00"]}, None, None),
        ({"open": ["08:00-12:00"], "breaks": ["09:30-10:00"]}, {"open": ["08:00-12:00"]}, 4 / 3.5 - 1),
        ({"open": ["08:00-09:30", "10:00-20:00"]}, {"open": ["08:00-20:00"]}, 4 / 3.5 - 1),
        ({"open": ["08:00-10:00", "11:30-12:00"]}, None, None),  # longer than half of what is before it: no break
        ({"between": [[0, 3600], [4500, 14400]]}, {"between": [[0, 14400]]}, 4 / 3.75 - 1),
        ({"every": 3600, "lasts": 3000}, {"every": 3600, "lasts": 3600, "first": 0}, 1 / 5),
        ({"every": 14400, "lasts": 3600}, None, None),
    ],
)
def test_breaks_are_taken_out_of_calendars_of_robots_and_stations(calendar, whole, more):
    over = {"calendars": {"day": calendar}, "fleet.hours": "day", "layout.stations.desk.hours": "day"}
    model = dw.load(FLOOR, {**over, "run.start": "08:00"})
    breaks = list(without_breaks(model))
    if whole is None:
        assert breaks == []
        return
    ((name, dose, changes),) = breaks
    assert (name, dose) == ("day", pytest.approx(more))
    new = "day without breaks"
    assert changes == {f"calendars.{new}": whole, "fleet.hours": new, "layout.stations.desk.hours": new}


def test_a_break_longer_than_orders_may_take_is_named():
    """Whatever comes in the first twenty minutes of half an hour is late; no robot more helps."""
    day = {"calendars": {"day": {"open": ["08:00-09:30", "10:00-11:00"]}}, "fleet.hours": "day"}
    model = dw.load(FLOOR, {**day, "run.start": "08:00", "run.length": "3 h"})
    diagnosis, sentence = answer(model, indicator="on_time")
    assert sentence.startswith(
        "Breaks in day are the main bottleneck. No breaks in day (+20 %): done on time rises by "
    )
    # always at work is the same here
    assert "shifts of robots" not in {suspect.name for suspect, _ in diagnosis.ranked}


# Two-way lanes


def bridge(robots):
    nodes = {"A": [0, 0], "B": [20, 0], "A1": [-20, -10], "A2": [-20, 10], "B1": [40, -10], "B2": [40, 10]}
    ways = [["A", "A1"], ["A1", "A2"], ["A2", "A"], ["B", "B1"], ["B1", "B2"], ["B2", "B"]]
    return dw.load(
        {
            "layout": {
                "nodes": nodes,
                "edges": [*ways, {"from": "A", "to": "B", "two_way": True, "length": 21}],
                "storage": [{"edge": ["B1", "B2"], "offset": 10}],
                "bays": {"bay": {"at": ["A1"], "places": robots}},
                "stations": {"desk": {"at": ["A2"], "servers": 4}},
            },
            "fleet": {"size": robots, "robot": {"radius": 0.5, "speed": 1}},
            "tasks": {"goods": {"saturated": 60}, "unload_at": ["desk"], "load_time": 0, "unload_time": 0},
            "run": {"length": 6000, "warm_up": 2000},
            "log": "all",
        }
    )


def test_a_two_way_lane_that_all_must_cross_is_named_with_what_it_costs():
    """D is 12 m: on one-way lanes of 20 m nobody can make way, so one robot at a time is beyond the bridge."""
    model = bridge(4).replace({"fleet.robot.radius": 6})
    diagnosis, sentence = answer(model)
    assert sentence.startswith("Two-way lane A - B is the main bottleneck of all that could be tried; one robot more ")
    suspect, gain = diagnosis.ranked[0]
    assert suspect.overrides == {
        "layout.edges.6": {"from": "A", "to": "B", "length": 21, "two_way": True, "side_by_side": True}
    }
    both = dw.simulate(model.replace(suspect.overrides)).kpis["throughput_per_hour"]
    assert both - dw.simulate(model).kpis["throughput_per_hour"] == pytest.approx(gain.mean)


def test_all_two_way_lanes_are_relieved_together_where_robots_use_two_of_them():
    """The bridge in two halves; of a third lane, which nobody drives, there is nothing to gain."""
    content = bridge(1).content()
    content["layout"]["nodes"] |= {"M": [10, 0], "N": [10, 20]}
    halves = [{"from": a, "to": b, "two_way": True} for a, b in ("AM", "MB", "MN")]
    content["layout"]["edges"] = [*content["layout"]["edges"][:6], *halves]
    relief = {one.name: one.relief for one in suspects(dw.simulate(dw.load(content))) if "two-way lane" in one.name}
    assert relief == {
        "two-way lane A - M": "two lanes for A - M",
        "two-way lane M - B": "two lanes for M - B",
        "two-way lanes": "two lanes for each of 3 two-way lanes",
    }


def test_a_relief_for_which_there_is_no_room_is_said():
    run = dw.simulate(bridge(4))
    assert "the number of robots" not in {suspect.name for suspect in suspects(run)}
    (reason,) = left_out(run)
    assert reason.startswith("one robot more: ")
    assert "slots" in reason


# Runs that fail


FLAT = {
    "layout.bays.charging.total_chargers": 1,
    "layout.bays.charging.places": 3,  # slots to wait in for the charger
    "battery.charge_rate": 0.02,
    "fleet.start_energy": {"uniform": [0.01, 0.3]},  # a robot of 1 % is flat within a quarter of an hour
}


@pytest.mark.long
def test_a_relief_that_runs_flat_is_a_row_and_the_rest_goes_on(tmp_path, monkeypatch):
    model = drafted(FLAT, orders=100, robots=6, chargers=6)
    (tmp_path / "w.yaml").write_text(json.dumps(model.content()), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    status, out, err = pages.run_desim("desim why w.yaml --quiet --cap 10")
    assert status == 0, err
    (row,) = [line for line in out.splitlines() if line.strip().startswith("one robot more")]
    assert " ".join(row.split()).endswith("runs flat in 1 of 10 runs runs fail 10")
    assert "a second packer at each station" in out
    content = json.loads(pages.run_desim("desim why w.yaml --quiet --cap 10 --json")[1])
    robots = next(relief for relief in content["reliefs"] if relief["relief"] == "one robot more")
    assert (robots["failed"], robots["low"], robots["competes"]) == (1, None, False)


@pytest.mark.long
def test_where_the_warehouse_itself_runs_flat_that_is_the_answer_with_its_cure():
    diagnosis, sentence = answer(drafted({**FLAT, "fleet.size": 9}, orders=100, robots=6, chargers=6))
    assert sentence.startswith("As it is, the warehouse runs flat in ")
    assert "a higher fleet.start_energy, more chargers" in sentence
    assert diagnosis.failures[0].failed > 0
    model = drafted({**FLAT, "battery.charge_rate": 0.007, "fleet.size": 9}, orders=100, robots=6, chargers=6)
    sentence = answer(model)[1]
    # in the run that is looked at already
    assert sentence.startswith("As it is, the warehouse runs flat in 1 of 1 run")
