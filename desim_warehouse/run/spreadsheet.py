"""Tables as CSV that are safe to open in a spreadsheet: no text is taken for a formula.

For the files of `desim run`, `export` and `paper`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd

FORMULA = ("=", "+", "-", "@", "\t")
"""What a cell begins with that spreadsheets take for a formula (OWASP, CSV Injection)."""


def as_csv(table: pd.DataFrame, *, index: bool = False, **how: Any) -> str:
    """Write a table as CSV; text that looks like a formula gets a ' before it, numbers stay numbers.

    `how`: further arguments of `DataFrame.to_csv`.
    """
    if index:
        table = table.reset_index()
    safe = table.rename(columns=_safe)
    for column, kind in enumerate(safe.dtypes):
        if kind.kind not in "biuf":
            safe.isetitem(column, [_safe(cell) for cell in safe.iloc[:, column]])
    return str(safe.to_csv(None, index=False, lineterminator="\n", **how))


def _safe(cell: Any) -> Any:
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(FORMULA) else cell
