"""An answer as a pandas table, for `Answer.table`: a row for each option, with its numbers and their intervals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from desim_warehouse.answer.parts import AnswerData, Option
from desim_warehouse.answer.standing import WORDS

if TYPE_CHECKING:
    import pandas as pd

_BESIDE = {"same_as": str, "group": str, "p": float, "annual_cost": float}
"""Columns that are left out if they are empty for all options."""


def frame(answer: AnswerData) -> pd.DataFrame:
    """Make the table of an answer: a row for each option; columns of keys have _ instead of dots."""
    import pandas as pd

    rows = [_row(option) for option in answer.options]
    columns = list(dict.fromkeys(name for row in rows for name in row))
    empty = [name for name in _BESIDE if not any(row.get(name) not in {None, ""} for row in rows)]
    return pd.DataFrame(rows, columns=[name for name in columns if name not in empty])


def number_columns(name: str, mean: float | None, low: float | None, high: float | None) -> dict[str, float | None]:
    """Return the columns of a number and of the ends of its interval: `NAME`, `NAME_low`, `NAME_high`."""
    return {name: mean, f"{name}_low": low, f"{name}_high": high}


def _row(option: Option) -> dict[str, Any]:
    row: dict[str, Any] = {"design": option.name, "group": option.group}
    row |= {key.replace(".", "_"): value for key, value in option.set.items() if not isinstance(value, Mapping)}
    for number in option.numbers:
        row |= number_columns(number.of, number.mean, number.low, number.high)
    verdict = WORDS[option.standing] or option.instead
    return row | {
        "verdict": verdict,
        "p": option.p,
        "annual_cost": option.cost,
        "runs": option.runs,
        "same_as": ", ".join(option.same),
    }
