"""The throughput curve of the medium model over fleet size, with its knee: `python docs/make_throughput.py`.

Each fleet works for an hour, the first 20 minutes not counted, three times with different seeds; bays and stations
have room for all robots, so that what bounds the curve is traffic.
"""

from __future__ import annotations

from pathlib import Path

import desim_warehouse as dw

ROOT = Path(__file__).resolve().parent.parent
SIZES = (25, 50, 75, 100, 125, 150, 175, 200, 250, 300, 350, 400, 500)


def main() -> None:
    """Run the study and draw its table."""
    study = dw.Study(
        ROOT / "models" / "medium.yaml",
        {"fleet.size": SIZES},
        replications=3,
        changes={
            "layout.bays.parking.places": 20,
            "layout.stations.packing.places": 120,
            "tasks.goods": {"saturated": 1000},
            "run.length": 3600,
            "run.warm_up": 1200,
        },
        name="throughput of the medium warehouse",
    )
    study.run(workers=2)
    axes = dw.plot.throughput(study.table, model=dw.load(ROOT / "models" / "medium.yaml"))
    path = ROOT / "docs" / "pictures" / "throughput.png"
    axes.figure.savefig(path, dpi=110)
    print(path.relative_to(ROOT))
    shown = ["fleet.size", "throughput_per_hour", "share_waiting", "rotations"]
    print(study.table.groupby("fleet.size", as_index=False)[shown[1:]].mean().round(3).to_string(index=False))


if __name__ == "__main__":
    main()
