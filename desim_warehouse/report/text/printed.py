"""Numbers, means and differences as commands print them, and pages too: the same to the digit."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from desim_warehouse.study.statistics import Difference, Estimate

VERDICTS = {True: "differs", False: "not shown to differ", None: "cannot be tested (one run)"}
"""By `Difference.differs`."""


class PrintedDifference(NamedTuple):
    """A difference between two designs: its mean, the ends of its interval, p-value and verdict."""

    difference: str
    low: str
    high: str
    p: str
    verdict: str


def number(value: float) -> str:
    """Four significant digits."""
    if value == int(value) and abs(value) < 1e6:  # noqa: PLR2004 - counts are shown whole
        return f"{value:,.0f}"
    return f"{value:,.1f}" if abs(value) >= 1000 else f"{value:.4g}"  # noqa: PLR2004


def said(found: Estimate | None) -> str:
    """An estimate in a table; shares of tasks in per cent, with the ends of their interval."""
    from desim_warehouse.report.text.words import share_text  # loads slowly

    if found is None:
        return "-"
    if found.of_all is not None:
        from desim_warehouse.report.text.words import share_text  # the words need the model, which help texts do not

        return share_text(found)
    if found.half_width is None:
        return number(found.mean)
    return f"{number(found.mean)} ± {number(found.half_width)}"


def difference(found: Difference) -> PrintedDifference:
    """A paired difference in a table."""
    interval = found.estimate.interval
    ends = ("exact", "") if found.estimate.deterministic else ("-", "-")
    return PrintedDifference(
        number(found.estimate.mean),
        *((number(interval[0]), number(interval[1])) if interval else ends),
        "-" if found.p_adjusted is None else f"{found.p_adjusted:.3g}",
        VERDICTS[found.differs] + (f" ({found.missing} pairs missing)" if found.missing else ""),
    )
