"""From a model file, or a mapping, to a Model: every problem at once, each with its position."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from desim_warehouse.errors import ModelError, shown, spoken
from desim_warehouse.model.parse import Files, from_file, from_mapping
from desim_warehouse.model.schema import OUTLINE, Model, model_of

Source = Model | str | Path | Mapping[str, Any]
"""What public functions take for a model: it, its file, or its content."""


def as_model(source: Source, changes: Mapping[str, Any] | None = None) -> Model:
    """Return the model that a public function is given; a file that is read may run the user's own policies.

    Raises ModelError, also for a source of another type.
    """
    if isinstance(source, Model):
        return source.replace(changes, run_code=True) if changes else source
    if not isinstance(source, str | Path | Mapping):
        raise ModelError([f"{shown(source):.60}: expected a model, its file, or its content"])
    return load(source, changes, run_code=True)


def load(
    source: str | Path | Mapping[str, Any],
    overrides: Mapping[str, Any] | None = None,
    *,
    named: str = "override",
    run_code: bool = False,
    files: Files = "any",
) -> Model:
    """Read a model, and validate it.

    Args:
        source: a model file, or its content as a mapping.
        overrides: dotted keys and their values, such as `{"fleet.size": 3, "tasks.goods": [11, 8]}`, in any
            order: sections are set before what lies in them. An entry of a list is named by its rank, as in
            `fleet.start.0`, a parameter of a policy by its name, as in `policies.charging.margin`.
        named: how messages call an override. The command line says `--set`.
        run_code: import the user's own policies as well and ask them about their parameters. Without it none of
            their code is run, and what is wrong with them is found when they are made: by `simulate` or `check`.
        files: which files the model and the overrides may name: any of this machine; `beside`, those below the folder
            of the model file, links followed, for what comes from elsewhere; or none. It holds for tables, layouts,
            orders and policies of the user's own. Content given as a mapping has no folder: beside is none there.

    Returns:
        The model, complete by itself: tables it names are read here, relative to the model file.

    Raises:
        ModelError: with every problem of the file and the overrides, in the order of the file.
    """
    if files not in get_args(Files):
        raise ModelError([f"files {files!r:.60}: expected one of {spoken(get_args(Files), 'or')}"])
    if isinstance(source, Mapping):
        document = from_mapping(source, "<mapping>")
        document.files = "none" if files == "beside" else files
    else:
        document = from_file(Path(source), str(source), "a model with layout, fleet and tasks", OUTLINE)
        if document.kind == "study":
            raise ModelError([f"{source}: a study file, expected a model file; desim study {source} runs it"])
        document.files = files
    return model_of(document, overrides or {}, named, run_code=run_code)


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of model files, for editors."""
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return {**head, **copy.deepcopy(OUTLINE.schema), "title": "desim-warehouse model"}
