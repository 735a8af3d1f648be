"""Whatever is in a warehouse: work ends, nothing impossible happens, and all is counted.

Random warehouses by number, with any features, on one-way floors and on networks with two-way lanes: a few of each sort
every day, 40,000 in the long run. A fault names its number; `python -m tests.laws.features` looks at one alone.
"""

from functools import cache

import pytest

import desim_warehouse as dw
from tests.laws import two_way
from tests.laws.features import EVERYTHING, FEATURES, ONE_WAY, POLICIES, warehouse
from tests.laws.found import faults_of
from tests.laws.moving import moving
from tests.laws.random_models import WHOLE
from tests.laws.two_way import KINDS
from tests.laws.wider import wider

GROUPS = (
    "",
    "wider",
    "tours",
    "hours",
    "tours hours",
    "zones",
    "capped",
    "zones closures",
    "closures",
    "breakdowns",
    "tours breakdowns",
    "wider breakdowns",
    "zones breakdowns",
    "moving",
    "wider moving",
    "closures moving",
    "pods",
    "wider pods",
    "hours pods breakdowns",
    "kinds closures hours moving pods breakdowns",
    "dwelling",
    "wider dwelling",
    "closures hours dwelling",
    "pods dwelling",
    "capped kinds dwelling",
    "policies",
    "restless",
    "restless breakdowns",
    "lifts",
    f"{EVERYTHING} lifts",
    "pickers",
    "tours pickers",
    "breakdowns aisles pickers",
    "tours hours breakdowns pickers",
    f"{EVERYTHING} pickers",
    EVERYTHING,
    "aisles",
    "zones aisles",
    "tours breakdowns aisles",
    "closures moving aisles",
    "dwelling aisles",
    "pickers aisles",
    f"{EVERYTHING} lifts aisles",
)
"""Features that warehouses have together."""
DAILY = 2
"""Warehouses of a group that are looked at every day, as each feature is in several; of two-way lanes one of each
second shape."""
TWO_WAY = tuple(features for features in GROUPS if not {"policies", "restless"} & {*features.split()})
"""What is put on two-way lanes."""
WENT_WRONG = {
    "": (850,),  # robots took turns at one charger for ever after the last load, and the run did not end
    "closures": (260,),  # a robot turned off that waited for a robot and then for an opening
    "wider pods": (794, 1211),  # a run ended as a pod was picked up, or put down, at the node of a station
    "wider moving": (1213,),  # a run ended while a ring gathered speed: how far its robots had come was wrong
    "closures moving": (2234,),
    "tours breakdowns": (6, 23),  # served next in its station; unloaded in the lane at a station's node
    "closures moving aisles": (623,),  # out of a bay again, a robot drove as in the ring that had brought it there
    "wider breakdowns": (1157,),  # robots drove to chargers for longer than they stayed, and levels fell for ever
    "zones aisles": (24,),  # a robot beside a lane in a zone of one direction counted as in that zone
    EVERYTHING: (287, 572, 701),  # cleared off a lane with people, recalled when let in, in a ring that looked ahead
}
WENT_WRONG_TWO_WAY = {
    ("wider", "tree"): (235,),  # called back in their bays, robots drove out one by one, and back
    ("hours", "ring"): (81,),  # a good in a dead end was driven past, as the way out is slower
    ("zones breakdowns", "bridges"): (11,),  # cleared off a zone, a robot gave up its room, and no other came to know
    ("aisles", "bridges"): (227,),  # called back just before the node where a good's lane begins
}
"""By features and ground."""
LONG, CHUNK = 1300, 50


def cases():
    """(ground, features, numbers, long), in chunks: what is not looked at every day is for the long run."""
    for features in GROUPS:
        yield from chunks(ONE_WAY, features, DAILY, LONG)
        if features in WENT_WRONG:
            yield ONE_WAY, features, WENT_WRONG[features], False
    for (features, ground), numbers in WENT_WRONG_TWO_WAY.items():
        yield ground, features, numbers, False
    for rank, features in enumerate(TWO_WAY):
        for number, ground in enumerate(KINDS):
            yield from chunks(ground, features, 1 if (rank + number) % 2 else 0, 254)


def chunks(ground, features, daily, count):
    """The first numbers for every day, and all others for the long run."""
    if daily:
        yield ground, features, range(daily), False
    yield from (
        (ground, features, range(first, min(first + CHUNK, count)), True) for first in range(daily, count, CHUNK)
    )


def named(ground, features, numbers, long):
    name = f"{features or 'plain'}-{ground}-{numbers[0]}"
    return pytest.param(ground, features, numbers, id=name, marks=[pytest.mark.long] if long else [])


@pytest.mark.parametrize(("ground", "features", "numbers"), [named(*case) for case in cases()])
def test_work_ends_nothing_impossible_happens_and_all_is_counted(ground, features, numbers):
    found = {number: faults_of(warehouse(number, features, ground), number) for number in numbers}
    assert {number: faults for number, faults in found.items() if faults} == {}


