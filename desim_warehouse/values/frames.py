"""Tables of pandas whose columns keep their types, whatever rows they have.

Pandas guesses types from values, so a column of text that is empty in one run would not be text there.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd


def typed(table: pd.DataFrame, columns: Mapping[str, type]) -> pd.DataFrame:
    """Return a table with columns of text (str), whole numbers (int) and numbers (float, NaN for None).

    Other columns stay as they are.
    """
    import pandas as pd

    types = {str: pd.Series(["text"]).dtype, int: "int64", float: "float64"}
    return table.astype({name: types[kind] for name, kind in columns.items()})
