"""Robots that load hold up others: `check` says what that costs, and `why` tries wide aisles."""

import copy

import desim_warehouse as dw
from desim_warehouse.study.suspects import suspects
from tests.world.ring import RING


def busy(aisles="narrow", robots=4):
    """The ring with four places along B > C, at each of which a robot loads for 30; work always waits."""
    mapping = copy.deepcopy(RING)
    layout = mapping["layout"]
    layout["storage"] = [{"edge": ["B", "C"], "offset": offset} for offset in (2, 4, 6, 8)]
    layout["aisles"], layout["bays"] = aisles, {"home": {"at": ["A"], "places": 4}}
    layout["stations"] = {"pack": {"at": ["D"], "places": 4, "servers": 4}}
    mapping["fleet"]["size"] = robots
    mapping["tasks"] = {"goods": {"saturated": 8}, "unload_at": ["pack"], "load_time": 30, "unload_time": 1}
    mapping["run"] = {"length": 4000, "warm_up": 200}
    return dw.load(mapping)


def told(model):
    return [sentence for sentence in dw.check(model).sentences if "hold up" in sentence]


def test_check_measures_what_robots_lose_that_load_in_their_lanes():
    [sentence] = told(busy())
    assert sentence.startswith("Robots hold up others while they load: beside their lanes they would do about ")
    assert sentence.endswith(" % more (layout.aisles: wide).")
    share = int(sentence.split("about ")[1].split()[0]) / 100
    wide, narrow = (dw.simulate(busy(aisles)).kpis["throughput_per_hour"] for aisles in ("wide", "narrow"))
    assert wide / narrow - 1.05 < share < wide / narrow - 0.95


def test_check_says_nothing_where_nobody_is_held_up_or_aisles_are_wide():
    assert told(busy("wide")) == told(busy(robots=1)) == []


def held_up(model):
    return {one.name: one for one in suspects(dw.simulate(model))}.get("narrow aisles")


def test_wide_aisles_are_a_relief_where_robots_wait_behind_others_that_load():
    suspect = held_up(busy())
    assert suspect.overrides == {"layout.aisles": "wide"}
    assert 0.1 < suspect.waited < 0.3
    assert held_up(busy("wide")) is held_up(busy(robots=1)) is None
