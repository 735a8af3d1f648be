"""Dotted keys that change a model, from Python and from the command line."""

from pathlib import Path

import pytest

from desim_warehouse.errors import ModelError
from desim_warehouse.model import load, parse_assignment

MULTIBOTS = Path(__file__).parents[2] / "models" / "multibots.yaml"


def problems(overrides, **how):
    with pytest.raises(ModelError) as refused:
        load(MULTIBOTS, overrides, **how)
    return refused.value.problems


@pytest.mark.parametrize(
    ("key", "value", "find"),
    [
        ("fleet.size", 3, lambda model: model.fleet.size),
        ("fleet.robot.margin", 0, lambda model: model.fleet.robot.margin),
        ("tasks.goods", (11, 8), lambda model: model.tasks.goods),
        ("tasks.goods.1", 9, lambda model: model.tasks.goods[1]),
        ("fleet.start.0", "R", lambda model: model.fleet.start[0]),
        ("layout.bays.charging.chargers", 2, lambda model: model.layout.bays["charging"].chargers),
        ("layout.bays.spare.at", ("M",), lambda model: model.layout.bays["spare"].at),
        ("layout.blocks.directions.rows.1", "west", lambda model: model.layout.blocks.directions.rows[1]),
        ("battery", None, lambda model: model.battery),
        ("run.length", 100, lambda model: model.run.length),
        ("policies.charging.margin", 2, lambda model: model.policies.charging.params["margin"]),
        ("policies.charging.levels.low", 2, lambda model: model.policies.charging.params["levels"]["low"]),
    ],
)
def test_an_override_sets_the_value_at_its_key(key, value, find):
    assert find(load(MULTIBOTS, {key: value})) == value


def test_a_parameter_keeps_the_policy_of_the_file_or_the_default():
    assert load(MULTIBOTS, {"policies.charging.margin": 2}).policies.charging.name == "threshold"
    bare = load(MULTIBOTS, {"policies": {}, "policies.parking.every": 2})
    assert (bare.policies.parking.name, dict(bare.policies.parking.params)) == ("home", {"every": 2})


def test_a_policy_and_its_parameters_may_be_overridden_together():
    model = load(MULTIBOTS, {"policies.charging.margin": 2, "policies.charging": "early"})
    assert (model.policies.charging.name, dict(model.policies.charging.params)) == ("early", {"margin": 2})


def test_a_parameter_with_numbers_for_names():
    model = load(MULTIBOTS, {"policies.charging.levels": {"0": 1, "1": 2}, "policies.charging.levels.1": 5})
    assert model.policies.charging.params["levels"] == {"0": 1, "1": 5}


def test_an_entry_in_a_list_of_a_parameter():
    model = load(MULTIBOTS, {"policies.charging.levels": [1, 2], "policies.charging.levels.1": 5})
    assert model.policies.charging.params["levels"] == (1, 5)


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({"fleet.size": 0}, "override fleet.size: should be greater than or equal to 1 (got 0)"),
        ({"fleet": {"size": 1}}, "override fleet.robot: missing, expected a section with radius and speed"),
        ({"flet.size": 3}, "override flet.size: unknown key, did you mean 'fleet.size'?"),
        ({"fleet.sise": 3}, "override fleet.sise: unknown key, did you mean 'fleet.size'?"),
        ({"size": 3}, "override size: unknown key, did you mean 'fleet.size'?"),
        ({"fleet.size.of": 3}, "override fleet.size.of: unknown key: 'fleet.size' has no keys below it"),
        (
            {"layout.bays.charging.charger": 3},
            ("override layout.bays.charging.charger: unknown key, did you mean 'layout.bays.charging.chargers'?"),
        ),
        (
            {"zzz": 3},
            (
                "override zzz: unknown key, expected name, description, units, calendars, layout, fleet, tasks, "
                "pods, pickers, battery, traffic, people, policies, run, cost, prices, log or accept"
            ),
        ),
        (
            {"fleet.start.6": "A"},
            (
                "override fleet.start.6: no entry 6 in 'fleet.start' (it has 6 entries, 0 to 5), "
                "expected one of these, or 'fleet.start' as a whole"
            ),
        ),
        (
            {"layout.nodes.A": [0, 0]},
            (
                "override layout.nodes.A: layout.nodes: blocks make their own nodes, "
                "expected blocks, or nodes, edges and storage"
            ),
        ),
        (
            {"battery.consumption.empty": 1},
            (
                "override battery.consumption.empty: nothing can be set below 'battery.consumption' here "
                "(it is 0.005), expected 'battery.consumption' as a whole"
            ),
        ),
        ({"fleet..size": 1}, "override fleet..size: not a key, expected one such as 'fleet.size'"),
        ({3: 1}, "override 3: not a key, expected one such as 'fleet.size'"),
        ({"tasks.load_time": True}, "override tasks.load_time: should be a number (got true)"),
        (
            {"tasks.goods": [1, 80]},
            "override tasks.goods.1: no such good (got 80), expected a number from 0 to 79",
        ),
        (
            {"policies.routing.zones": {1, 2}},
            (
                "override policies.routing.zones: not a value a model file can have (got set), "
                "expected numbers, text, lists and mappings"
            ),
        ),
        (
            {"policies.routing.zones": [1, float("nan")]},
            "override policies.routing.zones.1: should be a finite number (got .nan)",
        ),
    ],
    ids=lambda value: next(iter(map(str, value))) if isinstance(value, dict) else "",
)
def test_a_bad_override_is_refused_under_its_own_name(overrides, message):
    assert problems(overrides) == [message]


