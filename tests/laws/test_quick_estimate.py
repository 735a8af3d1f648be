"""The law of the quick estimate: a key that changes tasks per hour or energy in a run changes the estimate equally.

Every key of the model with a unit of time, speed, acceleration, energy or power is in a list below, with a change, or
with the reason why it costs no task anything. The test fails for a new key until it is listed.
"""

from functools import lru_cache

import pytest

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.model.facts.keys import containers, kind_of, sections, whole_annotation
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.model.schema import Model
from desim_warehouse.questions.run import simulate
from desim_warehouse.run.quick import BY_TIME, UNKNOWN, WAITS_LEFT_OUT, WAITS_OF_FLEET, estimate, left_out
from desim_warehouse.values.distributions import Distribution
from tests.world.test_lifts import building

CLOSE = 0.03
WAITING = 8
COSTS = {"time", "speed", "acceleration", "energy", "power"}
BREAKS = {"every": 4000, "repair": 600}
HALF = {"calendars": {"half": {"every": 7200, "lasts": 3600}}}
STATES = {"standing": 0.0005, "empty": 0.005, "loaded": 0.01, "handling": 0.002}
BOTH_WAYS = {
    "tasks": {
        "load_time": 10,
        "unload_time": 20,
        "flows": {
            "in": {"from": "packing", "to": "storage", "arrivals": {"poisson": 200}},
            "out": {"from": "storage", "to": "packing", "arrivals": {"poisson": 400}},
        },
    }
}
SMALL = {"capacity": 12.5, "consumption": 0.005, "charge_rate": 0.02}
VIA = {"tasks.flows.out.via": ["packing"], "tasks.flows.out.stop_time": 30}

