"""Which changes to a model can be simulated, and why can others not? Searches leave those out, and name them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any, TypeVar

from desim_warehouse.errors import StudyError, WarehouseError
from desim_warehouse.feasibility import errors
from desim_warehouse.findings import Finding
from desim_warehouse.model import Model
from desim_warehouse.study.factors import Label
from desim_warehouse.study.study import StudyEngine

S = TypeVar("S", bound=StudyEngine)
T = TypeVar("T")


@dataclass(frozen=True)
class NotTried:
    """Options that no run can simulate, and the reason: of the first of them, as further ones may differ in a number.

    `options`: the levels of each option by factor. `larger`: whether they come after all options that were tried.
    """

    options: tuple[Mapping[str, Label], ...]
    reason: str
    larger: bool


def refused(model: Model, overrides: Mapping[str, Any]) -> str | None:
    """Return why a changed model cannot be simulated; None if it can."""
    finding = _refusal(model, overrides)
    return None if finding is None else finding.text


def possible(
    model: Model,
    options: Sequence[T],
    changes: Callable[[T], Mapping[str, Any]],
    labels: Callable[[T], Mapping[str, Any]],
) -> tuple[list[T], tuple[NotTried, ...]]:
    """Divide the options of a search into those that can be simulated and those that cannot, with the reasons.

    Raises:
        StudyError: no option can be simulated.
    """
    refusals = [_refusal(model, changes(option)) for option in options]
    tried = [number for number, finding in enumerate(refusals) if finding is None]
    not_tried = []
    for code, group in groupby(range(len(options)), lambda number: _code(refusals[number])):
        numbers = list(group)
        if code is not None and (first := refusals[numbers[0]]) is not None:
            reason = "; ".join(filter(None, (first.text, first.cure)))
            larger = not tried or numbers[0] > tried[-1]
            not_tried.append(NotTried(tuple(labels(options[number]) for number in numbers), reason, larger))
    if not tried:
        raise StudyError(f"nothing that is searched can be simulated: {not_tried[0].reason}")
    return [options[number] for number in tried], tuple(not_tried)


def possible_part(study: S) -> tuple[S, tuple[NotTried, ...]]:
    """Return a study of those designs that can be simulated, and the other designs.

    Raises:
        StudyError: no design can be simulated.
    """
    points, not_tried = possible(
        study.plan.base, study.points, lambda point: point.overrides, lambda point: point.labels
    )
    if not not_tried:
        return study, ()
    plan, kept = study.plan, [point.number for point in points]
    factors = [
        replace(factor, levels=tuple(by_label[point.labels[factor.key]] for point in points))
        for factor in plan.factors
        for by_label in ({level.label: level for level in factor.levels},)
    ]
    each: dict[str, Any] = {
        name: tuple(values[number] for number in kept)
        for name in ("replications", "warm_up")
        if isinstance(values := getattr(plan, name), tuple)
    }
    return study.of(replace(plan, factors=tuple(factors), rule="paired", **each)), not_tried


def _refusal(model: Model, overrides: Mapping[str, Any]) -> Finding | None:
    """Return the first error with which a changed model is refused; None if it can be simulated."""
    try:
        changed = model.replace(overrides)
    except WarehouseError as error:
        return Finding("", "", str(error).splitlines()[0].removeprefix(f"model {model.name!r}: "))
    return next((finding for finding in errors(changed) if finding.code not in changed.accept), None)


def _code(finding: Finding | None) -> str | None:
    return None if finding is None else finding.code
