"""A run cannot change its model; equal models are equal however they were written."""

import copy
import json
import os
import pickle
import subprocess
import sys
from pathlib import Path

import pytest
from pydantic import ValidationError

from desim_warehouse.errors import ModelError
from desim_warehouse.model import load
from desim_warehouse.values.fields import FrozenMap, Part

MULTIBOTS = Path(__file__).parents[2] / "models" / "multibots.yaml"
POLICY = {"policies.charging": {"name": "threshold", "levels": {"b": [1, 2], "a": {"c": 3}}}}


def test_every_value_in_a_model_is_of_a_kind_that_cannot_be_changed():
    def kinds(value):
        yield type(value)
        if isinstance(value, Part):
            inner = [getattr(value, name) for name in type(value).model_fields] + [value.model_extra or FrozenMap()]
        else:
            inner = value.values() if isinstance(value, FrozenMap) else value if isinstance(value, tuple) else ()
        for item in inner:
            yield from kinds(item)

    types = {kind for kind in kinds(load(MULTIBOTS, POLICY)) if not issubclass(kind, Part)}
    assert types == {str, int, float, bool, tuple, FrozenMap, type(None)}


def test_a_field_cannot_be_set():
    with pytest.raises(ValidationError, match="frozen"):
        load(MULTIBOTS).fleet.size = 2


@pytest.mark.parametrize(
    "change",
    [
        lambda bays: bays.__setitem__("x", 1),
        lambda bays: bays.__delitem__("charging"),
        lambda bays: bays.update(x=1),
        lambda bays: bays.setdefault("x", 1),
        lambda bays: bays.pop("charging"),
        lambda bays: bays.popitem(),
        lambda bays: bays.clear(),
        lambda bays: bays.__ior__({"x": 1}),
    ],
)
def test_named_parts_cannot_be_changed(change):
    model = load(MULTIBOTS)
    with pytest.raises(TypeError, match=r"model\.replace"):
        change(model.layout.bays)
    assert model == load(MULTIBOTS)


def test_parameters_cannot_be_changed_at_any_depth():
    params = load(MULTIBOTS, POLICY).policies.charging.params
    with pytest.raises(TypeError, match=r"model\.replace"):
        params["margin"] = 3
    with pytest.raises(TypeError, match=r"model\.replace"):
        params["levels"]["a"]["c"] = 4


def test_copies_and_pickles_are_equal_and_as_frozen():
    model = load(MULTIBOTS, POLICY)
    for copied in (copy.copy(model), copy.deepcopy(model), pickle.loads(pickle.dumps(model))):  # noqa: S301
        assert copied == model
        assert hash(copied) == hash(model)
        assert copied.digest() == model.digest()
        assert type(copied.layout.bays) is FrozenMap
        assert type(copied.policies.charging.params) is FrozenMap


def test_the_content_is_plain_json_with_defaults_but_without_what_is_empty():
    model = load(MULTIBOTS, POLICY)
    content = model.content()
    assert json.loads(json.dumps(content, allow_nan=False)) == content
    assert content["fleet"]["robot"] == {"radius": 12.5, "speed": 4, "margin": 8, "keeps": "distance", "capacity": 1}
    assert content["run"] == {"warm_up": 0, "start": "00:00"}
    assert content["policies"]["routing"] == "highways"
    assert content["policies"]["charging"] == {"name": "threshold", "levels": {"a": {"c": 3}, "b": [1, 2]}}


def test_the_content_is_a_copy():
    model = load(MULTIBOTS)
    model.content()["tasks"]["goods"].append(5)
    assert model == load(MULTIBOTS)


@pytest.mark.parametrize(
    "written",
    [
        {"fleet.robot.speed": 4.0},
        {"policies.parking": {"name": "home"}},
        {"run": {}},
        {"battery.taper": None},
        {"cost": {"collisions": 100, "time": 4, "distance": 1}},
    ],
)
def test_the_same_model_written_otherwise_has_the_same_digest(written):
    assert load(MULTIBOTS, written).digest() == load(MULTIBOTS).digest()


@pytest.mark.parametrize("written", [{"fleet.robot.speed": 4.5}, {"policies.parking.x": 1}, {"tasks.goods.0": 12}])
def test_another_model_has_another_digest(written):
    assert load(MULTIBOTS, written).digest() != load(MULTIBOTS).digest()


def test_keys_of_sections_have_no_order_but_named_parts_do():
    first = load(MULTIBOTS, {"fleet.kinds": {"small": {"count": 1, "speed": 3}, "large": {"count": 2, "speed": 5}}})
    keys = load(MULTIBOTS, {"fleet.kinds": {"small": {"speed": 3, "count": 1}, "large": {"speed": 5, "count": 2}}})
    names = load(MULTIBOTS, {"fleet.kinds": {"large": {"count": 2, "speed": 5}, "small": {"count": 1, "speed": 3}}})
    assert first == keys
    assert first.digest() == keys.digest()
    assert first != names
    assert first.digest() != names.digest()


def test_replacing_gives_a_new_model_and_keeps_the_old():
    model = load(MULTIBOTS)
    smaller = model.replace({"fleet.size": 3, "policies.charging.margin": 2})
    assert (smaller.fleet.size, smaller.policies.charging.params) == (3, {"margin": 2})
    assert model == load(MULTIBOTS)


def test_parts_of_a_model_can_be_put_into_another():
    model = load(MULTIBOTS, {"policies.charging": {"name": "reach-aware", "margin": 2}, "fleet.robot.speed": 3})
    other = load(MULTIBOTS)
    parts = {"policies.charging": model.policies.charging, "policies.routing": model.policies.routing}
    assert other.replace(parts).policies == model.policies
    assert other.replace({"fleet.robot": model.fleet.robot}).fleet.robot.speed == 3
    assert model.replace({"tasks": model.tasks, "battery": model.battery, "layout": model.layout}) == model


def test_replacing_checks_like_reading():
    with pytest.raises(ModelError) as refused:
        load(MULTIBOTS).replace({"run.length": 9, "run.warm_up": 9.5, "fleet.size": 0})
    assert refused.value.problems == [
        "override fleet.size: should be greater than or equal to 1 (got 0)",
        "override run.warm_up: too long (got 9.5), expected a time below run.length, 9",
    ]


def test_a_problem_of_a_value_that_was_not_replaced_is_named_after_the_model():
    with pytest.raises(ModelError) as refused:
        load(MULTIBOTS).replace({"layout.blocks.rows": 1, "tasks.goods": [1]})
    assert refused.value.problems == [
        (
            "model 'MultiBots': layout.blocks.directions: 3 rows and 6 columns given "
            "for 2 rows and 6 columns of nodes, expected one for each: blocks and one more"
        ),
        (
            "model 'MultiBots': tasks.unload_at.0: no such node (got 'M'), "
            "expected one of A, B, C, D, E, F, G, H, I, J, K or L"
        ),
    ]


@pytest.mark.slow
@pytest.mark.parametrize("seeds", ["1", pytest.param("23", marks=pytest.mark.long)])
def test_the_digest_does_not_depend_on_the_process(seeds):
    code = "import sys, desim_warehouse.model as m; print(m.load(sys.argv[1]).digest())"
    root = MULTIBOTS.parents[1]
    digests = {
        subprocess.run(
            [sys.executable, "-c", code, str(MULTIBOTS)],
            cwd=root,
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in seeds
    }
    assert digests == {load(MULTIBOTS).digest() + "\n"}
