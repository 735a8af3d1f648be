"""Golden logs: what runs of fixed models must give, row by row.

They say that nothing has changed, not that it is right. After a change of results that is meant,

    python -m tests.golden.make

writes them anew; look at the difference before it goes in, and tell it in CHANGELOG.md under "Results change".
"""

from __future__ import annotations

import csv
from pathlib import Path

import desim_warehouse as dw

HERE = Path(__file__).parent
MODELS = HERE.parent.parent / "models"
CASES = {
    # the paper's cell with 4 robots and goods group 2, with collisions
    "multibots": ("multibots.yaml", {"fleet.size": 4, "tasks.goods": [74, 50, 62, 15, 49, 34, 14, 72, 31, 37]}, 0),
    # a station and node times: 8 robots on a floor for 3
    "tutorial": ("tutorial.yaml", {"fleet.size": 8, "tasks.goods": [*range(12)], "traffic.node_time": 0.5}, 0),
}
RECIPE = "# golden: made by `python -m tests.golden.make`, which says when to make it anew\n"


def run(case):
    model, changes, seed = CASES[case]
    return dw.simulate(dw.load(MODELS / model, changes), seed)


def table(outcome):
    """The log as text: one list of fields a row, numbers in full."""
    return [["" if field is None else ">".join(field) if isinstance(field, tuple) else str(field) for field in row]
            for row in outcome.record.rows]  # fmt: skip


def make():
    for case in CASES:
        with (HERE / f"{case}.csv").open("w", encoding="utf-8", newline="") as file:
            file.write(RECIPE)
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["time", "kind", "robot", "task", "node", "edge", "value", "until", "other"])
            writer.writerows(table(run(case)))


if __name__ == "__main__":
    make()
