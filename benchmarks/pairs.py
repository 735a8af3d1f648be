"""Is this checkout slower than another? `python -m benchmarks.pairs OTHER [PAIRS]`: rows of `make bench` in turn.

Every pair runs the rows in a process of the other checkout and in one of this; both use this interpreter. A row's cost
is in bare SimPy timeouts of its own process, so that a clock that drifts disturbs little. The interval of the median
ratio is that of order statistics: with 95 % for any distribution (David and Nagaraja, Order Statistics,
section 7.1).
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from statistics import median

HERE = Path(__file__).parents[1]
PAIRS = 20
ROWS = """
from benchmarks import traffic
from benchmarks.traffic import cells, core
cells()
core("10 robots on 6 x 4, uncontended", 6, 4, 10, 30_000)
core("1,000 robots on 40 x 40, moderate density", 40, 40, 1000, 1_500, spread=True)
for robots in (40, 80, 120):
    core(f"{robots} robots on 6 x 4, contention", 6, 4, robots, 8_000)
getattr(traffic, "medium", traffic.whole)()  # version 0.1.0 has only the medium model
"""
CELLS = re.compile(r"^(.+?) {2,}([\d.]+) ms \(([\d,]+) timeouts/s\)", re.MULTILINE)
RATIO = re.compile(r"^(.+?) {2,}.* ratio ([\d.]+) ", re.MULTILINE)


def costs(checkout: Path) -> dict[str, float]:
    """Bare timeouts of every row of a checkout, by its name; for rows of moves: a move's."""
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    done = subprocess.run(  # noqa: S603 - a checkout that the caller named
        [sys.executable, "-c", ROWS], cwd=checkout, env=environment, capture_output=True, text=True, check=True
    )
    timeouts = {name: float(ms) / 1000 * float(rate.replace(",", "")) for name, ms, rate in CELLS.findall(done.stdout)}
    return timeouts | {name: 1 / float(ratio) for name, ratio in RATIO.findall(done.stdout)}


def interval(ratios: list[float]) -> tuple[float, float]:
    """The order statistics that enclose the median with at least 95 %."""
    from scipy.stats import binom

    first = int(binom.ppf(0.025, len(ratios), 0.5))  # the number of ratios below the interval, and above it
    ordered = sorted(ratios)
    return ordered[first - 1], ordered[-first]


def main() -> None:
    """Print every row's median cost in both checkouts, and the median of this one's over the other's, pair by pair."""
    other = Path(sys.argv[1]).resolve()
    pairs = int(sys.argv[2]) if len(sys.argv) > 2 else PAIRS
    if pairs < 6:
        raise SystemExit("at least 6 pairs: fewer give no 95 % interval of a median")
    measured: dict[str, list[tuple[float, float]]] = {}
    for number in range(pairs):
        order = (other, HERE) if number % 2 else (HERE, other)
        rows = {checkout: costs(checkout) for checkout in order}
        for name, cost in rows[HERE].items():
            measured.setdefault(name, []).append((rows[other][name], cost))
        print(f"pair {number + 1} of {pairs}", end="\r", file=sys.stderr, flush=True)
    print(f"{'in bare timeouts: the 30 cells, or a move':<46} {'other':>9} {'this':>9}  ratio (95 %)")
    for name, values in measured.items():
        ratios = [this / before for before, this in values]
        low, high = interval(ratios)
        before, this = (median(side) for side in zip(*values, strict=True))
        print(f"{name:<46} {before:>9,.2f} {this:>9,.2f}  {median(ratios):.3f} ({low:.3f} to {high:.3f})")


if __name__ == "__main__":
    main()
