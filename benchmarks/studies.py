"""Speed of studies: overhead per run, two processes against one, and a finished study gone through again."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from time import perf_counter

import desim_warehouse as dw

MULTIBOTS = Path(__file__).parents[1] / "models" / "multibots.yaml"
RUNS = 1000
REPEATS = 3


def cell() -> dw.Study:
    """1,000 runs of a MultiBots cell: six robots and ten random goods."""
    return dw.Study(MULTIBOTS, changes={"tasks.goods": {"random": 10}}, replications=RUNS)


def timed(workers: int, out: str | None = None) -> tuple[float, float]:
    """Seconds that the study takes, start and end of the processes and all files included; and those simulated."""
    study = cell()
    begin = perf_counter()
    study.run(workers=workers, out=out)
    taken = perf_counter() - begin
    failed = study.table["error"].notna().sum()
    if failed:
        raise SystemExit(f"{failed} runs failed: {study.table['error'].dropna().iloc[0]}")
    return taken, float(study.table["run_time"].sum())


def report() -> list[str]:
    """Measure, print and return the lines; the best of three, taken in turn, because other work disturbs."""
    timed(1)  # all is imported and compiled
    pairs = [(timed(1), timed(2)) for _ in range(REPEATS)]
    one = min(serial for (serial, _), _ in pairs)
    two = min(parallel for _, (parallel, _) in pairs)
    simulated = min(total for (_, total), _ in pairs)
    overhead = min(2 * taken - total for _, (taken, total) in pairs) / RUNS
    with tempfile.TemporaryDirectory() as folder:
        timed(2, folder)
        again, _ = timed(2, folder)
    beyond = 1000 * (one - simulated) / RUNS
    cores = len(os.sched_getaffinity(0))
    lines = [
        f"studies: {RUNS} runs of a MultiBots cell, serial: {one:.2f} s, {RUNS / one:.0f} runs/s",
        f"studies: beyond the simulation: {beyond:.2f} ms a run, serial",
        f"studies: two processes, their start included: {two:.2f} s, {RUNS / two:.0f} runs/s, {cores} cores",
        f"studies: two processes: {one / two:.2f} times the serial rate (at least 1.7)",
        f"studies: beyond the simulation: {1000 * overhead:.2f} ms a run, two processes (at most 3)",
        f"studies: a finished study of {RUNS} runs again: {again:.2f} s (at most 3)",
    ]
    print("\n".join(lines))
    return lines


if __name__ == "__main__":
    report()
