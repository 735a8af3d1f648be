"""What has an answer: it is worded by the question that found it, which stands above and says so once."""

from __future__ import annotations

from functools import singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from desim_warehouse.answer.answer import Answer

if TYPE_CHECKING:
    A = TypeVar("A", bound="Answered")


@singledispatch
def answer_of(found: Any) -> Answer:
    """The answer of what a search found; each question registers its words.

    Raises:
        TypeError: nobody words it.
    """
    raise TypeError(f"{type(found).__name__} answers no question; import desim_warehouse.questions")


class Answered:
    """What a search found: its answer is what the terminal prints, and pages and Jupyter show."""

    @property
    def answer(self) -> Answer:
        """The same for people."""
        return answer_of(self)

    def _repr_html_(self) -> str:
        """The page of the answer in a frame."""
        return self.answer._repr_html_()


def with_answer(found: A, out: str | Path | None) -> A:
    """What a search found; its answer is kept in the folder `out`, from which `desim report` has its page."""
    if out is not None and Path(out).is_dir():
        found.answer.save(out)
    return found
