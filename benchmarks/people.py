"""Are one-way streets more predictable with people? `python -m benchmarks.people [FOLDER]` reads it from a study.

First `desim study studies/people.yaml --workers 2 --out reports/out/people`. Every day is driven on both kinds of
streets, with the same tasks and the same people, so they are compared day by day.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import desim_warehouse as dw
from desim_warehouse.study.statistics import estimate, paired

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


def value(form: str, values: list[float]) -> str:
    """A mean with its interval."""
    found = estimate(values)
    return f"{form.format(found.mean)} ± {form.format(found.half_width)}"


def difference(form: str, one: list[float], two: list[float]) -> str:
    """How much more two-way streets have, with its interval; in brackets where it may be nothing."""
    found = paired(two, one)
    assert found.interval is not None
    text = f"{form.format(found.mean)} ± {form.format(found.half_width)}"
    return text if min(found.interval) > 0 or max(found.interval) < 0 else f"({text})"


def rows(table: pd.DataFrame) -> list[str]:
    """A row for each number of visits, routing policy and indicator."""
    found = []
    for (visits, routing), part in table.groupby([VISITS, ROUTING], sort=False):
        one, two = (part[part["streets"] == kind].sort_values("replication") for kind in ("one-way", "two-way"))
        for name, form in SHOWN.items():
            a, b = one[name].tolist(), two[name].tolist()
            cells = (visits, routing, f"`{name}`", value(form, a), value(form, b), difference(form, a, b))
            found.append(f"| {' | '.join(map(str, cells))} |")
    return found


def main() -> None:
    """Print the table."""
    table = dw.Results.load(sys.argv[1] if len(sys.argv) > 1 else FOLDER).table
    print("| visits an hour | routing | indicator | one-way | two-way | two-way - one-way |")
    print("|---:|---|---|---:|---:|---:|")
    print("\n".join(rows(table)))


if __name__ == "__main__":
    main()
