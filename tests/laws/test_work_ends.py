"""In every warehouse, work ends, nothing impossible happens, and everything is counted.

The warehouses are random, by number, with any features, on one-way floors and on networks with two-way lanes: a few of
each kind every day, 23,000 in the long run. A fault names its number; `python -m tests.laws.features` looks at a single
warehouse, or at a range of numbers.
"""

from functools import cache

import pytest

import desim_warehouse as dw
from desim_warehouse.policies.catalogue import OURS
from tests.laws import two_way
from tests.laws.faults import faults_of
from tests.laws.features import EVERYTHING, FEATURES, ONE_WAY, POLICIES, warehouse
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
    "breakdowns restless",
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
"""Combinations of features."""
DAILY = 1
"""Warehouses of a group that are tested every day, as each feature is in several groups; with two-way lanes, one of
every second group, on shapes in turn."""
TWO_WAY = tuple(features for features in GROUPS if not {"policies", "restless"} & {*features.split()})
"""Groups that are also tested on two-way lanes."""
WENT_WRONG = {
    "": (850,),  # robots took turns at one charger forever after the last load, and the run did not end
    "closures": (260,),  # a robot that waited for a robot and then for an opening turned off
    "wider pods": (794, 1211),  # a run ended as a pod was picked up, or put down, at the node of a station
    "wider moving": (1213,),  # a run ended while a ring gathered speed, and its robots had wrong positions
    "tours pickers": (762,),  # a run ended as a picker unloaded a robot in the lane at a station's node
    "tours breakdowns": (6, 23),  # served next in its station; unloaded in the lane at a station's node
    "closures moving aisles": (421, 623),  # off a node, or out of a bay, a robot drove on as in its ring
    "wider breakdowns": (1157,),  # robots drove to chargers for longer than they stayed, and levels fell forever
    "zones aisles": (24,),  # a robot beside a lane in a zone of one direction counted as in that zone
    EVERYTHING: (287, 572, 701),  # cleared off a lane with people, recalled when let in, in a ring that looked ahead
}
WENT_WRONG_TWO_WAY = {
    ("wider", "tree"): (235,),  # called back in their bays, robots drove out one by one, and back
    ("hours", "ring"): (81,),  # a good in a dead end was driven past, as the way out is slower
    ("aisles", "bridges"): (227,),  # called back just before the node where a good's lane begins
    ("zones", "bridges"): (227,),  # rounding made robots drive past goods in a dead end, called back before it
    ("zones breakdowns", "bridges"): (11,),  # room that a cleared robot gave back was offered at one end only
}
"""Numbers of warehouses with past faults on two-way lanes, by features and ground."""
AS_WRONG = {
    "closures moving": (2234,),  # as in "wider moving"
}
"""Numbers for the long run, as those of every day are of their kind."""
LONG, CHUNK = 300, 50


def cases():
    """Yield (ground, features, numbers, long) in chunks; `long`: only for the long run."""
    for features in GROUPS:
        yield from chunks(ONE_WAY, features, DAILY, LONG)
        if features in WENT_WRONG:
            yield ONE_WAY, features, WENT_WRONG[features], False
        if features in AS_WRONG:
            yield ONE_WAY, features, AS_WRONG[features], True
    for (features, ground), numbers in WENT_WRONG_TWO_WAY.items():
        yield ground, features, numbers, False
    for rank, features in enumerate(TWO_WAY):
        for number, ground in enumerate(KINDS):
            yield from chunks(ground, features, int((rank + number) % 8 == 0), 64)


def chunks(ground, features, daily, count):
    """Yield the first numbers for every day, and all other numbers for the long run."""
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
    by_number = {number: faults_of(warehouse(number, features, ground), number) for number in numbers}
    assert {number: faults for number, faults in by_number.items() if faults} == {}


@pytest.mark.parametrize(
    ("ground", "number"), [pytest.param("bridges", 19, marks=pytest.mark.long), ("bridges", 286), ("ring", 316)]
)
def test_robots_may_start_on_one_lane_in_any_order(ground, number):
    """The robot behind has the smaller number."""
    mapping = wider(moving(two_way.model(ground, number), number), f"{ground} {number}")
    assert faults_of(mapping, number) == []


@cache
def drawn(features, count=40):
    return [dw.load(warehouse(number, features)) for number in range(count)]


def share(models, holds):
    """Return the share of models, or runs, for which a condition holds."""
    return sum(map(bool, map(holds, models))) / len(models)


