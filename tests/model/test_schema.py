"""The JSON Schema that editors use, and the text it gives them."""

from pathlib import Path

import jsonschema
import pytest
from ruamel.yaml import YAML

from desim_warehouse.model import json_schema, load
from desim_warehouse.model.schema import OUTLINE

MULTIBOTS = Path(__file__).parents[2] / "models" / "multibots.yaml"
BAD = Path(__file__).parents[1] / "bad"


def read(file):
    return YAML(typ="safe", pure=True).load(file.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def validator():
    jsonschema.Draft202012Validator.check_schema(json_schema())
    return jsonschema.Draft202012Validator(json_schema())


def test_the_paper_s_model_is_valid(validator):
    validator.validate(read(MULTIBOTS))


def test_the_content_of_a_model_is_valid(validator):
    changes = {
        "policies.charging.margin": 2,
        "tasks.goods": {"random": 3},
        "tasks.popularity.weights": [1] * 80,
    }
    validator.validate(load(MULTIBOTS, changes).content())


def test_the_forms_that_reading_resolves_are_valid(validator):
    data = read(MULTIBOTS)
    data["tasks"]["popularity"] = {"file": "pop.csv", "column": "demand"}
    data["layout"] = {"nodes": {"A": [0, 1]}, "edges": [["A", "B"]], "storage": {"file": "storage.csv"}}
    data["policies"] = {"charging": {"name": "threshold", "margin": 3}}
    validator.validate(data)


@pytest.mark.parametrize(
    "name",
    [
        "unknown_key", "unknown_section", "missing_key", "number_in_quotes", "zero_robots", "unknown_word",
        "goods_form", "goods_poisson", "consumption_states", "directions_word", "policy_number", "empty_name",
        "node_with_one_number", "edge_of_three", "table_key", "number_for_name", "empty_list",
    ],
)  # fmt: skip
def test_editors_see_the_mistakes_that_one_key_can_show(name, validator):
    assert not validator.is_valid(read(BAD / f"{name}.yaml"))


def test_every_key_is_described():
    schema = json_schema()
    sections = [schema, *schema["$defs"].values()]
    bare = [
        (section["title"], key)
        for section in sections
        for key, value in section.get("properties", {}).items()
        if not value.get("description") and "$ref" not in value
    ]
    assert bare == []
    assert [section["title"] for section in sections if not section.get("description")] == []


def every_key(outline, keys=()):
    """All keys that a file can have, down to a depth that none of ours has."""
    for key in outline.keys_at(keys) if len(keys) < 8 else ():
        yield (*keys, key)
        yield from every_key(outline, (*keys, key))


def test_messages_can_say_what_every_key_expects():
    said = {keys: OUTLINE.expected(keys) for keys in every_key(OUTLINE)}
    assert len(said) > 200
    assert said["tasks", "load_time", "constant"] == "a number (the time, always the same)"


def test_the_schema_is_a_copy_that_may_be_changed():
    json_schema()["properties"].clear()
    assert "fleet" in json_schema()["properties"]
