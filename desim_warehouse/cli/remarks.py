"""What became of a layout on its way from one program to another, as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.cli.tables import sheet, show

if TYPE_CHECKING:
    from collections.abc import Iterable

    from desim_warehouse.plants import Remark

_NAMED = 12  # in a row


def show_remarks(remarks: Iterable[Remark], *, err: bool = False) -> None:
    """Print remarks, a row for each."""
    table = sheet(None, "", "what", "why", "which", pad_edge=False)
    for remark in remarks:
        number = len(remark.names)
        kind = remark.kind if remark.what == "assumed" else counted(number, remark.kind)
        table.add_row(remark.what, kind, remark.why, remark.which(_NAMED))
    show(table, err=err, markup=False)


def counted(number: int, kind: str) -> str:
    """A number of things, in words: `2 robots`."""
    return f"{number} {kind}{'s' * (number != 1)}"
