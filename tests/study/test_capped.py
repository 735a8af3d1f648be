"""Past the knee: plan, why and size try a cap on the robots under way, and say what it gives."""

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.answer import words
from desim_warehouse.cli import desim
from desim_warehouse.questions.sentences import capped
from desim_warehouse.study.fleet.capped import Capped, caps, tried_cap, waits_much
from desim_warehouse.study.statistics.effects import Gain
from desim_warehouse.study.suspects import suspects
from tests.world.crowded import crowded

SHORT = {"length": 400, "warm_up": 100}


def test_caps_are_parts_of_the_fleet_unless_the_model_has_one():
    assert caps(dw.load(crowded(60))) == [45, 30, 20]
    assert caps(dw.load(crowded(2))) == [1]
    assert caps(dw.load(crowded(1))) == []
    assert caps(dw.load(crowded(60), {"traffic.most_out": 50})) == []


def test_a_cap_is_tried_where_robots_wait_a_fifth_of_their_time():
    assert [waits_much([{"share_waiting": share}, {}]) for share in (0.39, 0.4)] == [False, True]
    assert not waits_much([])


@pytest.mark.long
def test_half_of_sixty_robots_do_more_than_all():
    limit, runs = tried_cap(
        dw.load(crowded(60, run=SHORT)), "throughput_per_hour", dw.Search(first=3, cap=6, cache=False)
    )
    assert limit is not None
    assert (limit.robots, limit.cap, limit.overrides) == (60, 30, {"traffic.most_out": 30})
    without = [dw.simulate(dw.load(crowded(60, run=SHORT)), seed).kpis["throughput_per_hour"] for seed in range(2)]
    assert limit.gain.low > 0
    assert limit.mean - limit.gain.mean == pytest.approx(sum(without) / 2, rel=0.1)
    assert limit.mean > 3500
    assert runs >= 12


def test_no_cap_gains_where_the_floor_is_not_full():
    limit, runs = tried_cap(
        dw.load(crowded(10, run=SHORT)), "throughput_per_hour", dw.Search(first=2, cap=2, cache=False)
    )
    assert (limit, runs) == (None, 8)


def test_what_a_cap_gives_in_words():
    gain = Gain(1, 500.0, 450.0, 550.0, 6)
    limit = Capped(60, 30, "throughput_per_hour", 3900.0, gain)
    assert capped(limit, words.scale("throughput_per_hour", None)) == (
        "With at most 30 of 60 robots under way, throughput is 3,900 tasks/h: better by 500 tasks/h "
        "(450 to 550); desim size --key traffic.most_out finds the best cap"
    )
    share = Capped(60, 30, "on_time", 0.9, replace(gain, mean=0.1, low=0.1, high=0.1))
    assert capped(share, words.scale("on_time", None)).startswith(
        "With at most 30 of 60 robots under way, done on time is 90.0 %: better by 10.0 %; "
    )


def test_why_suspects_the_number_under_way_only_where_robots_wait_much():
    def names(robots):
        return [one.relief for one in suspects(dw.simulate(dw.load(crowded(robots, run=SHORT, log="all"))))]

    assert [name for name in names(60) if "under way" in name] == [
        f"at most {cap} robots under way" for cap in (45, 30, 20)
    ]
    assert not [name for name in names(8) if "under way" in name]


def test_one_robot_under_way_is_no_plural():
    """Three robots on a lane for both directions wait for the one that takes a minute at its end."""
    corridor = {
        "layout": {
            "nodes": {"home": [-20, 0], "A": [0, 0], "B": [20, 0]},
            "edges": [{"from": a, "to": b, "two_way": True} for a, b in (["home", "A"], ["A", "B"])],
            "bays": {"parking": {"at": ["home"], "places": 4}},
            "stations": {"from": {"at": ["A"]}, "to": {"at": ["B"]}},
        },
        "fleet": {"size": 3, "robot": {"radius": 0.5, "speed": 1}},
        "tasks": {
            "flows": {"loads": {"from": "from", "to": "to", "arrivals": {"saturated": 6}}},
            "load_time": 2,
            "unload_time": 2,
        },
        "traffic": {"nodes": {"B": {"time": 60}}},
        "run": {"length": 1800},
    }
    reliefs = [one.relief for one in suspects(dw.simulate(dw.load(corridor)))]
    assert "at most 1 robot under way" in reliefs


@pytest.fixture
def floor(tmp_path):
    path = tmp_path / "floor.json"
    path.write_text(json.dumps(crowded(60, run=SHORT)))
    return str(path)


@pytest.mark.long
@pytest.mark.parametrize("target", [["--target", "throughput_per_hour >= 9000"], []])
def test_size_says_what_a_cap_gives_where_more_robots_do_not_help(floor, target):
    size = ["size", floor, "--range", "40,60", *target, "--first", "3", "--cap", "6", "--quiet", "--no-cache"]
    output = CliRunner().invoke(desim, size, catch_exceptions=False).stdout
    assert "With at most 30 of 60 robots under way, throughput is " in output
    assert "desim size --key traffic.most_out finds the best cap" in output


@pytest.mark.long
def test_plan_says_what_a_cap_gives_the_largest_fleet_where_none_is_enough(floor):
    plan = ["plan", floor, "--target", "throughput_per_hour >= 9000", "--robots", "59,60", "--first", "3", "--json"]
    done = CliRunner().invoke(desim, [*plan, "--quiet", "--no-cache"], catch_exceptions=False)
    content = json.loads(done.stdout)
    assert content["today"]["capped"]["cap"] == 30
    assert "no fleet is enough" in content["answer"][0]
    assert "With at most 30 of 60 robots under way" in content["answer"][0]
    assert any(one["set"].get("traffic.most_out") == 30 for one in content["options"])
