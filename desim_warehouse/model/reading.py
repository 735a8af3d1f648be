"""From a model file, or a mapping, to a Model: every problem at once, each with its place."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from desim_warehouse.errors import ModelError, reason
from desim_warehouse.model import outline
from desim_warehouse.model.checks import check, check_policies
from desim_warehouse.model.overrides import override
from desim_warehouse.model.parse import Document, plain, read_yaml
from desim_warehouse.model.places import Keys, Places
from desim_warehouse.model.policy import KINDS
from desim_warehouse.model.problems import Problem, from_pydantic, got, report
from desim_warehouse.model.schema import Model
from desim_warehouse.model.tables import resolve
from desim_warehouse.policies.catalogue import resolved


def load(
    source: str | Path | Mapping[str, Any],
    overrides: Mapping[str, Any] | None = None,
    *,
    named: str = "override",
) -> Model:
    """Read a model and check it.

    Args:
        source: a model file, or its content as a mapping.
        overrides: dotted keys and their values, such as `{"fleet.size": 3, "tasks.goods": [11, 8]}`, in any
            order: sections are set before what lies in them. An entry of a list is named by its rank, as in
            `fleet.start.0`, a parameter of a policy by its name, as in `policies.charging.margin`.
        named: how messages call an override; the command line says `--set`.

    Returns:
        The model, complete by itself: tables it names are read here, relative to the model file.

    Raises:
        ModelError: with every problem of the file and the overrides, in the order of the file.
    """
    if isinstance(source, Mapping):
        document, folder = _from_mapping(source, "<mapping>"), Path()
    else:
        document = read_document(Path(source), str(source), "a model with layout, fleet and tasks")
        if kind_of(document.data) == "study":
            raise ModelError([f"{source}: a study file, expected a model file; desim study {source} runs it"])
        folder = Path(source).parent
    return _made(document, overrides or {}, folder, named)


def changed(model: Model, overrides: Mapping[str, Any]) -> Model:
    """A copy of the model with overrides; see `Model.replace`."""
    return _made(_from_mapping(model.content(), f"model '{model.name}'"), overrides, Path(), "override")


def kind_of(data: Mapping[str, Any]) -> str | None:
    """What a file holds by its keys: a model, a study, or what cannot be told."""
    model, study = {"layout", "fleet", "tasks"} & data.keys(), {"model", "factors"} & data.keys()
    return None if bool(model) == bool(study) else "model" if model else "study"


def json_schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of model files, for editors."""
    return copy.deepcopy(outline.schema())


def _from_mapping(source: Mapping[str, Any], name: str) -> Document:
    problems: list[Problem] = []
    return Document(plain(source, (), problems), Places(name), problems)


def read_document(path: Path, name: str, whole: str) -> Document:
    """Read a file whose top level is a mapping.

    Args:
        path: the file.
        name: what messages call it.
        whole: what it should hold, such as "a model with layout, fleet and tasks".

    Raises:
        ModelError: where there is no such file, or it cannot be read.
    """
    kind = " ".join(whole.split()[:2])
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        near = outline.nearest(path.name, sorted(p.name for p in path.parent.glob("*.y*ml")))
        hint = f"; did you mean '{path.with_name(near)}'?" if near else ""
        raise ModelError([f"{name}: no such file, expected {kind} file{hint}"]) from None
    except (OSError, ValueError) as error:
        raise ModelError([f"{name}: cannot be read ({reason(error)}), expected {kind} file"]) from None
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = content[: error.start]
        line, column = before.count(b"\n") + 1, error.start - before.rfind(b"\n")
        wrong = f"not UTF-8 text (got byte 0x{content[error.start]:02x}), expected the file to be saved as UTF-8"
        raise ModelError([f"{name}:{line}:{column}: {wrong}"]) from None
    document = read_yaml(text, name)
    if document.data is None:
        raise ModelError([f"{name}:1:1: nothing in the file, expected {whole}"])
    if not isinstance(document.data, dict):
        raise ModelError([f"{document.places.of(()).said}: not a mapping (got {got(document.data)}), expected {whole}"])
    return document


def _made(document: Document, overrides: Mapping[str, Any], folder: Path, named: str) -> Model:
    data, places, problems = document.data, document.places, document.problems
    problems += override(data, overrides, places, named)
    problems += resolve(data, folder, places)
    _policy_files(data, folder)
    model, found = _validated(data, [problem.keys for problem in problems])
    problems += found
    if model is None or problems:
        if not places.values:
            places.number(data)
        raise ModelError(report(problems, places))
    return model


def _policy_files(data: dict[str, Any], folder: Path) -> None:
    """Write the paths of the user's own policies in full: the model is then the same wherever it is used."""
    policies = data.get("policies")
    if not isinstance(policies, dict):
        return
    for kind in KINDS:
        named = policies.get(kind)
        if isinstance(named, str):
            policies[kind] = resolved(named, folder)
        elif isinstance(named, dict) and isinstance(named.get("name"), str):
            named["name"] = resolved(named["name"], folder)


def _validated(data: dict[str, Any], wrong: list[Keys]) -> tuple[Model | None, list[Problem]]:
    """The model, if one can be made, and its problems; what depends on wrong values is not checked."""
    problems: list[Problem] = []
    for _ in range(3):
        try:
            model = Model.model_validate(data)
        except ValidationError as error:
            found = from_pydantic(error)
            problems += found
            data = mended(data, [tuple(item["loc"]) for item in error.errors()])
        else:
            meant = [tuple(problem.meant.split(".")) for problem in problems]
            problems += check(model, [*wrong, *meant, *(problem.keys for problem in problems)])
            if not problems:
                problems += [Problem(tuple(key.split(".")), text) for key, text in check_policies(model)]
            return model, problems
    return None, problems


_ANY: dict[Any, Any] = {
    "name": "",
    "description": "",
    "units": {},
    "layout": {
        "blocks": {
            "columns": 1,
            "rows": 1,
            "block_depth": 1,
            "goods_size": 1,
            "aisle_width": 1,
        },
    },
    "fleet": {"size": 1, "robot": {"radius": 1, "speed": 1}},
    "tasks": {"goods": [0], "unload_at": ["A"], "load_time": 0, "unload_time": 0},
    "battery": {"capacity": 1, "threshold": 0, "consumption": 0, "charge_rate": 1},
    "traffic": {},
    "policies": {},
    "run": {},
    "cost": {},
}
"""Valid values for what must be there."""


def mended(data: dict[str, Any], wrong: Iterable[Keys]) -> dict[str, Any]:
    """A copy with wrong values left out, or replaced by valid ones, so that the others can be checked."""
    made = copy.deepcopy(data)
    for keys in wrong:
        section: dict[Any, Any] = made
        spare, key = _ANY, keys[0]
        for below in keys[1:]:
            if not isinstance(section.get(key), dict) or not isinstance(spare.get(key), dict):
                break
            section, spare, key = section[key], spare[key], below
        section.pop(key, None)
        if key in spare:
            section[key] = copy.deepcopy(spare[key])
    return made
