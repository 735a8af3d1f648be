"""Quantities with units: the same model as with plain numbers, or one clear refusal."""

from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.errors import ModelError
from desim_warehouse.model import json_schema, load, parse_assignment
from desim_warehouse.values.units import METRES, SECONDS, UnitNames, converted

MULTIBOTS = Path(__file__).parents[2] / "models" / "multibots.yaml"
TUTORIAL = Path(__file__).parents[2] / "models" / "tutorial.yaml"


def refused(overrides, source=TUTORIAL):
    with pytest.raises(ModelError) as error:
        load(source, overrides)
    return error.value.problems


@pytest.mark.parametrize(
    ("units", "key", "written", "number"),
    [
        ({}, "run.length", "8 h", 28800),
        ({}, "tasks.load_time", "15 min", 900),
        ({}, "tasks.unload_time", "1500 ms", 1.5),
        ({}, "policies.interval", "0.5min", 30),
        ({}, "fleet.robot.speed", "1.5 m/s", 1.5),
        ({}, "fleet.robot.speed", "5.4 km/h", 1.5),
        ({}, "fleet.robot.speed", "5 ft/s", 1.524),
        ({}, "fleet.robot.speed", "300ft/min", 1.524),
        ({}, "fleet.robot.speed", "3 mph", 1.34112),
        ({}, "fleet.robot.acceleration", "2 ft/s^2", 0.6096),
        ({}, "fleet.robot.radius", "15 in", 0.381),
        ({"length": "cm"}, "fleet.robot.radius", "1.25ft", 38.1),
        ({}, "fleet.robot.acceleration", "0.5 m/s^2", 0.5),
        ({"length": "cm", "time": "min", "seconds": 60}, "fleet.robot.deceleration", "500 mm/s²", 180_000),
        ({}, "fleet.robot.radius", "350 mm", 0.35),
        ({}, "layout.blocks.goods_size", "90 cm", 0.9),
        ({"length": "mm"}, "fleet.robot.radius", "35 cm", 350),
        ({"length": "cm", "time": "min", "seconds": 60}, "fleet.robot.speed", "1 m/s", 6000),
        ({"time": "min", "seconds": 60}, "run.length", "8 h", 480),
        ({"time": "step", "seconds": 0.05}, "run.length", "1 min", 1200),
    ],
)
def test_a_quantity_is_the_number_in_the_units_of_the_model(units, key, written, number):
    base = {"units": units} if units else {}
    assert load(TUTORIAL, {**base, key: written}).digest() == load(TUTORIAL, {**base, key: number}).digest()


def test_rates_and_shares_take_units():
    goods = {"poisson": "200 / h", "due_within": "30 min"}
    classes = [{"share": "25 %", "demand": "80 %"}, {"share": 0.75, "demand": 0.2}]
    tasks = load(TUTORIAL, {"run.length": "8 h", "tasks.goods": goods, "tasks.popularity": {"classes": classes}}).tasks
    assert (tasks.goods.poisson, tasks.goods.due_within) == (200, 1800)
    assert load(TUTORIAL, {"run.length": "8 h", "tasks.goods": {"poisson": "3/min"}}).tasks.goods.poisson == 180
    assert (tasks.popularity.classes[0].share, tasks.popularity.classes[0].demand) == (0.25, 0.8)
    assert load(MULTIBOTS, {"battery.taper": {"start": "80 %"}}).battery.taper.start == 0.8


def test_in_a_file_on_the_command_line_and_in_a_table(tmp_path):
    (tmp_path / "storage.csv").write_text("from,to,offset\na,b,600 mm\n", encoding="utf-8")
    (tmp_path / "model.yaml").write_text(
        "layout:\n  nodes: {a: [0, 0], b: [100 cm, 2 m]}\n"
        "  edges: [[a, b], {from: b, to: a, length: 4000 mm, speed: 1 m/s}]\n"
        "  storage: {file: storage.csv}\n  bays: {home: {at: [a]}}\n"
        "fleet: {size: 1, robot: {radius: 20 cm, speed: 1}}\n"
        "tasks: {goods: [0], unload_at: [b], load_time: 5 s, unload_time: 1 min}\n",
        encoding="utf-8",
    )
    key, value = parse_assignment("run.length=2 h")
    model = load(tmp_path / "model.yaml", {key: value})
    assert model.layout.nodes["b"] == (1, 2)
    assert (model.layout.edges[1].length, model.layout.edges[1].speed) == (4, 1)
    assert model.layout.storage[0].offset == 0.6
    assert (model.tasks.load_time, model.tasks.unload_time, model.run.length) == (5, 60, 7200)


