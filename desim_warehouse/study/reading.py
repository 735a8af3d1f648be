"""From a study file, or from arguments, to a plan: all problems at once, each with its position.

For `desim study`, `desim what-if` and `Study`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from desim_warehouse.errors import ModelError, StudyError
from desim_warehouse.model import UNSET, Model, load
from desim_warehouse.model.messages import FilePositions, Keys, Problem, from_pydantic, moved, report
from desim_warehouse.model.parse import Document, from_file, plain
from desim_warehouse.outcome.indicators import refuse_unknown
from desim_warehouse.outcome.targets import parse_target
from desim_warehouse.policies.catalogue import resolved_in
from desim_warehouse.study.file import OUTLINE, StudyFile, Until, labels
from desim_warehouse.study.plan import StudyPlan, models
from desim_warehouse.study.warm_up import steady_length


def read_study(path: str | Path, overrides: Mapping[str, Any] | None = None, *, named: str = "override") -> StudyPlan:
    """Read a study file, with its model and its designs, into a plan.

    Args:
        path: the file.
        overrides: further changes to the model, for all runs. They win over the file's `set`.
        named: how messages call an override. The command line says `--set`.

    Raises:
        ModelError: with every problem of the study, its model and its designs.
    """
    document = from_file(Path(path), str(path), "a study with model and factors", OUTLINE)
    if document.kind == "model":
        takers = f"desim run {path} simulates it, desim what-if and desim best vary it with --vary"
        raise ModelError([f"{path}: a model file, expected a study file; {takers}"])
    data, folder = document.data, Path(path).parent
    for part in ("set", "factors"):
        if part in data:
            data[part] = resolved_in(data[part], folder)
    changes = data.get("set") or {}
    if overrides and isinstance(changes, Mapping):
        data["set"] = {**changes, **overrides}
        for key in overrides:
            document.positions.given(("set", key), f"{named} {key}")
    data.setdefault("name", Path(path).stem)
    if isinstance(data.get("model"), str):
        data["model"] = folder / data["model"]
    return _plan(document)


def plan_of(
    base: str | Path | Mapping[str, Any] | Model,
    content: Mapping[str, Any],
    options: Mapping[Keys, str] | None = None,
) -> StudyPlan:
    """Make the plan of a study from arguments.

    Args:
        base: a model, its file, or its content.
        content: the keys of a study file but `model`.
        options: where keys were given on the command line, and how messages name them.

    Raises:
        ModelError: with every problem of the study, its model and its designs.
    """
    problems: list[Problem] = []
    set_content = content.get("set")
    changes = dict(set_content) if isinstance(set_content, Mapping) else {}
    gone = {key: changes.pop(key) for key, value in list(changes.items()) if value is UNSET}
    stated = {**content, "set": changes} if gone else content
    data = plain({key: value for key, value in stated.items() if value is not None}, (), problems)
    if gone:
        data["set"] |= gone
    positions = FilePositions(str(data.get("name", "study")) if options else "study")
    for keys, option in (options or {}).items():
        positions.given(keys, option)
    return _plan(Document({"name": "study", **data, "model": base}, positions, problems))


def _plan(document: Document) -> StudyPlan:
    """Make the plan of a study document; raises ModelError for problems of the study, its model or its designs."""
    problems, positions = document.problems, document.positions
    data = {key: value for key, value in document.data.items() if value is not None}
    file, base = None, None
    try:
        file = StudyFile.model_validate(data)
    except ValidationError as error:
        problems += from_pydantic(error, OUTLINE)
    lines = []
    changes = data.get("set", {})
    try:
        if not any(problem.keys[:1] in {("model",), ("set",)} for problem in problems):
            base = _base(data["model"], changes)
    except ModelError as error:
        lines = [_in_set(text, changes, positions) for text in error.problems]
    if file is None or base is None or problems:
        raise ModelError([*report(problems, positions), *lines])
    plan = StudyPlan(
        base,
        file.varied(),
        file.design,
        file.replications,
        file.seed,
        file.indicators,
        labels(file.baseline) or None,
        file.confidence,
        file.timeout,
        file.name,
        file.description,
        file.warm_up,
        file.target,
    )
    made = models(plan, plan.points(), positions, run_code=True)
    if plan.warm_up:
        for model in made.values():
            _has_steady_state(model, positions)
    _can_have(plan, made.values(), positions)
    return plan


def _can_have(plan: StudyPlan, among: Collection[Model], positions: FilePositions) -> None:
    """Refuse flows and parts of the day, of the indicators that the study asks for, that no design has."""
    rule = plan.replications
    asked: list[tuple[Keys, str]] = [(("indicators",), name) for name in plan.indicators]
    asked += [(("target",), parse_target(plan.target).indicator)] if plan.target else []
    asked += [(("replications", "indicator"), rule.indicator)] if isinstance(rule, Until) else []
    for keys, name in asked:
        try:
            refuse_unknown(name, among)
        except StudyError as error:
            raise ModelError([f"{positions.line(keys)[1]}: {error}"]) from None


def _has_steady_state(model: Model, positions: FilePositions) -> None:
    try:
        steady_length(model)
    except StudyError as error:
        raise ModelError([f"{positions.line(('warm_up',))[1]}: {error}"]) from None


def _base(source: str | Path | Mapping[str, Any] | Model, changes: Mapping[str, Any]) -> Model:
    """Read the model that the study varies. Studies need no more than indicators, so little is logged."""
    changes = {"log": "tasks", **changes}
    if isinstance(source, Model):
        return source.replace(changes, run_code=True)
    return load(source, changes, named="set", run_code=True)


def _in_set(text: str, changes: Mapping[str, Any], positions: FilePositions) -> str:
    """Report a problem of the model at the key of `set` that causes it, if one does."""
    for key in sorted(changes, key=len, reverse=True):
        if message := moved(text, f"set {key}", positions.line(("set", key))[1]):
            return message
    return text
