"""Which keys a model can have and what each expects, in words, read off the JSON Schema."""

from __future__ import annotations

import difflib
from functools import cache
from typing import TYPE_CHECKING, Any

from desim_warehouse.model.places import Keys, dotted
from desim_warehouse.model.schema import Model

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

Node = dict[str, Any]
_ALIKE, _VERY_ALIKE = 0.6, 0.8  # of 1, as difflib counts
_LONG = 3  # letters that may stand for a longer word
_OPEN: Node = {"additionalProperties": True}  # below the parameters of a policy anything can stand


@cache
def schema() -> Node:
    """The JSON Schema of model files; shared, so not to be changed."""
    made = Model.model_json_schema()
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **made,
        "title": "desim-warehouse model",
    }


def spoken(words: Iterable[str], last: str = "and") -> str:
    """A list as it is said: a, b and c."""
    *head, tail = list(words)
    return f"{', '.join(head)} {last} {tail}" if head else tail


def nearest(word: str, words: Iterable[str]) -> str | None:
    """The word most like the given one, if any is."""
    lower = {known.lower(): known for known in words}
    near = difflib.get_close_matches(word.lower(), lower, n=1, cutoff=_ALIKE)
    if near:
        return lower[near[0]]
    longer = [known for known in lower if len(word) >= _LONG and known.startswith(word.lower())]
    return lower[longer[0]] if longer else None


def keys_at(keys: Keys) -> list[str]:
    """The keys that a section can have."""
    return list(dict.fromkeys(key for form in _at(keys) for key in form.get("properties", {})))


def known(keys: Keys) -> bool:
    """Whether a model can have such a key."""
    return bool(_at(keys))


def is_list(keys: Keys) -> bool:
    """Whether a list can stand there."""
    return any("items" in form or "prefixItems" in form or form == _OPEN for form in _at(keys))


def choices(keys: Keys) -> list[str]:
    """The words that can stand there."""
    return [str(word) for form in _at(keys) for word in _words(form)]


def meant(keys: Keys) -> str | None:
    """The valid key that an unknown one is most like: beside it, or with the same name elsewhere."""
    *parents, last = keys
    beside = nearest(str(last), keys_at(tuple(parents)))
    if beside is not None:
        return dotted((*parents, beside))
    leaves = [key.rpartition(".")[2] for key in _every_key()]
    leaf = next(iter(difflib.get_close_matches(str(last), leaves, n=1, cutoff=_VERY_ALIKE)), None)
    same = [key for key, name in zip(_every_key(), leaves, strict=True) if name == leaf]
    return max(same, key=lambda key: _alike(key, dotted(keys)), default=None)


def _alike(one: str, other: str) -> float:
    return difflib.SequenceMatcher(None, one, other).ratio()


def expected(keys: Keys) -> str:
    """What a key expects, in words."""
    return _said(_node(keys))


def _at(keys: Keys) -> list[Node]:
    """The forms a value can have."""
    forms = list(_forms(schema()))
    for key in keys:
        forms = [form for node in forms for step in _step(node, key) for form in _forms(step)]
    return forms


def _node(keys: Keys) -> Node:
    """The first description of a key, with its own words if it has any."""
    if not keys:
        return schema()
    *parents, key = keys
    steps = [step for form in _at(tuple(parents)) for step in _step(form, key)]
    return steps[0] if steps else {}


def _step(node: Node, key: str | int) -> Iterator[Node]:
    if node == _OPEN:
        yield _OPEN
    elif isinstance(key, int):
        if "items" in node:
            yield node["items"]
        yield from node.get("prefixItems", [])[key : key + 1]
    elif key in node.get("properties", {}):
        yield node["properties"][key]
    elif node.get("additionalProperties") is True:
        yield _OPEN
    elif node.get("additionalProperties"):
        yield node["additionalProperties"]


def _forms(node: Node) -> Iterator[Node]:
    if "$ref" in node:
        yield from _forms(schema()["$defs"][node["$ref"].rsplit("/", 1)[1]])
    elif "anyOf" in node or "oneOf" in node:
        for form in [*node.get("anyOf", []), *node.get("oneOf", [])]:
            yield from _forms(form)
    elif node.get("type") != "null":
        yield node


@cache
def _every_key() -> tuple[str, ...]:
    def below(keys: Keys) -> Iterator[str]:
        for key in keys_at(keys):
            yield dotted((*keys, key))
            yield from below((*keys, key))

    return tuple(below(()))


def _words(node: Node) -> list[Any]:
    return list(node.get("enum", [node["const"]] if "const" in node else []))


def _said(node: Node) -> str:
    if "errorMessage" in node:
        return str(node["errorMessage"]).removeprefix("expected ")
    return spoken(dict.fromkeys(_one(form) for form in _forms(node)), "or")


def _one(form: Node) -> str:  # noqa: PLR0911 - a return for each kind of form
    """One form in words, for a single value."""
    if _words(form):
        return spoken([f"'{word}'" for word in _words(form)], "or")
    match form.get("type"):
        case "integer":
            return f"a whole number{_range(form)}"
        case "number":
            return f"a number{_range(form)}"
        case "string":
            return "a name" if form.get("minLength") else "text"
        case "array" if "prefixItems" in form:
            return f"a list of {len(form['prefixItems'])} {_many(form['prefixItems'][0])}"
        case "array":
            return f"a list of {_many(form['items'])}"
        case "object" if "properties" in form:
            return f"a section with {spoken(form.get('required') or form['properties'])}"
        case "object":
            return f"names, each followed by {_said(form['additionalProperties'])}"
        case _:
            return "a value"


def _many(node: Node) -> str:
    """The same for the entries of a list."""
    if "errorMessage" in node:
        return f"entries, each {_said(node)}"
    said = _one(next(_forms(node)))
    for single, several in (
        ("a whole number", "whole numbers"),
        ("a number", "numbers"),
        ("a name", "names"),
        ("a section", "sections"),
    ):
        if said.startswith(single):
            return said.replace(single, several, 1)
    return f"entries, each {said}"


def _range(form: Node) -> str:
    low, above = form.get("minimum"), form.get("exclusiveMinimum")
    high, below = form.get("maximum"), form.get("exclusiveMaximum")
    if low is not None and high is not None:
        return f" from {low:g} to {high:g}"
    lower = f"at least {low:g}" if low is not None else f"above {above:g}" if above is not None else ""
    upper = f"at most {high:g}" if high is not None else f"below {below:g}" if below is not None else ""
    ends = " and ".join(end for end in (lower, upper) if end)
    return f" {ends if ends.startswith(('above', 'below')) else 'of ' + ends}" if ends else ""