def test_the_command_line_gives_overrides_its_own_name():
    assert problems({"fleet.size": 0}, named="--set") == [
        "--set fleet.size: should be greater than or equal to 1 (got 0)"
    ]


def test_a_mistake_in_a_section_is_told_at_its_place_alone():
    """The place is a key that can be overridden itself; it names the section that was written, too."""
    truck = {"count": 1, "battery": {"capacity": 3000, "charge_rate": 1, "consumption": -2}}
    assert problems({"fleet.kinds": {"truck": truck}}, named="--set") == [
        "--set fleet.kinds.truck.battery.consumption: should be greater than or equal to 0 (got -2)"
    ]


def test_problems_stand_in_the_order_of_the_file_and_those_of_overrides_last(tmp_path):
    file = tmp_path / "model.yaml"
    file.write_text(
        "fleet: {size: 2, robot: {radius: 1, speed: 0}}\n"
        "layout: {blocks: {columns: 1, rows: 1, block_depth: 1, goods_size: 1, aisle_width: 1}}\n"
        "tasks: {goods: [0], unload_at: [E], load_time: 1, unload_time: 1}\n",
        encoding="utf-8",
    )
    with pytest.raises(ModelError) as refused:
        load(file, {"tasks.unload_time": -1, "cost.tim": 1})
    assert refused.value.problems == [
        f"{file}:1:44: fleet.robot.speed: should be greater than 0 (got 0)",
        f"{file}:3:33: tasks.unload_at.0: no such node (got 'E'), expected one of A, B, C or D",
        "override cost.tim: unknown key, did you mean 'cost.time'?",
        "override tasks.unload_time: should be greater than or equal to 0 (got -1)",
    ]


def test_a_section_that_an_override_makes_is_named_after_it():
    assert problems({"battery": None, "battery.capacity": 3}) == [
        (
            "override battery.capacity: battery.consumption: missing, expected a number of at least 0, "
            "or a section with standing, empty, loaded and handling"
        ),
        (
            "override battery.capacity: battery.charge_rate: missing, expected a number "
            "(energy per time unit at a charger)"
        ),
    ]


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("fleet.size=3", "fleet.size", 3),
        (" fleet.size = 3", "fleet.size", 3),
        ("traffic.node_time=1.5", "traffic.node_time", 1.5),
        ("tasks.goods=[11, 8]", "tasks.goods", [11, 8]),
        ("tasks.goods={random: 20}", "tasks.goods", {"random": 20}),
        ("fleet.start.0=N", "fleet.start.0", "N"),
        ("name='4'", "name", "4"),
        ("name=a=b", "name", "a=b"),
        ("battery=null", "battery", None),
        ("policies.charging.eager=true", "policies.charging.eager", True),
    ],
)
def test_an_assignment_is_a_key_and_a_yaml_value(text, key, value):
    assignment = parse_assignment(text)
    assert assignment == (key, value)
    assert type(assignment[1]) is type(value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("fleet.size", "--set fleet.size: no assignment, expected KEY=VALUE such as fleet.size=3"),
        ("=3", "--set =3: no assignment, expected KEY=VALUE such as fleet.size=3"),
        ("fleet.size=", "--set fleet.size: no value after '=', expected one (--unset fleet.size leaves the key out)"),
        (
            "tasks.goods=[1, 2",
            (
                "--set tasks.goods:1:6: not valid YAML: while parsing a flow sequence, "
                "expected ',' or ']', but got '<stream end>'"
            ),
        ),
        ("tasks.goods={random: 1, random: 2}", "--set tasks.goods: given twice (first on line 1), expected once"),
        ("fleet.size=!!int 3", None),
        ("fleet.size=!robots 3", "--set fleet.size: unknown tag (got !robots), expected a value without a tag"),
    ],
)
def test_an_assignment_that_cannot_be_read(text, message):
    if message is None:
        assert parse_assignment(text) == ("fleet.size", 3)
        return
    with pytest.raises(ModelError) as refused:
        parse_assignment(text)
    assert str(refused.value) == message


@pytest.mark.parametrize(
    ("key", "expected"),
    [
        ("layout.bays.*.places", "expected layout.bays.charging.places"),
        ("layout.blocks.*", "expected one of layout.blocks.columns, layout.blocks.rows"),
        ("tasks.flows.*.due_within", "expected a name"),
    ],
)
def test_a_star_stands_for_no_name(key, expected):
    [problem] = problems({key: 2})
    assert problem.startswith(f"override {key}: a star does not stand for all names here, {expected}")