@pytest.mark.parametrize(("ground", "number"), [("bridges", 19), ("bridges", 286), ("ring", 316)])
def test_robots_may_start_on_one_lane_in_any_order(ground, number):
    """The one behind has the smaller number."""
    mapping = wider(moving(two_way.model(ground, number), number), f"{ground} {number}")
    assert faults_of(mapping, number) == []


@cache
def drawn(features, count=40):
    return [dw.load(warehouse(number, features)) for number in range(count)]


def share(models, holds):
    """In how many of some models, or runs, something is true."""
    return sum(bool(holds(one)) for one in models) / len(models)


MODELS = {
    "a battery": ("", 1 / 3, lambda one: one.battery),
    "a warm-up before an end at an instant": ("", 1 / 5, lambda one: one.name != WHOLE and one.run.warm_up),
    "several speeds": ("", 1 / 4, lambda one: len({robot.speed for robot in one.fleet.robots()}) > 1),
    "stops on the way": ("tours", 1 / 6, lambda one: any(flow.via for flow in one.tasks.flows.values())),
    "a station with hours": ("hours", 1 / 4, lambda one: any(item.hours for item in one.layout.stations.values())),
    "a pause": ("hours", 1 / 8, lambda one: any(item.at_close == "pause" for item in one.layout.stations.values())),
    "a buffer": ("hours", 1 / 8, lambda one: any(item.buffer is not None for item in one.layout.stations.values())),
    "shifts": ("hours", 1 / 3, lambda one: one.fleet.has_hours),
    "flows with hours": ("tours hours", 1 / 10, lambda one: any(flow.hours for flow in one.tasks.flows.values())),
    "breakdowns": ("breakdowns", 0.7, lambda one: one.fleet.breaks_down),
    "delays": ("breakdowns", 0.3, lambda one: one.fleet.robot.delays),
    "chargers that fail": ("breakdowns", 0.2, lambda one: any(bay.outages for bay in one.layout.bays.values())),
    "slow zones": ("closures", 1 / 3, lambda one: one.traffic.slow),
    "robots that start on lanes": ("wider", 1 / 4, lambda one: one.fleet.start_on_lanes),
    "a bay in a lane": ("wider", 1 / 20, lambda one: any(bay.in_lane for bay in one.layout.bays.values())),
    "pickers": ("pickers", 0.9, lambda one: one.pickers),
    "pickers who stay": ("pickers", 1 / 6, lambda one: one.pickers and one.pickers.stay == "order"),
    "pickers sent ahead": ("pickers", 1 / 10, lambda one: one.pickers and one.pickers.call == "ahead"),
    "pickers with hours": ("pickers", 1 / 6, lambda one: one.pickers and one.pickers.hours),
    "zones of pickers": ("pickers", 1 / 15, lambda one: one.pickers and one.pickers.zones > 1),
    "sizes": ("restless", 1 / 10, lambda one: len({robot.radius for robot in one.fleet.robots()}) > 1),
}
RUNS = {
    "pods": {"pile_on": 0.9, "pod_visits": 0.9},
    "closures": dict.fromkeys(("waiting_closed", "waiting_person", "encounters_per_hour", "shared_time"), 1 / 5),
    "breakdowns": {"breakdowns": 1 / 2},
    "pickers": {"share_awaiting_picker": 1 / 2, "picker_walking": 1 / 2},
    "moving": {"rotations": 1 / 14, "S": 1 / 3},
}
"""In which share of runs with a feature an indicator is above zero."""


@pytest.mark.parametrize(("features", "least", "holds"), MODELS.values(), ids=MODELS)
def test_what_can_go_wrong_is_drawn(features, least, holds):
    """Else the law says little."""
    assert share(drawn(features), holds) > least


@pytest.mark.parametrize("features", RUNS)
def test_what_can_go_wrong_happens(features):
    runs = [
        dw.simulate(model, number) for number, model in enumerate(drawn(features, 40 if features == "moving" else 24))
    ]
    for indicator, least in RUNS[features].items():
        assert share(runs, lambda run, of=indicator: run.kpis.get(of, 0) > 0) > least, indicator


def test_policies_work_and_zones_of_every_kind_are_drawn():
    models = drawn("policies", 60)
    for kind, some in POLICIES.items():
        names = {one if isinstance(one, str) else one["name"] for one in some}
        assert {getattr(one.policies, kind).name for one in models} == names
    assert {type(one.tasks.goods).__name__ for one in models} == {
        "tuple",
        "RandomGoods",
        "SaturatedGoods",
        "PoissonGoods",
    }
    assert {one.tasks.station_choice for one in models} == {"each", "nearest", "least-loaded", "random"}
    toured = drawn("tours")
    assert {one.policies.batching.name for one in toured} == {"fixed-size", "time-window", "by-order", "single"}
    assert {one.fleet.robot.capacity for one in toured} == {2, 3, 4}
    zoned = [dw.load(warehouse(number, "zones", ground)) for ground in KINDS for number in range(6)]
    rules = [zone.rule for one in zoned for zone in one.traffic.zones.values()]
    assert rules.count("one-robot") > 10
    assert rules.count("one-direction") > 10


def test_the_same_number_and_features_are_the_same_model():
    for feature in FEATURES:
        assert warehouse(7, feature) == warehouse(7, feature) != warehouse(8, feature)
