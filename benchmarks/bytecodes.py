"""Work of a run in bytecodes of Python, which no clock disturbs: `python -m benchmarks.bytecodes [OTHER]`.

With another checkout the counts of both and their ratio are printed. What runs in C, such as NumPy, is not counted.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

HERE = Path(__file__).parents[1]
DRAFT = "benchmarks/models_0_2/draft.yaml"
OVERLOADED = {"tasks.goods": {"poisson": "800 / h"}}
FULL = {
    "fleet.size": 40,
    "layout.bays.parking.places": 8,
    "tasks.goods": {"poisson": "600 / h"},
    "run.length": 3600,
    "run.warm_up": 0,
}
HOURS = {
    "fleet.size": 14,
    "layout.bays.parking.places": 4,
    "calendars": {"day": {"open": ["00:00-08:00"]}},
    "layout.stations.packing": {"at": ["U"], "places": 2, "hours": "day"},
    "tasks.goods": {"poisson": "5300 / h"},
    "run.length": 200,
    "run.warm_up": 0,
}
RUNS: dict[str, tuple[str, dict[str, Any]]] = {
    "a cell: 6 robots of models/multibots.yaml": ("models/multibots.yaml", {"fleet.size": 6}),
    "draft: 2 h of 12 robots, 200 orders an hour": (DRAFT, {"run.length": 7200}),
    "draft: the same with 800 orders an hour": (DRAFT, {**OVERLOADED, "run.length": 7200}),
    "draft: 1 h of 40 robots, all stations full": (DRAFT, FULL),
    "draft: 200 s of 5,300 orders an hour, in hours": (DRAFT, HOURS),
    "medium: 900 s of models/medium.yaml": ("models/medium.yaml", {"run.length": 900, "run.warm_up": 200}),
}
DRAFTS = {
    "today": ("--size", "60x40", "--aisles", "8", "--stations", "3", "--orders", "200/h", "--due", "5"),
    "day": (
        *("--size", "70x45", "--orders", "420/h", "--shifts", "06-22", "--peak", "11:30-13x1.6"),
        *("--packers", "auto", "--due", "15", "--stations", "2"),
    ),
    "24h": (
        *("--size", "60x40", "--aisles", "8", "--stations", "2", "--orders", "250/h", "--shifts", "00-24"),
        *("--peak", "11:30-13x1.6", "--packers", "auto", "--due", "15"),
    ),
}
"""What `desim new` is told of warehouses whose drafts are measured as it writes them now."""
NEW = {
    "a draft of today, settling counted: the first run": ("today", {}),
    "a working day of 16 h, its first two hours": ("day", {"run.length": 7200}),
}
"""Runs of such drafts; what settles batteries before the run counts, too."""
COUNT = """
import sys
import desim_warehouse as dw
from desim_warehouse.world import World

FULL = {{"fleet.start_energy": 1}}

count = 0

def bytecode(frame, event, _):
    global count
    count += event == "opcode"
    return bytecode

def call(frame, event, _):
    frame.f_trace_opcodes, frame.f_trace_lines = True, False
    return bytecode

for path, changes, settles in {runs!r}:
    # What is imported and worked out once is not counted, but for what settles batteries: here they begin full.
    World(dw.load(path, {{**changes, **FULL}} if settles else changes), 0).run()
    model, count = dw.load(path, changes), 0
    world = None if settles else World(model, 0)
    sys.settrace(call)
    (world or World(model, 0)).run()
    sys.settrace(None)
    print(count)
"""


def drafts(folder: Path) -> dict[str, Path]:
    """The drafts as this checkout writes them."""
    from click.testing import CliRunner

    from desim_warehouse.cli import desim

    paths = {name: folder / f"{name}.yaml" for name in DRAFTS}
    for name, path in paths.items():
        CliRunner().invoke(desim, ["new", str(path), *DRAFTS[name]], catch_exceptions=False)
    return paths


def counts(checkout: Path, paths: Mapping[str, Path]) -> list[int]:
    """Bytecodes of every run in a checkout, on the models of this one, and on the drafts at some paths."""
    runs = [
        *((str(HERE / path), changes, False) for path, changes in RUNS.values()),
        *((str(paths[name]), changes, True) for name, changes in NEW.values()),
    ]
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    done = subprocess.run(  # noqa: S603 - a checkout that the caller named
        [sys.executable, "-c", COUNT.format(runs=runs)],
        cwd=checkout,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return [int(line) for line in done.stdout.split()]


def main() -> None:
    """Print the counts of this checkout, or of both and this one's over the other's."""
    with tempfile.TemporaryDirectory() as folder:
        paths = drafts(Path(folder))
        these = counts(HERE, paths)
        others = counts(Path(sys.argv[1]).resolve(), paths) if len(sys.argv) > 1 else these
    print(f"{'bytecodes':<50} {'other':>12} {'this':>12}  ratio")
    for name, other, this in zip((*RUNS, *NEW), others, these, strict=True):
        print(f"{name:<50} {other:>12,} {this:>12,}  {this / other:.4f}")


if __name__ == "__main__":
    main()
