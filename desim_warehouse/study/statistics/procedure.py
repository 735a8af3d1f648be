"""Sequential procedures: generators that ask for a batch of runs, are sent its values, and choose the next."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from typing import TypeAlias, TypeVar, cast

from desim_warehouse.errors import StudyError

T = TypeVar("T")
RunNumber: TypeAlias = tuple[int, int]
"""Design number and replication number, both from 0."""

Procedure: TypeAlias = Generator[list[RunNumber], Sequence[float], T]
"""A generator that yields batches of runs, is sent their values in the same order, and returns its result."""


def follow(procedure: Procedure[T], sample: Callable[[int, int], float]) -> T:
    """Carry out a procedure by simulating every run it asks for, one after the other.

    `sample(design, replication)` returns the indicator. To use many workers, do what this function does,
    but simulate the runs of a batch together: the result is the same.

    Raises:
        StudyError: a run gave a value that is not finite.
    """
    values: Sequence[float] | None = None
    while True:
        try:
            runs = next(procedure) if values is None else procedure.send(values)
        except StopIteration as end:
            return cast("T", end.value)
        values = [sample(design, replication) for design, replication in runs]


def together(procedures: Sequence[Procedure[T]]) -> Procedure[list[T]]:
    """Carry out several procedures side by side: their requests make one batch, so that no worker idles."""
    results: dict[int, T] = {}
    asked = dict[int, list[RunNumber]]()

    def send(which: int, values: Sequence[float] | None) -> None:
        try:
            asked[which] = next(procedures[which]) if values is None else procedures[which].send(values)
        except StopIteration as end:
            results[which] = cast("T", end.value)

    for which in range(len(procedures)):
        send(which, None)
    while asked:
        batch = list(asked.items())
        values = yield [run for _, runs in batch for run in runs]
        asked.clear()
        for which, runs in batch:
            send(which, values[: len(runs)])
            values = values[len(runs) :]
    return [results[which] for which in range(len(procedures))]


def request(runs: list[RunNumber], *, failing: bool = False) -> Procedure[Sequence[float]]:
    """Ask for runs within a procedure and check what comes back: one finite number for each.

    `failing`: a run may be without a value (nan).

    Raises:
        StudyError: the wrong number of values, or one that is not finite, with its design and replication.
    """
    values = yield runs
    if len(values) != len(runs):
        raise StudyError(f"asked for {len(runs)} runs, got {len(values)} values")
    for (design, replication), value in zip(runs, values, strict=True):
        if not (math.isfinite(value) or (failing and math.isnan(value))):
            raise StudyError(f"design {design}, replication {replication}: {value!r} is not a finite number")
    return values
