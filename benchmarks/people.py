"""Are one-way streets more predictable with people? `python -m benchmarks.people [FOLDER]` reads it from a study.

First `desim study studies/people.yaml --workers 2 --out reports/out/people`. Every day is driven on both kinds of
streets, with the same tasks and the same people, so they are compared day by day.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import desim_warehouse as dw
from desim_warehouse.study.statistics.comparison import paired
from desim_warehouse.study.statistics.intervals import estimate

if TYPE_CHECKING:
    import pandas as pd

FOLDER = Path(__file__).parents[1] / "reports/out/people"
VISITS, ROUTING = "people.pickers.per_hour", "policies.routing"
SHOWN = {
    "cycle_time_mean": "{:.1f}",
    "cycle_time_median": "{:.1f}",
    "cycle_time_p95": "{:.0f}",
    "cycle_time_cv": "{:.2f}",
    "encounters_per_hour": "{:.1f}",
    "share_waiting_person": "{:.3f}",
    "shared_time": "{:.3f}",
}


def difference(form: str, one: list[float], two: list[float]) -> str:
    """How much more two-way streets have, with its interval; in brackets where it may be nothing."""
    gap = paired(two, one)
    assert gap.interval is not None
    text = f"{form.format(gap.mean)} ± {form.format(gap.half_width)}"
    return text if min(gap.interval) > 0 or max(gap.interval) < 0 else f"({text})"


def rows(table: pd.DataFrame) -> list[list[str]]:
    """A row for each indicator: its mean on one-way streets, and the gap to two-way ones, by visits and routing."""
    parts = table.groupby([VISITS, ROUTING], sort=False)
    lines = [["one-way, and two-way - one-way", *(f"{visits}, {routing}" for (visits, routing), _ in parts)]]
    for name, form in SHOWN.items():
        cells = [f"`{name}`"]
        for _, part in parts:
            one, two = (part[part["streets"] == kind].sort_values("replication") for kind in ("one-way", "two-way"))
            a, b = one[name].tolist(), two[name].tolist()
            cells.append(f"{form.format(estimate(a).mean)}, {difference(form, a, b)}")
        lines.append(cells)
    return lines


def main() -> None:
    """Print the table."""
    heads, *cells = rows(dw.Results.load(sys.argv[1] if len(sys.argv) > 1 else FOLDER).table)
    for row in (heads, ["---", *["---:"] * (len(heads) - 1)], *cells):
        print(f"| {' | '.join(row)} |")


if __name__ == "__main__":
    main()
