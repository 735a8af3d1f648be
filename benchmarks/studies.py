"""Speed of studies: two worker processes against one, beside what the machine itself gives to two at once.

`python -m benchmarks.studies` runs a study of about 20 s of work: serially, with two workers (their start, their end
and all files included), and as two halves in two processes that have nothing to do with each other. The last says
what is attainable: two busy cores share caches, memory and clock. The three are taken in turn, because other work
disturbs, and the ratios are medians of the rounds.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

import desim_warehouse as dw

MULTIBOTS = Path(__file__).parents[1] / "models" / "multibots.yaml"
WORK = 20.0  # seconds
ROUNDS = 3


def cell(replications: int, seed: int = 0) -> dw.Study:
    """A MultiBots cell: six robots and ten random goods, about 2 ms a run."""
    return dw.Study(MULTIBOTS, changes={"tasks.goods": {"random": 10}}, replications=replications, seed=seed)


def timed(study: dw.Study, workers: int, out: Path) -> float:
    """Seconds that the study takes in a folder: start and end of the processes and all files included."""
    begin = perf_counter()
    study.run(workers=workers, out=out)
    taken = perf_counter() - begin
    failed = study.table["error"].notna().sum()
    if failed:
        raise SystemExit(f"{failed} runs failed: {study.table['error'].dropna().iloc[0]}")
    return taken


def loop(replications: int) -> None:
    """A process of its own: begin when the parent says so, say how long the loop took."""
    model = cell(1).plan.base
    dw.simulate(model, 0)
    print("ready", flush=True)
    sys.stdin.readline()
    begin = perf_counter()
    for seed in range(replications):
        dw.simulate(model, seed).kpis  # noqa: B018 - worked out when it is asked for
    print(perf_counter() - begin, flush=True)


def loops(count: int, replications: int) -> float:
    """Seconds until every one of several processes, side by side, has done its runs; their start is not counted."""
    command = [sys.executable, "-m", "benchmarks.studies", str(replications)]
    processes = [
        subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)  # noqa: S603 - our own
        for _ in range(count)
    ]
    try:
        for process in processes:
            process.stdout.readline()
        for process in processes:
            process.stdin.write("begin\n")
            process.stdin.flush()
        return max(float(process.stdout.readline()) for process in processes)
    finally:
        for process in processes:
            process.communicate()


def report(work: float = WORK, rounds: int = ROUNDS) -> list[str]:
    """Measure, print and return the lines."""
    with tempfile.TemporaryDirectory() as folder:
        few = timed(cell(500), 1, Path(folder) / "few")  # all is imported and compiled
        few = timed(cell(500, seed=1), 1, Path(folder) / "few")
        runs = 2 * round(work / few * 500 / 2)
        taken = []
        for number in range(rounds):
            out = Path(folder) / str(number)
            one, two = (timed(cell(runs), workers, out / str(workers)) for workers in (1, 2))
            alone, together = loops(1, runs // 2), loops(2, runs // 2)
            taken.append((one, two, one / two, 2 * alone / together))
        again = timed(cell(runs), 2, out / "2")
    one, two, ratio, attainable = (median(column) for column in zip(*taken, strict=True))
    cores = len(os.sched_getaffinity(0))
    lines = [
        f"studies: {runs} runs of a MultiBots cell, serial: {one:.2f} s, {runs / one:.0f} runs/s",
        f"studies: two workers, their start included: {two:.2f} s, {runs / two:.0f} runs/s",
        f"studies: two workers: {ratio:.2f} times the serial rate (aim 1.9)",
        f"studies: two loops side by side: {attainable:.2f} times the rate of one (attainable; {cores} cores)",
        f"studies: the finished study again: {again:.2f} s",
    ]
    print("\n".join(lines))
    return lines


if __name__ == "__main__":
    if len(sys.argv) > 1:
        loop(int(sys.argv[1]))
    else:
        report()
