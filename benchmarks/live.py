"""What the live page costs beside a plain loop of the same runs: `python -m benchmarks.live`."""

from __future__ import annotations

import multiprocessing
import tempfile
from pathlib import Path
from time import perf_counter

import desim_warehouse as dw
from desim_warehouse.study.plan import run_seed
from tests.live.client import client

WORKERS = 2
CASES = {
    "tutorial": ({}, (3, 4, 5), 30),
    "medium": ({"run.length": 1800, "run.warm_up": 300}, (38, 39, 40), 12),
}
"""Changes to the model, fleets, and runs of each."""


def plain(model: dw.Model, runs: int) -> float:
    """Seconds for the runs alone, in as many processes, which have begun."""
    with multiprocessing.get_context("spawn").Pool(WORKERS) as pool:
        pool.starmap(_indicators, [(model, seed) for seed in range(WORKERS)], chunksize=1)
        begin = perf_counter()
        pool.starmap(_indicators, [(model, run_seed(0, r)) for r in range(runs)], chunksize=1)
        return perf_counter() - begin


def _indicators(model: dw.Model, seed: int) -> dict[str, float]:
    return dict(dw.simulate(model, seed).kpis)


def live(base: dw.Model, robots: int, runs: int) -> tuple[float, float]:
    """Seconds until the hand calculation and until the last run, from a page whose workers have begun."""
    offered = {"fleet.size": [1, robots]}
    with (
        tempfile.TemporaryDirectory() as folder,
        client(Path(folder), base, vary=offered, workers=WORKERS) as page,
    ):
        page.until(page.design(robots=1)["id"], lambda answer: answer["n"] >= WORKERS)
        begin = perf_counter()
        design = page.design(robots=robots)
        by_hand = perf_counter() - begin
        page.until(design["id"], lambda answer: answer["n"] >= runs, runs=runs)
        return by_hand, perf_counter() - begin


def main() -> None:
    """A line for each model and fleet."""
    for name, (changes, fleets, runs) in CASES.items():
        base = dw.load(f"models/{name}.yaml", changes)
        for robots in fleets:
            alone = plain(base.replace({"fleet.size": robots}), runs)
            by_hand, took = live(base, robots, runs)
            print(
                f"{name}, {robots} robots, {runs} runs: by hand {1000 * by_hand:.0f} ms, plain {alone:.2f} s, "
                f"page {took:.2f} s, ratio {took / alone:.2f}"
            )


if __name__ == "__main__":
    main()
