"""What people wait for: `python -m benchmarks.waits [--long]`, the first table of docs/dev/performance.md.

Runs are counted in bytecodes of Python, which no neighbour disturbs. Commands of `desim` are processes of their own:
processor time, with that of their workers, and the most memory of one process. Drafts are those that `desim new` writes
now; nothing is kept of commands before, so settling batteries counts. `--long`: plans of days, and floors of 5,000 and
40,000 nodes.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmarks import bytecodes
from benchmarks.growth import warehouse

MULTIBOTS, MIR = (str(bytecodes.HERE / "models" / name) for name in ("multibots.yaml", "mir250.yaml"))
ANSWERS = {
    "desim run, the smallest model": ["run", MULTIBOTS],
    "desim check of a draft": ["check", "today.yaml"],
    "desim run of a draft, the first": ["run", "today.yaml"],
    "desim run of a working day of 16 h": ["run", "day.yaml"],
    "desim run of a day of 24 h": ["run", "24h.yaml"],
    "desim plan of the README": [
        *("plan", "today.yaml", "--target", "on_time >= 95 %", "--growth", "30%"),
        *("--robots", "6..20", "--chargers", "1..6", "--workers", "2", "--quiet"),
    ],
    "desim why of the README": ["why", MIR, "--workers", "2", "--quiet"],
}
DAYS = {
    f"desim plan of {what}": [
        *("plan", path, "--target", "on_time >= 90 %", "--packers", "packing", "--workers", "2", "--quiet")
    ]
    for what, path in (("a working day of 16 h", "day.yaml"), ("a day of 24 h", "24h.yaml"))
}
"""Plans that take minutes."""
FLOORS = {
    "check": ["check", "floor.json"],
    "check, routes by hops": ["check", "floor.json", "--set", "policies.routing=highways"],
    "draw": ["draw", "floor.json"],
    "import": ["import", "floor.graphml", "--out", "imported.yaml", "--force"],
    "orient": ["orient", "two-way.json", "--out", "oriented.yaml", "--runs", "0", "--force"],
    "replay": ["replay", "floor.json", "--set", "run.length=300", "--set", "run.warm_up=0"],
}
SIDES = {5_000: 70, 40_000: 199}
"""Blocks along a side of a floor, by about how many nodes it has."""
MEASURE = """
import resource, sys
from desim_warehouse.cli import main
status = 0
try:
    main()
except SystemExit as end:
    status = end.code or 0
from benchmarks.memory import peak
used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
time = sum(one.ru_utime + one.ru_stime for one in used)
print(time, max(peak(), used[1].ru_maxrss / 1024), status, file=open("used", "w"))
"""


def waited(arguments: list[str], folder: Path) -> tuple[float, float]:
    """Seconds of processor time of a command, and its memory in MB; nothing is kept of commands before."""
    environment = {**os.environ, "PYTHONPATH": str(bytecodes.HERE), "DESIM_CACHE": tempfile.mkdtemp(dir=folder)}
    command = [sys.executable, "-c", MEASURE, *arguments]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)  # noqa: S603
    time, memory, status = (folder / "used").read_text(encoding="ascii").split()
    if int(status):
        raise SystemExit(f"desim {' '.join(arguments)}: exit status {status}\n{done.stderr}")
    return float(time), float(memory)


def two_way(side: int) -> dict[str, Any]:
    """The floor of `warehouse` with nothing but two-way lanes, drawn by hand."""
    model = warehouse(side, 20)
    floor, edges = model.floor, list(model.floor.graph.edges)
    layout = {
        "nodes": {node: [at.real, at.imag] for node, at in floor.points.items()},
        "edges": [{"from": start, "to": end, "two_way": True} for start, end in edges],
        "storage": [{"edge": list(edge), "offset": floor.length(edge) / 2} for edge in edges[:: len(edges) // 100]],
        "bays": {"parking": {"at": list(floor.bays), "places": 4}},
        "stations": {"packing": {"at": list(floor.stations), "places": 20}},
    }
    return {**model.content(), "layout": layout}


def row(name: str, arguments: list[str], folder: Path) -> None:
    time, memory = waited(arguments, folder)
    print(f"{name:<50} {time:>9,.2f} s  {memory:>8,.0f} MB", flush=True)


def report(*, long: bool = False) -> None:
    """Print the table; `long` also the rows of large floors."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        counts = bytecodes.counts(bytecodes.HERE, bytecodes.drafts(folder))
        for name, count in zip((*bytecodes.RUNS, *bytecodes.NEW), counts, strict=True):
            print(f"{name:<50} {count / 1e6:>9,.2f} million bytecodes", flush=True)
        for name, arguments in (ANSWERS | DAYS if long else ANSWERS).items():
            row(name, arguments, folder)
        for nodes, side in SIDES.items() if long else ():
            for name, model in (("floor", warehouse(side, 20).content()), ("two-way", two_way(side))):
                (folder / f"{name}.json").write_text(json.dumps(model), encoding="utf-8")
            waited(["export", "two-way.json", "--format", "graphml", "--out", "floor.graphml", "--force"], folder)
            for command, arguments in FLOORS.items():
                row(f"desim {command}, {nodes:,} nodes", arguments, folder)


if __name__ == "__main__":
    report(long="--long" in sys.argv)
