"""How large a replay of many robots is, how soon it is there, and how many frames a second it draws.

    python -m benchmarks.replay [ROBOTS] [SECONDS]

simulates a large block layout (by default 1,000 robots for an hour), writes the page and plays it in Chromium.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import desim_warehouse as dw
from desim_warehouse.layout.naming import block_nodes

if TYPE_CHECKING:
    from desim_warehouse.questions.run import Run

COLUMNS, ROWS = 40, 16
PLAYED = 5.0
"""Seconds for which frames are counted."""
READY = "const done = arguments[0]; desimReplay.ready.then(done, (error) => done(String(error.stack)))"
PLAY = """
const done = arguments[1], page = window.desimReplay;
page.player.speed = 20;
page.player.toggle();
const before = page.frames(), from = performance.now();
setTimeout(() => {
  const after = page.frames(), count = after.count - before.count;
  page.player.toggle();
  done([(1000 * count) / (performance.now() - from), (after.drawing - before.drawing) / count]);
}, arguments[0] * 1000);
"""


def large(robots: int, seconds: float) -> dict[str, Any]:
    """A model of 15,360 storage places in 640 blocks, bays on three sides and stations on the fourth."""
    names = block_nodes(COLUMNS, ROWS)
    sides = [*names[0], *(row[0] for row in names[1:-1]), *(row[-1] for row in names[1:-1])]
    south = names[-1]
    return {
        "name": f"{robots} robots",
        "layout": {
            "blocks": {
                "columns": COLUMNS,
                "rows": ROWS,
                "block_depth": 12,
                "goods_size": 1.0,
                "aisle_width": 1.4,
                "cross_aisle_width": 2.0,
            },
            "bays": {"around": {"at": sides, "places": robots // len(sides) + 3}},
            "stations": {"packing": {"along": "south", "places": robots // len(south) + 2, "servers": 6}},
        },
        "fleet": {"size": robots, "robot": {"radius": 0.35, "speed": 1.5, "margin": 0.1}, "exit_time": 2.0},
        "tasks": {
            "goods": {"saturated": robots},
            "unload_at": [south[number % len(south)] for number in range(robots)],
            "load_time": 5.0,
            "unload_time": 4.0,
        },
        "battery": {"capacity": 100.0, "threshold": 30.0, "consumption": 0.02, "charge_rate": 0.1},
        "traffic": {"node_time": 0.5},
        "run": {"length": seconds},
    }


def measure(run: Run, folder: Path) -> dict[str, float]:
    """Size (MB), time to write, time until the page can be used, frames a second and milliseconds to draw one."""
    from tests.browser.chromium import start

    began = time.perf_counter()
    path = folder / "replay.html"
    run.replay(path)
    written = time.perf_counter() - began
    browser = start(folder / "profile")
    try:
        browser.get(path.as_uri())
        loaded = browser.execute_async_script(READY) / 1000
        frames, drawing = browser.execute_async_script(PLAY, PLAYED)
    finally:
        browser.quit()
    return {
        "rows": len(run.record.rows),
        "megabytes": path.stat().st_size / 1e6,
        "write_seconds": written,
        "load_seconds": loaded,
        "frames_per_second": frames,
        "draw_milliseconds": drawing,
    }


def report(robots: int = 1000, seconds: float = 3600.0) -> str:
    """The measured figures as a line of text."""
    run = dw.simulate(dw.load(large(robots, seconds)), seed=1)
    with tempfile.TemporaryDirectory() as folder:
        figures = measure(run, Path(folder))
    return (
        f"replay of {robots:,} robots for {seconds:,.0f} s ({figures['rows']:,.0f} log rows, {run.S:,} collisions): "
        f"{figures['megabytes']:.1f} MB written in {figures['write_seconds']:.1f} s, usable after "
        f"{figures['load_seconds']:.1f} s, {figures['frames_per_second']:.0f} frames/s, "
        f"{figures['draw_milliseconds']:.1f} ms to draw one"
    )


if __name__ == "__main__":
    print(report(*(int(argument) for argument in sys.argv[1:])))
