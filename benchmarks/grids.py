"""Large grids: how long reading one takes, and how one-way lanes do on the grids of planners beside two-way ones.

`python -m benchmarks.grids` reads a warehouse of some 50,000 cells, drawn here, as a model with its layout beside it.
`python -m benchmarks.grids FILE ...` orients grids of others (see docs/how-to/import-a-grid.md) and runs either floor
with 50 and 100 robots: the table of that page.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import desim_warehouse as dw
from benchmarks.memory import peak
from desim_warehouse.layout import build
from desim_warehouse.model.oriented import orientation, oriented
from desim_warehouse.plants import import_layout

ROOT = Path(__file__).parents[1]
FLEETS = (50, 100)
LENGTH, WARM_UP = 1800, 300
RUNS = 3


def warehouse(columns: int, rows: int) -> str:
    """A kiva map: shelves of ten cells in rows, endpoints above and below, aisles between, homes at the sides."""
    width, height = 12 * columns + 5, 4 * rows + 1
    lines = []
    for row in range(height):
        middle = {0: ".", 1: "e", 2: "@", 3: "e"}[row % 4]
        side = ".rr" if row % 4 else "..."
        lines.append(f"{side}{('.' + middle * 10 + '.') * columns}{side[1:]}")
    free = sum(line.count("e") for line in lines)
    homes = sum(line.count("r") for line in lines)
    return "\n".join([f"{height} {width}", str(free), str(homes), "5000", *lines]) + "\n"


def write(folder: Path, text: str) -> Path:
    """The model of a map, with its layout beside it, in a folder."""
    grid, model = folder / "large.map", folder / "large.yaml"
    grid.write_text(text, encoding="utf-8")
    for path, content in import_layout(grid, robots=200).files(model).items():
        path.write_text(content, encoding="utf-8")
    return model


def reading(model: Path) -> tuple[int, float, float]:
    """Nodes of a model, and what a process of its own takes to read it and build its layout: seconds, memory in MB."""
    words = [sys.executable, "-m", "benchmarks.grids", "--read", str(model)]
    done = subprocess.run(words, check=True, capture_output=True, text=True, cwd=ROOT)  # noqa: S603 - this file
    nodes, seconds, memory = done.stdout.split()
    return int(nodes), float(seconds), float(memory)


def _read(model: str) -> None:
    begin = time.process_time()
    nodes = len(build(dw.load(model).layout).graph)
    print(nodes, time.process_time() - begin, peak())


def side_by_side(path: str) -> None:
    """Print how the one-way and the two-way floor of a grid do, a line for each fleet."""
    begin = time.process_time()
    two_way = import_layout(path, robots=max(FLEETS)).model.replace(
        {"tasks.load_time": 0, "tasks.unload_time": 0, "run.length": LENGTH, "run.warm_up": WARM_UP, "log": "tasks"}
    )
    directions = orientation(two_way)
    one_way = oriented(two_way, directions)
    layout = two_way.layout
    print(f"{path}: {len(layout.nodes):,} nodes, {len(layout.edges):,} lanes; {len(directions.bridges)} stay two-way")
    print(f"stretch {directions.stretch:.2f}, in {time.process_time() - begin:.0f} s of processor time")
    for robots in FLEETS:
        for title, model in (("two-way", two_way), ("one-way", one_way)):
            begin = time.process_time()
            changes = {"fleet.size": robots, "tasks.goods": {"saturated": robots}}
            runs = [dw.simulate(model.replace(changes), seed) for seed in range(RUNS)]
            kpis = [_mean(runs, key) for key in ("throughput_per_hour", "cycle_time_mean", "share_waiting")]
            spent = (time.process_time() - begin) / RUNS
            print(f"{robots:>5} {title:<8} {kpis[0]:>7.0f} tasks/h {kpis[1]:>6.1f} s {kpis[2]:>6.1%} waiting", end="")
            print(f"  ({spent:.0f} s a run)", flush=True)


def _mean(runs: list[Any], key: str) -> float:
    return sum(run.kpis[key] for run in runs) / len(runs)


def report() -> None:
    """Print how long reading a large grid takes."""
    with tempfile.TemporaryDirectory() as folder:
        nodes, seconds, memory = reading(write(Path(folder), warehouse(70, 20)))
        print(f"{nodes:,} nodes read in {seconds:.1f} s of processor time and {memory:.0f} MB")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--read"]:
        _read(sys.argv[2])
    else:
        for path in sys.argv[1:]:
            side_by_side(path)
        if not sys.argv[1:]:
            report()
