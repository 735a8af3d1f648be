"""Compare the allocation strategies on MultiBots and write docs/allocation.md: `python -m benchmarks.allocation`.

The paper's five goods groups, 100 random lists of 10 goods and 100 of 40, with 6 and with 3 robots; every strategy
gets the same lists. Differences are paired with in-order, list by list, with 95 % intervals (t).
"""

from __future__ import annotations

import argparse
import concurrent.futures
import multiprocessing
import statistics
from pathlib import Path
from typing import Any

from benchmarks import GROUPS

ROOT = Path(__file__).parents[1]
FIRST_SEED = 1000
SHOWN = ("T", "S", "C", "cost")
COMPARED = ("T", "S", "cost")
FLEETS = (6, 3)


def lists(count: int) -> dict[str, list[tuple[Any, int]]]:
    """Goods and run seeds of every kind of list."""
    seeds = range(FIRST_SEED, FIRST_SEED + count)
    return {
        "the paper's 5 groups of 10 goods": [(list(group), 0) for group in GROUPS],
        f"{count} random lists of 10 goods": [({"random": 10}, seed) for seed in seeds],
        f"{count} random lists of 40 goods": [({"random": 40}, seed) for seed in seeds],
    }


def measure(case: tuple[str, int, Any, int]) -> dict[str, float]:
    """The indicators of one run."""
    from desim_warehouse import load, simulate

    strategy, robots, goods, seed = case
    changes = {"fleet.size": robots, "tasks.goods": goods, "policies.allocation": strategy, "log": "tasks"}
    run = simulate(load(ROOT / "models" / "multibots.yaml", changes), seed)
    return {key: float(run.kpis[key]) for key in SHOWN}


def half_width(values: list[float]) -> float:
    """Of the 95 % interval of a mean, by Student's t."""
    from scipy.stats import t

    size = len(values)
    return float(t.ppf(0.975, size - 1)) * statistics.stdev(values) / size**0.5


def table(results: dict[int, dict[str, list[dict[str, float]]]]) -> list[str]:
    """A line for each strategy, or for several whose runs are all equal: means, and paired differences to in-order."""
    alike: list[list[str]] = []
    for strategy in results[FLEETS[0]]:
        for names in alike:
            if all(runs[names[0]] == runs[strategy] for runs in results.values()):
                names.append(strategy)
                break
        else:
            alike.append([strategy])
    heads = ["strategy", *(f"{key}, {robots} robots" for robots in results for key in SHOWN)]
    rows = ["| " + " | ".join(heads) + " |", "|" + "---|" + "---:|" * (len(heads) - 1)]
    for names in alike:
        cells = [", ".join(names)]
        cells += [cell(key, runs[names[0]], runs["in-order"]) for runs in results.values() for key in SHOWN]
        rows.append("| " + " | ".join(cells) + " |")
    return rows


def cell(key: str, runs: list[dict[str, float]], base: list[dict[str, float]]) -> str:
    """A mean, and where it is compared with in-order the difference with its interval, and in per cent."""
    digits = 1 if key in ("S", "C") else 0
    entry = f"{statistics.fmean(run[key] for run in runs):,.{digits}f}"
    if runs is base or key not in COMPARED:
        return entry
    differences = [run[key] - other[key] for run, other in zip(runs, base, strict=True)]
    gap = statistics.fmean(differences)
    entry += f", {gap:+,.{digits}f} ± {half_width(differences):,.{digits}f}"
    if key == "S":
        return entry
    return f"{entry} ({100 * gap / statistics.fmean(run[key] for run in base):+.1f} %)"


def main() -> None:
    """Run all cells and write the page."""
    from desim_warehouse.policies.catalogue import OURS

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lists", type=int, default=100, help="random lists of each length")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "allocation.md")
    asked = parser.parse_args()
    strategies = list(OURS["allocation"])
    keys, cases = [], []
    for kind, goods in lists(asked.lists).items():
        for robots in FLEETS:
            for strategy in strategies:
                for item, seed in goods:
                    keys.append((kind, robots, strategy))
                    cases.append((strategy, robots, item, seed))
    results: dict[str, dict[int, dict[str, list[dict[str, float]]]]] = {}
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(asked.workers, context) as pool:
        for (kind, robots, strategy), run in zip(keys, pool.map(measure, cases, chunksize=20), strict=True):
            results.setdefault(kind, {}).setdefault(robots, {}).setdefault(strategy, []).append(run)
    text = (Path(__file__).parent / "allocation_text.md").read_text(encoding="utf-8").rstrip()
    for kind, rows in results.items():
        text += f"\n\n## {kind[:1].upper()}{kind[1:]}\n\n" + "\n".join(table(rows))
    asked.out.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