GOODS = {  # each alone, for a single robot that always has a next good to fetch
    "layout.stations.*.load_time": {**BOTH_WAYS, "layout.stations.packing.load_time": 45},
    "layout.stations.*.unload_time": {"layout.stations.packing.unload_time": 45},
    "layout.stations.*.work_time": {"layout.stations.packing.work_time": 100},
    "layout.bays.*.outages.every": {
        "layout.bays.charging.outages": {"every": 1500, "repair": {"triangular": [100, 300, 500]}}
    },
    "fleet.robot.speed": {"fleet.robot.speed": 3.0},
    "fleet.robot.speed, slow": {"fleet.robot.speed": 0.75},
    "fleet.robot.speed_loaded": {"fleet.robot.speed_loaded": 0.75},
    "fleet.robot.acceleration": {"fleet.robot.acceleration": 0.2},
    "fleet.robot.deceleration": {"fleet.robot.deceleration": 0.2},
    "fleet.robot.breakdowns.every": {"fleet.robot.breakdowns": BREAKS},
    "fleet.robot.delays.time": {"fleet.robot.delays": {"share": 0.1, "time": 20}},
    "fleet.kinds.*.speed": {"fleet.kinds": {"k": {"count": 1, "speed": 0.75}}},
    "fleet.kinds.*.battery.capacity": {"fleet.kinds": {"k": {"count": 1, "battery": SMALL}}},
    "fleet.first_exit_time": {"fleet.first_exit_time": 60},
    "fleet.exit_time": {"fleet.exit_time": 60},
    "tasks.load_time": {"tasks.load_time": 20},
    "tasks.load_time, varied": {"tasks.load_time": {"lognormal": {"mean": 30, "cv": 1}}},
    "tasks.unload_time": {"tasks.unload_time": 40},
    "tasks.clear_time": {"tasks.clear_time": 20},
    "battery.capacity": {"battery.capacity": 12.5},
    "battery.threshold": {"policies.charging": "threshold", "battery.threshold": 5},
    "battery.reserve": {"battery.reserve": 3},
    "battery.consumption": {"battery.consumption": 0.01},
    "battery.consumption.*": {"battery.consumption": STATES},
    "battery.charge_rate": {"battery.charge_rate": 0.01},
    "battery.taper": {"battery.taper": {"start": 0.5}},
    "traffic.node_time": {"traffic.node_time": 3},
    "traffic.turn_time": {"traffic.turn_time": 6},
    "people.*.stay": {"people": {"p": {"per_hour": 60, "stay": 60}}},
    "pickers.speed": {"pickers": {"count": 1, "speed": 0.3}},
    "policies.interval": {"policies.interval": 30},
    "policies.charging, swap": {"policies.charging": {"name": "swap", "time": 120}},
    "policies.charging, opportunity": {"policies.charging": "opportunity"},
    "policies.batching": {"fleet.robot.capacity": 4, "policies.batching": {"name": "fixed-size", "size": 4}},
    "policies.allocation": {"policies.allocation": "nearest"},
    "policies.routing": {"policies.routing": "shortest"},
    "layout.blocks.goods_size": {"layout.blocks.goods_size": 2.4},
    "tasks.popularity": {
        "tasks.popularity": {"classes": [{"share": 0.2, "demand": 0.9}, {"share": 0.8, "demand": 0.1}]}
    },
    "fleet.hours": {**HALF, "fleet.hours": "half"},
    "layout.stations.*.hours": {**HALF, "layout.stations.packing.hours": "half"},
}
FLOWS = {  # with goods that come in and go out
    "tasks.flows.*.load_time": {"tasks.flows.in.load_time": 60},
    "tasks.flows.*.unload_time": {"tasks.flows.out.unload_time": 60},
    "tasks.flows.*.stop_time": VIA,
    "tasks.flows.*.arrivals": {"tasks.flows.out.arrivals": {"poisson": 100}},
    "policies.batching of flows": {"fleet.robot.capacity": 2, "policies.batching": {"name": "fixed-size", "size": 2}},
}
LIFTS = {  # with a robot that rides up and down for each good
    "layout.lifts.*.ride": {"layout.lifts.lift0.ride": 40},
    "layout.lifts.*.doors": {"layout.lifts.lift0.doors": 12},
    "layout.lifts.*.people.transfer": {"layout.lifts.lift0.people": {"per_hour": 40, "transfer": 10}},
    "layout.lifts.*.outages.every": {"layout.lifts.lift0.outages": {"every": {"exponential": 1000}, "repair": 100}},
}
AS = {  # keys that are changed with another key, or like another key
    "layout.edges.*.speed": "traffic.slow.*.speed",
    "layout.edges.*.speed_back": "traffic.slow.*.speed",
    "layout.bays.*.outages.repair": "layout.bays.*.outages.every",
    "layout.lifts.*.outages.repair": "layout.lifts.*.outages.every",
    "fleet.robot.breakdowns.repair": "fleet.robot.breakdowns.every",
    "fleet.robot.breakdowns.clear": "fleet.robot.breakdowns.every",
    "battery.consumption.standing": "battery.consumption.*",
    "battery.consumption.empty": "battery.consumption.*",
    "battery.consumption.loaded": "battery.consumption.*",
    "battery.consumption.handling": "battery.consumption.*",
    "people.*.times": "people.*.stay",
    "people.*.give_way.after": "people.*.stay",
    "calendars.*.every": "fleet.hours",
    "calendars.*.lasts": "fleet.hours",
    "calendars.*.first": "fleet.hours",
    "calendars.*.between": "fleet.hours",
}
KINDS = {"fleet.kinds.*.battery.": "battery.", "fleet.kinds.*.": "fleet.robot."}
"""Keys of kinds of robots, which are changed like those of all robots."""
NO_COST = {
    "tasks.goods.due_within": "when a task is due, not how long it takes",
    "tasks.goods.*.release": "when a task is known",
    "tasks.goods.*.due": "when a task is due",
    "tasks.flows.*.arrivals.profile.every": "when tasks are known",
    "tasks.flows.*.arrivals.schedule.*.at": "when tasks are known",
    "tasks.flows.*.arrivals.orders.resample": "when tasks are known",
    "tasks.flows.*.due_within": "when a task is due",
    "tasks.flows.*.due_at": "when a task is due",
    "tasks.flows.*.due_at.times": "when a task is due",
    "tasks.flows.*.due_at.cut_off": "when a task is due",
    "pods.change_time": "with pods a task is a line, see tests/world/test_pods.py",
    "run.length": "how long is looked at",
    "run.warm_up": "how long is looked at",
}
TO_LIST = """keys with a unit of time, speed, acceleration, energy or power that tests/laws/test_quick_estimate.py
does not list. Each is either in GOODS, FLOWS or LIFTS, with a change that a run and the estimate must follow alike;
in AS, if it is changed with another key; or in NO_COST, with the reason why no task takes longer or more energy: """
TO_FOLLOW = """figures of the estimate that do not change with {key} as those of a run do: {apart}; in APART: {listed}.
Let the estimate follow (run/quick.py, run/probe.py);
or report the key in a line of `left_out` in run/quick.py, and list it in APART of tests/laws/test_quick_estimate.py."""
PLACES = {"traffic.slow.*.speed", "traffic.nodes.*.time"}
"""Keys that name nodes or edges of the floor: see `_places`."""


@lru_cache(maxsize=1)
def goods():
    """Return a robot that always has work, on the floor of a draft, with a battery that is charged often."""
    words = Draft(size=(40, 30), orders=30, stations=2, robots=1, chargers=1)
    changes = {
        "tasks.goods": {"saturated": WAITING},
        "policies.allocation": "in-order",
        "battery.capacity": 25,
        "battery.consumption": 0.005,
        "traffic.node_time": 0.5,
        "tasks.clear_time": 2,
        "fleet.exit_time": 4,
        "layout.stations.packing.places": 10,
        "log": "tasks",
    }
    return dw.Model.model_validate(read_yaml(draft(words), "draft").data).replace(changes)


@lru_cache(maxsize=1)
def flows():
    """Return the robot of `goods` with goods that come in and go out."""
    return goods().replace(BOTH_WAYS)