MODELS = {
    "a battery": ("", 1 / 3, lambda model: model.battery),
    "a warm-up before an end at an instant": ("", 1 / 5, lambda model: model.name != WHOLE and model.run.warm_up),
    "several speeds": ("", 1 / 4, lambda model: len({robot.speed for robot in model.fleet.robots()}) > 1),
    "stops on the way": ("tours", 1 / 6, lambda model: any(flow.via for flow in model.tasks.flows.values())),
    "a station with hours": ("hours", 1 / 4, lambda model: any(item.hours for item in model.layout.stations.values())),
    "a pause": ("hours", 1 / 8, lambda model: any(item.at_close == "pause" for item in model.layout.stations.values())),
    "a buffer": ("hours", 1 / 8, lambda model: any(item.buffer is not None for item in model.layout.stations.values())),
    "shifts": ("hours", 1 / 3, lambda model: model.fleet.has_hours),
    "flows with hours": ("tours hours", 1 / 10, lambda model: any(flow.hours for flow in model.tasks.flows.values())),
    "breakdowns": ("breakdowns", 0.7, lambda model: model.fleet.breaks_down),
    "delays": ("breakdowns", 0.3, lambda model: model.fleet.robot.delays),
    "chargers that fail": ("breakdowns", 0.2, lambda model: any(bay.outages for bay in model.layout.bays.values())),
    "slow zones": ("closures", 1 / 3, lambda model: model.traffic.slow),
    "robots that start on lanes": ("wider", 1 / 4, lambda model: model.fleet.start_on_lanes),
    "a bay in a lane": ("wider", 1 / 20, lambda model: any(bay.in_lane for bay in model.layout.bays.values())),
    "pickers": ("pickers", 0.9, lambda model: model.pickers),
    "pickers who stay": ("pickers", 1 / 6, lambda model: model.pickers and model.pickers.stay == "order"),
    "pickers sent ahead": ("pickers", 1 / 10, lambda model: model.pickers and model.pickers.call == "ahead"),
    "pickers with hours": ("pickers", 1 / 6, lambda model: model.pickers and model.pickers.hours),
    "zones of pickers": ("pickers", 1 / 15, lambda model: model.pickers and model.pickers.zones > 1),
    "sizes": ("restless", 1 / 10, lambda model: len({robot.radius for robot in model.fleet.robots()}) > 1),
}
RUNS = {
    "pods": {"pile_on": 0.9, "pod_visits": 0.9},
    "closures": dict.fromkeys(("waiting_closed", "waiting_person", "encounters_per_hour", "shared_time"), 1 / 5),
    "breakdowns": {"breakdowns": 1 / 2},
    "pickers": {"share_awaiting_picker": 1 / 2, "picker_walking": 1 / 2},
    "moving": {"rotations": 1 / 14, "S": 1 / 3},
}
"""Least share of runs with a feature in which an indicator is above zero."""
FEW = {"pods": 6, "closures": 16, "breakdowns": 8, "pickers": 24, "moving": 10}
"""Runs with a feature in which its effects occur; the long run has more."""


@pytest.mark.parametrize(("features", "least", "holds"), MODELS.values(), ids=MODELS)
def test_models_with_every_feature_are_drawn(features, least, holds):
    """Otherwise the law would be nearly trivial."""
    assert share(drawn(features), holds) > least


@pytest.mark.parametrize(
    ("features", "count"),
    [
        *FEW.items(),
        *(pytest.param(features, 40 if features == "moving" else 24, marks=pytest.mark.long) for features in FEW),
    ],
)
def test_the_effects_of_features_occur_in_runs(features, count):
    runs = [dw.simulate(model, number) for number, model in enumerate(drawn(features, count))]
    for indicator, least in RUNS[features].items():
        assert share(runs, lambda run, of=indicator: run.kpis.get(of, 0) > 0) > least, indicator


def test_policies_work_and_zones_of_every_kind_are_drawn():
    models = drawn("policies", 60)
    for kind in POLICIES:
        assert {getattr(model.policies, kind).name for model in models} == set(OURS[kind])
    assert {type(model.tasks.goods).__name__ for model in models} == {
        "tuple",
        "RandomGoods",
        "SaturatedGoods",
        "PoissonGoods",
    }
    assert {model.tasks.station_choice for model in models} == {"each", "nearest", "least-loaded", "random"}
    toured = drawn("tours")
    assert {model.policies.batching.name for model in toured} == set(OURS["batching"])
    assert {model.fleet.robot.capacity for model in toured} == {2, 3, 4}
    zoned = [dw.load(warehouse(number, "zones", ground)) for ground in KINDS for number in range(6)]
    rules = [zone.rule for model in zoned for zone in model.traffic.zones.values()]
    assert rules.count("one-robot") > 10
    assert rules.count("one-direction") > 10


def test_equal_numbers_and_features_give_equal_models():
    for feature in FEATURES:
        assert warehouse(7, feature) == warehouse(7, feature) != warehouse(8, feature)