def test_parameters_of_policies_have_units_too():
    written = {"policies.charging": {"name": "swap", "time": "2 min", "level": "25 %"}}
    assert load(MULTIBOTS, written).policies.charging.params == {"level": 0.25, "time": 2400}  # of 0.05 s
    minutes = {"units": {"time": "min", "seconds": 60}, "policies.batching": {"name": "time-window", "window": "90 s"}}
    assert load(TUTORIAL, minutes).policies.batching.params == {"window": 1.5}
    assert refused({"policies.batching": {"name": "time-window", "window": "60 mm"}}) == [
        (
            "override policies.batching.window: not a time (got '60 mm'), expected a time such as "
            "15 min, in ms, s, min, h or d"
        )
    ]


def test_demand_may_be_per_cent():
    saturated = {"run.length": "8 h", "tasks.goods": {"poisson": 40}}
    assert load(TUTORIAL, {**saturated, "tasks.demand": "130 %"}).tasks.demand == 1.3


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("run.length", "600 mm", "not a time (got '600 mm'), expected a time such as 15 min, in ms, s, min, h or d"),
        ("run.length", "8 hrs", "not a time (got '8 hrs'), expected a time such as 15 min, in ms, s, min, h or d"),
        (
            "run.length",
            "8 mni",
            "not a time (got '8 mni'), expected a time such as 15 min, in ms, s, min, h or d; did you mean 'min'?",
        ),
        ("fleet.robot.speed", "3 h", "not a speed (got '3 h'), expected a speed such as 1.5 m/s"),
        (
            "fleet.robot.acceleration",
            "1 m/s",
            "not an acceleration (got '1 m/s'), expected an acceleration such as 0.5 m/s^2; did you mean 'm/s²'?",
        ),
        (
            "fleet.robot.radius",
            "25 %",
            "not a length (got '25 %'), expected a length such as 600 mm, in mm, cm, dm, m, km, in or ft",
        ),
        ("tasks.load_time", "-5 s", "should be greater than or equal to 0 (got -100)"),
        ("fleet.size", "3 h", "should be a whole number (got '3 h')"),
        ("battery.capacity", "5 kWh", "should be a number (got '5 kWh')"),
        ("run.length", "8", "should be a number (got '8'); write it without quotes"),
    ],
)
def test_a_unit_of_another_kind_is_refused(key, value, message):
    assert refused({key: value}, MULTIBOTS) == [f"override {key}: {message}"]


def test_lengths_in_pixels_have_no_size():
    assert refused({"fleet.robot.radius": "600 mm", "fleet.robot.speed": "1 m/s"}, MULTIBOTS) == [
        (
            "override fleet.robot.radius: cannot be converted (got '600 mm'), as units.length is 'px'; "
            "write a plain number of px, or mm, cm or m in units.length"
        ),
        (
            "override fleet.robot.speed: cannot be converted (got '1 m/s'), as units.length is 'px'; "
            "write a plain number of px, or mm, cm or m in units.length"
        ),
    ]


def test_a_time_unit_that_is_not_as_long_as_its_name_says_converts_nothing():
    assert refused({"units": {"time": "min"}, "run.length": "8 h"}) == [
        (
            "override run.length: cannot be converted (got '8 h'): units.time is 'min', but units.seconds is 1; "
            "correct one of the two"
        )
    ]
    assert load(TUTORIAL, {"units": {"time": "min"}, "run.length": 480}).run.length == 480


@given(
    st.decimals(min_value=0, max_value=10**9, places=3),
    st.sampled_from(list(METRES)),
    st.sampled_from(["mm", "cm", "m"]),
)
def test_lengths_are_converted_exactly(number, written, unit):
    exact = Fraction(number) * METRES[written] / METRES[unit]
    assert converted(f"{number} {written}", "length", UnitNames(length=unit)) == float(exact)


@given(st.integers(0, 10**9), st.sampled_from(list(SECONDS)))
def test_times_are_converted_exactly(number, unit):
    assert converted(f"{number} {unit}", "time", UnitNames()) == float(number * SECONDS[unit])


@given(st.text(max_size=9), st.sampled_from(["length", "time", "speed", "rate", "share"]))
def test_text_without_a_number_and_a_unit_is_no_quantity(text, kind):
    if not any(char.isdigit() for char in text):
        assert converted(text, kind, UnitNames()) is None


def test_editors_take_units_for_right():
    import jsonschema

    validator = jsonschema.Draft202012Validator(json_schema())
    content = load(TUTORIAL).content()
    content["run"]["length"], content["fleet"]["robot"]["speed"] = "8 h", "1.5 m / s"
    assert validator.is_valid(content)
    content["run"]["length"] = "8 hours"
    assert not validator.is_valid(content)


@pytest.mark.parametrize(
    ("key", "written", "meant"),
    [
        ("fleet.robot.radius", "2 feet", "ft"),
        ("fleet.robot.radius", "15 inches", "in"),
        ("run.length", "8 hours", "h"),
        ("run.length", "90 minutes", "min"),
        ("fleet.robot.speed", "300 fpm", "ft/min"),
        ("fleet.robot.speed", "5 kmh", "km/h"),
    ],
)
def test_another_name_of_a_unit_is_answered_with_ours(key, written, meant):
    assert refused({key: written})[0].endswith(f"; did you mean '{meant}'?")
