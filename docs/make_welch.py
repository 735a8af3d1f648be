"""Welch's plot of docs/how-to/how-long.md: `python docs/make_welch.py`."""

from __future__ import annotations

from pathlib import Path

import desim_warehouse as dw
from desim_warehouse.study.warm_up import settle

ROOT = Path(__file__).resolve().parent.parent


def main() -> None:
    """Draw the cycle times of the tutorial's warehouse over two hours, with 20 tasks open at all times."""
    model = dw.load(ROOT / "models" / "tutorial.yaml", {"tasks.goods": {"saturated": 20}, "run.length": 7200})
    axes = dw.plot.welch(settle(model, replications=5, observed="cycle_time"))
    path = ROOT / "docs" / "pictures" / "welch.png"
    axes.figure.savefig(path, dpi=100)
    print(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
