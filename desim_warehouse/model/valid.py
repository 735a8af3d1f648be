"""The values of a document as a part of the schema, or every problem with its position."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from pydantic import ValidationError

from desim_warehouse.errors import ModelError
from desim_warehouse.model.messages import from_pydantic, report
from desim_warehouse.values.fields import Known, Part

if TYPE_CHECKING:
    from desim_warehouse.model.messages import Outline
    from desim_warehouse.model.parse import Document

Whole = TypeVar("Whole", bound=Part)


def valid(document: Document, kind: type[Whole], outline: Outline) -> Whole:
    """What a document says, checked.

    Args:
        document: its values, and what is wrong with them so far.
        kind: what it should hold.
        outline: the keys that it can have.

    Raises:
        ModelError: with every problem, in the order of the file.
    """
    problems = list(document.problems)
    try:
        found = kind.model_validate(document.data, context=Known())
    except ValidationError as error:  # what a table lacks says nothing about the model
        problems += [item for item in from_pydantic(error, outline) if item.keys[:2] not in document.unread]
    if problems:
        raise ModelError(report(problems, document.positions))
    return found
