"""From a model file, or a mapping, to a Model: every problem at once, each with its place."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from desim_warehouse.errors import LayoutError, ModelError, got, nearest, reason
from desim_warehouse.model.flows import OrdersArrivals
from desim_warehouse.model.messages import Places, Problem, from_pydantic, report
from desim_warehouse.model.orders import problems_of
from desim_warehouse.model.overrides import override
from desim_warehouse.model.parse import Document, plain, read_yaml
from desim_warehouse.model.policy import KINDS
from desim_warehouse.model.schema import OUTLINE, Model
from desim_warehouse.model.tables import LAYOUT, resolve
from desim_warehouse.policies import catalogue
from desim_warehouse.values.fields import LIMITS


def load(
    source: str | Path | Mapping[str, Any],
    overrides: Mapping[str, Any] | None = None,
    *,
    named: str = "override",
    run_code: bool = False,
) -> Model:
    """Read a model and check it.

    Args:
        source: a model file, or its content as a mapping.
        overrides: dotted keys and their values, such as `{"fleet.size": 3, "tasks.goods": [11, 8]}`, in any
            order: sections are set before what lies in them. An entry of a list is named by its rank, as in
            `fleet.start.0`, a parameter of a policy by its name, as in `policies.charging.margin`.
        named: how messages call an override; the command line says `--set`.
        run_code: import the user's own policies as well and ask them about their parameters. Without it none of
            their code is run, and what is wrong with them is found when they are made: by `simulate` or `check`.

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
    return _made(document, overrides or {}, folder, named, run_code)


def changed(model: Model, overrides: Mapping[str, Any], run_code: bool) -> Model:
    """A copy of the model with overrides; see `Model.replace`."""
    return _made(_from_mapping(model.content(), f"model '{model.name}'"), overrides, Path(), "override", run_code)


def kind_of(data: Mapping[str, Any]) -> str | None:
    """What a file holds, by its keys: a model, a study, or None where that is unclear."""
    model, study = {"layout", "fleet", "tasks"} & data.keys(), {"model", "factors"} & data.keys()
    return None if bool(model) == bool(study) else "model" if model else "study"


def json_schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of model files, for editors."""
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return {**head, **copy.deepcopy(OUTLINE.schema), "title": "desim-warehouse model"}


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
        with path.open("rb") as file:
            content = file.read(LIMITS["bytes"][0] + 1)
    except FileNotFoundError:
        near = nearest(path.name, sorted(p.name for p in path.parent.glob("*.y*ml")))
        hint = f"; did you mean '{path.with_name(near)}'?" if near else ""
        raise ModelError([f"{name}: no such file, expected {kind} file{hint}"]) from None
    except (OSError, ValueError) as error:
        raise ModelError([f"{name}: cannot be read ({reason(error)}), expected {kind} file"]) from None
    if len(content) > LIMITS["bytes"][0]:
        raise ModelError([f"{name}: too large, expected {kind} file of at most {LIMITS['bytes'][0]:,} bytes"])
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
        raise ModelError([f"{document.places.of(()).text}: not a mapping (got {got(document.data)}), expected {whole}"])
    return document


def _made(document: Document, overrides: Mapping[str, Any], folder: Path, named: str, run_code: bool) -> Model:
    data, places, problems = document.data, document.places, document.problems
    problems += override(data, overrides, places, named)
    unread = resolve(data, folder, places)
    problems += unread
    _policy_files(data, folder)
    try:
        model = Model.model_validate(data)
    except ValidationError as error:
        missing = {problem.keys[:2] for problem in unread}  # what a table lacks says nothing about the model
        missing |= {("layout",)} if LAYOUT in missing else set()
        problems += [problem for problem in from_pydantic(error, OUTLINE) if problem.keys[:2] not in missing]
    else:
        if not problems:
            problems += check_policies(model, run_code)
            if not problems and any(isinstance(flow.when, OrdersArrivals) for flow in model.tasks.flows.values()):
                check_orders(model)
    if problems:
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
            policies[kind] = catalogue.resolved(named, folder)
        elif isinstance(named, dict) and isinstance(named.get("name"), str):
            named["name"] = catalogue.resolved(named["name"], folder)


def check_orders(model: Model) -> None:
    """Read the files of orders once; raises ModelError with what is wrong with them, by row and column."""
    try:
        found = problems_of(model, model.floor)
    except LayoutError:
        return  # which is said where the layout is checked
    if found:
        raise ModelError(found)


def check_policies(model: Model, run_code: bool = False) -> list[Problem]:
    """Whether the policies can be made with the parameters of the model; the user's own only with `run_code`."""
    return [
        Problem(("policies", kind, *([parameter] if parameter else ())), text)
        for kind, spec in model.policies.specs().items()
        if run_code or not spec.own
        for parameter, text in catalogue.problems(kind, spec.name, spec.params)
    ]
