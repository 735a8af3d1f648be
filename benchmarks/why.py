"""The figures of docs/why.md that no test checks: `python -m benchmarks.why`, about three minutes.

How well the event model agrees with the stepped reference in 400 random settings.
What common random numbers gain: the variance of a difference of T between independent runs over that between runs
of the same seed, which is by how much fewer replications do. And S of the literal rule as its time step shrinks:
the stepped reference with 6 robots and 60 random lists of 30 goods, beside the event model.
"""

from __future__ import annotations

import random
import statistics
from pathlib import Path
from typing import Any

from tests.reference import stepped
from tests.reference.paper import changes, settings

MODEL = Path(__file__).parents[1] / "models" / "multibots.yaml"
GOODS = {"tasks.goods": {"random": 20}}
CHANGES: dict[str, dict[str, Any]] = {
    "load time 10 to 12 steps, 1 robot": {"fleet.size": 1, "tasks.load_time": 12},
    "load time 10 to 12 steps, 6 robots": {"fleet.size": 6, "tasks.load_time": 12},
    "in-order to nearest, 6 robots": {"fleet.size": 6, "policies.allocation": "nearest"},
    "nearest to hungarian, 6 robots": {"fleet.size": 6, "policies.allocation": "hungarian"},
}
PER_STEP = ("START_STEPS", "TURN_STEPS", "AFTER_UNLOADING_STEPS", "FULL_STEPS", "COMING_OUT_STEPS")


def gain(change: dict[str, Any], runs: int = 100) -> float:
    """Variance of the difference without common random numbers over the variance with them."""
    from desim_warehouse import load, simulate

    before = {**GOODS, "fleet.size": change["fleet.size"]}
    if change.get("policies.allocation") == "hungarian":
        before["policies.allocation"] = "nearest"
    base, ours = load(MODEL, before), load(MODEL, {**GOODS, **change})
    t0 = [simulate(base, seed).T for seed in range(runs)]
    t1 = [simulate(ours, seed).T for seed in range(runs)]
    paired = statistics.variance(b - a for a, b in zip(t0, t1, strict=True))
    return (statistics.variance(t0) + statistics.variance(t1)) / paired


def lists() -> list[tuple[int, ...]]:
    draws = random.Random(5)
    return [tuple(draws.randrange(80) for _ in range(30)) for _ in range(60)]


def literal(finer: int) -> tuple[int, float]:
    """S and T (in steps of 0.05 s) of the paper's rule tested `finer` times as often."""
    usual = {name: getattr(stepped, name) for name in PER_STEP}
    try:
        for name, steps in usual.items():
            setattr(stepped, name, steps * finer)
        outcomes = [
            stepped.simulate(
                stepped.Setting(
                    6,
                    goods,
                    speed=4 / finer,
                    load_time=10 * finer,
                    unload_time=20 * finer,
                    consumption=0.005 / finer,
                    charge_rate=0.05 / finer,
                )
            )
            for goods in lists()
        ]
    finally:
        for name, steps in usual.items():
            setattr(stepped, name, steps)
    return sum(outcome.S for outcome in outcomes), sum(outcome.T for outcome in outcomes) / finer


def events() -> tuple[int, float]:
    """S and T of the event model on the same lists."""
    from desim_warehouse import load, simulate

    runs = [simulate(load(MODEL, {"fleet.size": 6, "tasks.goods": list(goods)})) for goods in lists()]
    return sum(run.S for run in runs), sum(run.T for run in runs)


def agreement(count: int = 400) -> str:
    """T, S and C of the event model beside those of the stepped reference."""
    from desim_warehouse import load, simulate

    model = load(MODEL)
    off, ours, theirs, same = [], 0, 0, 0
    for setting, expected in settings(random.Random(0), count):
        run = simulate(model.replace(changes(setting)))
        off.append(abs(run.T / expected.T - 1))
        ours, theirs, same = ours + run.S, theirs + expected.S, same + (expected.C == run.C)
    near = sum(error <= 0.01 for error in off)
    return (
        f"{count} random settings: T within 1 % in {100 * near / count:.1f} %, median difference "
        f"{100 * statistics.median(off):.2f} %, S {ours} against {theirs} ({100 * (ours / theirs - 1):+.1f} %), "
        f"C equal in {100 * same / count:.1f} %"
    )


def report() -> str:
    lines = [f"{name}: {gain(change):,.1f} times" for name, change in CHANGES.items()]
    lines += [f"literal rule every {0.05 / k:g} s: S {s:,}, T {t:,.0f}" for k in (1, 2, 4) for s, t in [literal(k)]]
    s, t = events()
    return "\n".join([agreement(), *lines, f"events: S {s:,}, T {t:,.0f}"])


if __name__ == "__main__":
    print(report())
