"""What is said of the inputs of a run: how long its warm-up is, and which distribution measured times have."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.numbers import sentence
from desim_warehouse.answer.parts import Folded
from desim_warehouse.errors import got, number_of
from desim_warehouse.model import Model

if TYPE_CHECKING:
    from desim_warehouse.study.fit import Fitted
    from desim_warehouse.study.warm_up import Settling


def settled(found: Settling, model: Model, observed: str, runs: int) -> list[str]:
    """What `desim warm-up` found, as the terminal has it."""
    lines = [f"{observed}, {number_of(runs, 'run')}, one observation each {found.width:g} {found.time_unit}"]
    if found.time is not None:
        return [*lines, f"{found.found.note}: run.warm_up: {found.time:g}  # {found.time_unit}"]
    lines.append(f"not settled: {found.found.note}")
    if model.calendars:
        lines.append("what changes by calendars never settles: let run.length and run.warm_up be whole periods")
    return lines


def warm_up(found: Settling, model: Model, observed: str, runs: int) -> Answer:
    """The same as the answer that its folder keeps, beside its figures."""
    first, *lines = settled(found, model, observed, runs)
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
        warm_up=found.time,
    )


def fitted(found: Fitted, unit: str) -> list[str]:
    """What `desim fit` found: the times, and whether the best distribution fits."""
    times = found.times
    rounded = f", rounded to {found.step:g} {unit}" if found.step else ""
    verdict = "nothing speaks against it" if found.fits else "it does not fit"
    spread = f"mean {times.mean():.4g} {unit}, cv {times.std() / times.mean():.4g}{rounded}"
    tested = f"Cramér-von Mises {found.statistic:.3g}, p = {found.p_value:.2g} (Monte Carlo)"
    return [
        f"{len(times)} times from {times.min():.4g} to {times.max():.4g} {unit}, {spread}",
        f"{found.best.kind}: {tested}: {verdict}",
    ]


def proposed(found: Fitted, file: str, column: str) -> str:
    """What the model file should say."""
    if found.fits:
        return f"proposed: {got(found.best.content())}"
    return f"proposed, as none of them fits: {{empirical: {{file: {file}, column: {column}}}}}"


def candidates(found: Fitted, unit: str) -> list[tuple[str, str]]:
    """The distributions tried, and Akaike's criterion of each."""
    return [(one.distribution.words(unit), f"{one.aic:,.1f}") for one in found.candidates]


def fit(found: Fitted, file: str, column: str, unit: str) -> Answer:
    """The same as the answer that its folder keeps, beside its figure."""
    measured, verdict = fitted(found, unit)
    return Answer(
        kind="fit",
        name=column,
        question=f"Which distribution fits {column} of {file}?",
        answer=(sentence(verdict), sentence(proposed(found, file, column)), sentence(measured)),
        tables=(
            Folded(title="Distributions tried", head=("distribution", "AIC"), rows=tuple(candidates(found, unit))),
        ),
        notes=("The figure fit.svg is in its folder.",),
        runs=0,
        confidence=None,
    )