@lru_cache(maxsize=1)
def lifts():
    """Return a robot that brings goods to another floor, by a lift that comes back down."""
    alone = {
        "tasks.goods": {"saturated": WAITING},
        "policies.allocation": "in-order",
        "fleet.size": 1,
        "layout.lifts.lift0.rests": "a0",
        "layout.bays.home.chargers": 1,
        "policies.charging": "reach-aware",
        "battery": {"capacity": 25, "consumption": 0.005, "charge_rate": 0.02},
        "log": "tasks",
    }
    return dw.load(building(1, "fastest")).replace(alone)


def _places():
    floor = goods().floor
    aisles = [list(edge) for edge in list(dict.fromkeys(place.edge for place in floor.storage))[:4]]
    node = sorted(floor.points)[len(floor.points) // 2]
    return {
        "traffic.slow.*.speed": {"traffic.slow": {"s": {"members": aisles, "speed": 0.3}}},
        "traffic.nodes.*.time": {"traffic.nodes": {node: {"time": 15}}},
    }


@lru_cache(maxsize=6)
def base(plain, length):
    return figures(plain(), length)


def figures(model, length):
    """Return tasks per hour and energy per task of a run, and of the estimate; policies choose among eight tasks."""
    kpis = simulate(model.replace({"run": {"length": length, "warm_up": length / 10}}), 1).kpis
    quick = estimate(model, None if model.policies.allocation.name in BY_TIME else WAITING)
    return ((kpis["throughput_per_hour"], kpis["energy"] / kpis["tasks"]), (quick.capacity * 3600, quick.power.task))


MOVED = {
    **{name: (goods, changes) for name, changes in GOODS.items()},
    **{name: (flows, changes) for name, changes in FLOWS.items()},
    **{name: (lifts, changes) for name, changes in LIFTS.items()},
}
APART = {"fleet.robot.breakdowns.every": ["energy"], "fleet.hours": ["tasks"], "layout.stations.*.hours": ["tasks"]} | {
    f"layout.lifts.*.{key}": ["tasks", "energy"] for key in ("people.transfer", "outages.every")
}
"""Figures of the estimate that do not follow a key, which a line of the check reports."""


def named(model, plain):
    """Whether a line of the check reports that the estimate leaves a change out."""
    lines = set(left_out(model, model.floor)) - set(left_out(plain(), plain().floor))
    return any(line.endswith((UNKNOWN, WAITS_LEFT_OUT, WAITS_OF_FLEET)) for line in lines)


NAMES = [*MOVED, *sorted(PLACES)]
SHORT, WHOLE = 100_000, 200_000
FLOWS_BOTH_WAYS = {"layout.stations.*.load_time", "tasks.flows.*.stop_time"}
"""Estimates of flows both ways are left to the long run; every day tests/feasibility/test_flow_mix.py mixes flows."""
DAILY = ["layout.stations.*.unload_time", *(name for name in NAMES[::6] if name not in FLOWS_BOTH_WAYS)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "length"),
    [
        *((name, SHORT) for name in DAILY),
        *(pytest.param(name, WHOLE, marks=pytest.mark.long) for name in NAMES),
    ],
)
def test_a_key_that_changes_a_run_changes_the_estimate(name, length):
    plain, changes = MOVED[name] if name in MOVED else (goods, _places()[name])
    model = plain().replace(changes)
    before, after = base(plain, length), figures(model, length)
    moved = [[now / then for now, then in zip(*pair, strict=True)] for pair in zip(after, before, strict=True)]
    apart = [what for what, run, quick in zip(("tasks", "energy"), *moved, strict=True) if abs(quick / run - 1) > CLOSE]
    listed = APART.get(name, [])
    assert apart == listed, TO_FOLLOW.format(key=name, apart=apart, listed=listed)
    assert not apart or named(model, plain), f"no line of `left_out` in run/quick.py reports {name}"


def walked(annotation, place="", seen=frozenset()):
    """Yield the keys of the model with a unit of time, speed, acceleration, energy or power."""
    for section in sections(annotation):
        if issubclass(section, Distribution) or section in seen:
            continue
        for name, field in section.model_fields.items():
            whole, key = whole_annotation(field), f"{place}.{field.alias or name}".lstrip(".")
            if kind_of(whole) in COSTS:
                yield key
            yield from walked(whole, key, seen | {section})
    for inner, _ in containers(annotation):
        yield from walked(inner, f"{place}.*", seen)


def test_every_key_that_may_cost_time_or_energy_is_listed():
    listed = {*MOVED, *PLACES, *AS, *NO_COST}
    assert set(AS.values()) <= {*MOVED, *PLACES}
    missing = set(walked(Model)) - listed
    of_kinds = {key for key in missing for own, every in KINDS.items() if key.replace(own, every, 1) in listed}
    assert missing == of_kinds, TO_LIST + ", ".join(sorted(missing - of_kinds))
    plain = {name for name in {*AS, *NO_COST, *PLACES} if "consumption.*" not in name}
    assert plain <= set(walked(Model)), "listed, but no key of the model"
