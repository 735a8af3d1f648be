"""Do the paper's three findings hold elsewhere? `python -m benchmarks.robustness [FOLDER]` reads it from a study.

First `desim study studies/paper_robustness.yaml --workers 2 --out reports/out/paper_robustness`. A robot more is
compared with a robot fewer list by list; a difference counts where its 95 % interval excludes 0. Fleets of which a
robot ran flat with some list are left out.
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

    Values = dict[int, list[float]]

FOLDER = Path(__file__).parents[1] / "reports/out/paper_robustness"
FEW, PAPER, MANY = 1, 6, 18


def surely(values: Values, sign: int) -> list[int]:
    """The fleets in which an indicator surely grew (`sign` 1) or fell (-1) by the last robot."""
    fleets = []
    for robots in list(values)[1:]:
        gain = paired(values[robots], values[robots - 1]).interval
        if gain is not None and min(sign * gain[0], sign * gain[1]) > 0:
            fleets.append(robots)
    return fleets


def line(rows: pd.DataFrame) -> str:
    """The cells of one setting."""
    fleets = [part for _, part in rows.groupby("fleet.size") if part["error"].isna().all()]
    times, counts, waits = (
        {int(part["fleet.size"].iloc[0]): part[key].tolist() for part in fleets} for key in ("T", "S", "waiting")
    )
    most = max(times)
    shares = [estimate([100 * w / (n * t) for w, t in zip(waits[n], times[n], strict=True)]) for n in (PAPER, most)]
    return " | ".join(
        (
            str(most),
            *(f"{estimate(times[n]).mean:,.0f}" for n in (FEW, PAPER, most)),
            f"{len(surely(times, -1))} of {most - 1}",
            f"{len(surely(times, 1))}",
            *(f"{estimate(counts[n]).mean:.1f}" for n in (PAPER, most)),
            f"{len(surely(counts, 1))} of {most - 1}",
            *(f"{share.mean:.1f} ± {share.half_width:.1f}" for share in shares),
        )
    )


def main() -> None:
    """Print the table."""
    table = dw.Results.load(sys.argv[1] if len(sys.argv) > 1 else FOLDER).table
    print("| angle | handling | most robots | T of 1 | of 6 | of most | falls | rises", end=" | ")
    print("S of 6 | of most | rises | waiting of 6, % | of most, % |")
    print("|---|---" + "|---:" * 11 + "|")
    for (angle, handling), rows in table.groupby(["traffic.collision_angle", "handling"], sort=False):
        print(f"| {angle:g} | {handling} | {line(rows)} |")


if __name__ == "__main__":
    main()
