"""The JSON Schema that editors use, and the text it gives them."""

import re
from pathlib import Path

import jsonschema
import pytest
from jsonschema.exceptions import best_match
from ruamel.yaml import YAML

from desim_warehouse.model import json_schema, load
from desim_warehouse.model.schema import OUTLINE

MULTIBOTS = Path(__file__).parents[2] / "models" / "multibots.yaml"
BAD = Path(__file__).parents[1] / "bad"


def read(file):
    return YAML(typ="safe", pure=True).load(file.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def validator():
    schema = json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_the_paper_s_model_is_valid(validator):
    validator.validate(read(MULTIBOTS))


def test_the_content_of_a_model_is_valid(validator):
    changes = {"policies.charging.margin": 2, "tasks.goods": {"random": 3}, "tasks.popularity.weights": [1] * 80}
    validator.validate(load(MULTIBOTS, changes).content())


def test_the_forms_that_reading_resolves_are_valid(validator):
    data = read(MULTIBOTS)
    data["tasks"]["popularity"] = {"file": "pop.csv", "column": "demand"}
    data["layout"] = {"nodes": {"A": [0, 1]}, "edges": [["A", "B"]], "storage": {"file": "storage.csv"}}
    data["policies"] = {"charging": {"name": "threshold", "margin": 3}}
    validator.validate(data)


def places(error):
    """The dotted keys that an editor underlines: the value, or the keys that are not known or missing."""
    here = [str(key) for key in error.absolute_path]
    ends = {
        "additionalProperties": lambda: set(error.instance) - set(error.schema["properties"]),
        "required": lambda: set(error.validator_value) - set(error.instance),
    }
    if error.validator in ends:
        return {".".join([*here, end]) for end in ends[error.validator]()}
    return {".".join(here)}


@pytest.mark.parametrize(
    "name",
    [
        "unknown_key", "unknown_key_in_bay", "unknown_key_in_list", "unknown_key_of_another_section", "unknown_section",
        "missing_key", "missing_section", "number_in_quotes", "zero_robots", "negative", "fraction_for_whole_number",
        "unknown_word", "word_for_number", "list_for_section", "goods_form", "directions_word", "policy_without_name",
        "popularity_key", "empty_name", "node_with_one_number", "edge_of_three", "table_key", "number_for_name",
        "empty_list", "unit_of_another_kind",
    ],
)  # fmt: skip
def test_editors_underline_a_mistake_where_reading_finds_it(name, validator):
    """The messages of reading are beside the file: file:line:column: key: what is wrong."""
    read_so = (BAD / f"{name}.txt").read_text(encoding="utf-8")
    keys = set(re.findall(r"^\S+?:\d+:\d+: ([\w.]+): ", read_so, re.MULTILINE))
    underlined = [places(best_match([error])) for error in validator.iter_errors(read(BAD / f"{name}.yaml"))]
    assert keys
    assert keys <= set().union(*underlined)


@pytest.mark.parametrize("name", ["consumption_states", "goods_poisson"])
def test_of_a_form_among_several_they_underline_the_section(name, validator):
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
    expected = {keys: OUTLINE.expected(keys) for keys in every_key(OUTLINE)}
    assert len(expected) > 200
    assert expected["tasks", "load_time", "constant"] == "a number (the time, always the same)"


def test_the_schema_is_a_copy_that_may_be_changed():
    json_schema()["properties"].clear()
    assert "fleet" in json_schema()["properties"]
