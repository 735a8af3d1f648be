"""Answers on the inputs of a run: the length of its warm-up, and the distribution that fits measured times."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.numbers import sentence
from desim_warehouse.answer.parts import Folded
from desim_warehouse.errors import got, number_of
from desim_warehouse.model import Model
from desim_warehouse.values.distributions import in_unit

if TYPE_CHECKING:
    from desim_warehouse.study.fit import Fitted
    from desim_warehouse.study.warm_up import Settling


def settled(settling: Settling, model: Model, observed: str, runs: int) -> list[str]:
    """Return the lines that `desim warm-up` prints: the time at which the model has settled, or that it has not."""
    lines = [f"{observed}, {number_of(runs, 'run')}, one observation each {settling.width:g} {settling.time_unit}"]
    if settling.time is not None:
        return [*lines, f"{settling.result.note}: run.warm_up: {settling.time:g}  # {settling.time_unit}"]
    lines.append(f"not settled: {settling.result.note}")
    if model.calendars:
        lines.append("what changes by calendars never settles: let run.length and run.warm_up be whole periods")
    return lines


def warm_up(settling: Settling, model: Model, observed: str, runs: int) -> Answer:
    """Return the answer on the length of the warm-up, for the folder that also holds its figures."""
    first, *lines = settled(settling, model, observed, runs)
    return Answer(
        kind="warm-up",
        name=model.name,
        description=model.description,
        question="How long is the warm-up?",
        answer=tuple(map(sentence, lines)),
        notes=(sentence(first), "The figures warm-up.svg and welch.svg are in its folder."),
        runs=runs,
        confidence=None,
        made={"model": model.digest()},
        warm_up=settling.time,
    )


def fitted(fitting: Fitted, unit: str) -> list[str]:
    """Return the lines that `desim fit` prints: the measured times, and whether the best distribution fits them."""
    times = fitting.times
    rounded = f", rounded to {fitting.step:g} {unit}" if fitting.step else ""
    verdict = "nothing speaks against it" if fitting.fits else "it does not fit"
    spread = f"mean {times.mean():.4g} {unit}, cv {times.std() / times.mean():.4g}{rounded}"
    tested = f"Cramér-von Mises {fitting.statistic:.3g}, p = {fitting.p_value:.2g} (Monte Carlo)"
    return [
        f"{len(times)} times from {times.min():.4g} to {times.max():.4g} {unit}, {spread}",
        f"{fitting.best.kind}: {tested}: {verdict}",
    ]


def proposed(fitting: Fitted, file: str, column: str, unit: str) -> str:
    """Return the line that proposes a distribution for the model file, or the measured times if none fits.

    Times have their unit, as a model may have another.
    """
    if fitting.fits:
        return f"proposed: {got(in_unit(fitting.best, unit))}"
    return f"proposed, as none of them fits: {{empirical: {{file: {file}, column: {column}, unit: {unit}}}}}"


def candidates(fitting: Fitted, unit: str) -> list[tuple[str, str]]:
    """Return a row for each distribution that was tried: the distribution in words, and its AIC."""
    return [(candidate.distribution.words(unit), f"{candidate.aic:,.1f}") for candidate in fitting.candidates]


def fit(fitting: Fitted, file: str, column: str, unit: str) -> Answer:
    """Return the answer on the fitted distribution, for the folder that also holds its figure."""
    measured, verdict = fitted(fitting, unit)
    return Answer(
        kind="fit",
        name=column,
        question=f"Which distribution fits {column} of {file}?",
        answer=(sentence(verdict), sentence(proposed(fitting, file, column, unit)), sentence(measured)),
        tables=(
            Folded(title="Distributions tried", head=("distribution", "AIC"), rows=tuple(candidates(fitting, unit))),
        ),
        notes=("The figure fit.svg is in its folder.",),
        runs=0,
        confidence=None,
    )
