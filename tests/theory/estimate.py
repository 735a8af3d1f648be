"""Does a simulated mean agree with a formula? Independent runs, and the 99 % interval of Student's t."""

from __future__ import annotations

import math
import statistics

from scipy.stats import t as student

import desim_warehouse as dw

WITHIN = 0.03


def means(model, indicator, runs=20):
    """An indicator in independent runs; `indicator` is a name or a function of the run."""
    model = dw.load(model)
    done = (dw.simulate(model, seed) for seed in range(runs))
    return [indicator(run) if callable(indicator) else run.kpis[indicator] for run in done]


def agrees(values, formula):
    """The 99 % interval contains the formula and lies within 3 % of it."""
    mean = statistics.fmean(values)
    half = student.ppf(0.995, len(values) - 1) * statistics.stdev(values) / math.sqrt(len(values))
    said = f"{mean:.6g} ± {half:.2g}, by the formula {formula:.6g}"
    assert abs(mean - formula) <= half, f"the interval misses it: {said}"
    assert abs(mean - formula) + half <= WITHIN * abs(formula), f"the interval is too wide: {said}"
