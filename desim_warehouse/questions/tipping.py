"""Tipping points: the value of each uncertain input up to which a fleet is enough, and their answer in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.answer import words
from desim_warehouse.answer.answer import Answer, Answered
from desim_warehouse.answer.frame import number_columns
from desim_warehouse.answer.numbers import capital, number, plural
from desim_warehouse.answer.parts import Folded
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model import Source
from desim_warehouse.questions import judged
from desim_warehouse.questions.plan.sheet import CHANGES, GUESSES, OTHER_GUESSES
from desim_warehouse.study.designs.thresholds import InputThreshold, Thresholds, thresholds
from desim_warehouse.study.search import USUAL, Search

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class TippingPoints(Answered, Thresholds):
    """The threshold of each uncertain input up to which a fleet is enough: the result of `tipping_points`.

    Attributes:
        answer: the answer in words; shown by `print`.
        inputs: the threshold of each input.
        target: the target to meet.
        model: the warehouse with its fleet.
        runs: total number of runs simulated.
    """

    @property
    def table(self) -> pd.DataFrame:
        """A row for each input.

        Columns: input (its key), lowest and highest (the range), enough_at_lowest, enough_at_highest, threshold with
        `_low` and `_high` (nan without a threshold), confirmed.
        """
        import pandas as pd

        return pd.DataFrame(
            {
                "input": threshold.key,
                "lowest": threshold.low,
                "highest": threshold.high,
                "enough_at_lowest": threshold.enough[0],
                "enough_at_highest": threshold.enough[1],
                **number_columns("threshold", threshold.at, *(threshold.within or (None, None))),
                "confirmed": threshold.confirmed,
            }
            for threshold in self.inputs
        )

    def in_short(self) -> str:
        """Return the inputs and their thresholds in a few words."""
        return ", ".join(
            f"{threshold.key} {'no threshold' if threshold.at is None else f'{threshold.at:g}'}"
            for threshold in self.inputs
        )


def tipping_points(
    model: Source, target: str, uncertain: Mapping[str, tuple[float, float]], *, search: Search = USUAL
) -> TippingPoints:
    """Find the value of each input up to which the fleet of a model is enough, with all other inputs unchanged.

    Args:
        model: the warehouse, with its robots and chargers.
        target: such as "on_time >= 95 %".
        uncertain: key of the model -> its lowest and highest value, in the units of the model.
        search: settings of runs, at most 60 for each input, and the folder that keeps the answer.

    Returns:
        The threshold of each input with its interval, and the answer in words; see `TippingPoints`.

    Raises:
        StudyError: no range, a bad target, too few runs, or an end of a range at which nothing can be simulated.
    """
    searched = thresholds(model, target, uncertain, search=search)
    return TippingPoints(**vars(searched), answer=_answer(searched).keep(search.out, search.command))


def with_thresholds(answer: Answer, points: TippingPoints) -> Answer:
    """Return the answer of a plan with the thresholds of its fleet added."""
    facts = {"answer": list(points.answer.answer), **_facts(points), "runs": points.runs}
    lines, runs = (*answer.answer, *points.answer.answer), answer.runs + points.runs
    tables = tuple(_beside(table, points) if table.title == CHANGES else table for table in answer.tables)
    return Answer(**{**dict(answer), "answer": lines, "tables": tables, "runs": runs, "uncertain": facts})


def _beside(changes: Folded, points: TippingPoints) -> Folded:
    """Return a plan's table of changes with the thresholds of inputs added."""
    units = points.model.units
    tried = [
        (_from_to(threshold, unit := words.factor_unit(threshold.key, units)), _known(points, threshold, unit))
        for threshold in points.inputs
    ]
    rest = [(OTHER_GUESSES, text) if what == GUESSES else (what, text) for what, text in changes.rows]
    return changes.model_copy(update={"rows": (*tried, *rest)})


def _answer(searched: Thresholds) -> Answer:
    """Return the answer, with a sentence for each input."""
    model, size = searched.model, searched.model.fleet.size
    fleet = number_of(size, "robot")
    keys = spoken([words.in_words(threshold.key) for threshold in searched.inputs])
    return Answer(
        kind="tipping",
        name=model.name,
        description=model.description,
        question=f"For which {keys} {_is(size)} {fleet} enough: {words.target(searched.target)}?",
        answer=tuple(_input(searched, threshold) for threshold in searched.inputs),
        about=judged.about(fleet, model, searched.seed),
        promise="Each interval holds with 95 % confidence, all else as in the model.",
        runs=searched.runs,
        confidence=0.95,
        made={"seed": str(searched.seed), "model": model.digest()},
        **_facts(searched),
    )


def _facts(searched: Thresholds) -> dict[str, Any]:
    """Return the thresholds for JSON."""
    return {
        "robots": searched.model.fleet.size,
        "inputs": {
            threshold.key: {
                "low": threshold.low,
                "high": threshold.high,
                "enough": list(threshold.enough),
                "at": threshold.at,
                "interval": None if threshold.within is None else list(threshold.within),
                "confirmed": threshold.confirmed,
            }
            for threshold in searched.inputs
        },
    }


def _input(searched: Thresholds, threshold: InputThreshold) -> str:
    """Return the line on an input, as in `Load time, 5 to 20 s: 5 robots are enough up to 10.6 s (7.92 to 13.9)`."""
    unit = words.factor_unit(threshold.key, searched.model.units)
    return f"{_from_to(threshold, unit)}: {_known(searched, threshold, unit)}."


def _from_to(threshold: InputThreshold, unit: str) -> str:
    return f"{capital(words.in_words(threshold.key))}, {_value(threshold.low)} to {_value(threshold.high, unit)}"


def _known(searched: Thresholds, threshold: InputThreshold, unit: str) -> str:
    return f"{'' if threshold.confirmed else 'perhaps '}{_enough(searched, threshold, unit)}"


def _enough(searched: Thresholds, threshold: InputThreshold, unit: str) -> str:
    size = searched.model.fleet.size
    robots = f"{number_of(size, 'robot')} {_is(size)}"
    if threshold.at is None or threshold.within is None:
        return f"{robots} {'enough' if all(threshold.enough) else 'too few'} at both ends"
    side = "up to" if threshold.enough[0] else "from"
    low, high = threshold.within
    return f"{robots} enough {side} {_value(threshold.at, unit)} ({_value(low)} to {_value(high)})"


def _is(robots: int) -> str:
    return "is" if robots == 1 else "are"


def _value(value: float, unit: str = "") -> str:
    return f"{number(float(f'{value:.3g}'))}{f' {plural(unit, value)}' if unit else ''}"
