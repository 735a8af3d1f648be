"""Check that user-defined policies are reproducible: another process repeats the first run with them meanwhile.

That process simulates the run twice, and once more after a run with another seed. All results must be equal; otherwise
the policy draws numbers that no seed fixes, or keeps state between runs, and no run of the study could be repeated.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence

from desim_warehouse.errors import PolicyError, spoken
from desim_warehouse.study.execution import Executor
from desim_warehouse.study.execution.work import Handle, Outcome

_CUT_SHORT = ("time-out", "cancelled", "the worker process died")
"""Beginnings of the errors of runs that did not end by themselves."""

Name = tuple[str, int]
"""The key under which a run is stored: its model and its seed."""


class Repeats:
    """The runs that a command repeats, one for each set of user-defined policies."""

    def __init__(self, make: Callable[[], Executor]) -> None:
        """Prepare repetitions; `make` creates an executor in another process for the first of them."""
        self._make = make
        self._executor: Executor | None = None
        self._known: set[tuple[str, ...]] = set()
        self._open: list[tuple[Sequence[str], Name, Outcome, list[Handle]]] = []

    def begin(self, own: Sequence[str], name: Name, done: Handle) -> None:
        """Start to repeat a run if it is the first that ended with these policies, without waiting for the result."""
        if not own or tuple(own) in self._known or done.outcome is None or done.outcome.error is not None:
            return
        self._known.add(tuple(own))
        if self._executor is None:
            self._executor = self._make()
        other = done.wanted._replace(seed=done.wanted.seed + 1)
        again = [self._executor.submit(done.base, run) for run in (done.wanted, done.wanted, other, done.wanted)]
        self._open.append((own, name, done.outcome, again))

    def wrong(self, *, wait: bool = False) -> tuple[Name, str] | None:
        """Return a run whose repetition had another result, with the difference; None if there is no such run so far.

        `wait`: whether to wait for all repetitions that are still being simulated.
        """
        for item in list(self._open):
            own, name, here, again = item
            if wait and self._executor is not None:
                for _ in self._executor.ended([handle for handle in again if not handle.ended]):
                    pass
            if all(handle.ended for handle in again):
                self._open.remove(item)
                why = _judged(own, here, [handle.outcome for handle in again if handle.outcome is not None])
                if why:
                    return name, why
        return None

    def close(self) -> None:
        """End the process, even if it is busy."""
        if self._executor is not None:
            self._executor.close()


def _judged(own: Sequence[str], here: Outcome, again: Sequence[Outcome]) -> str:
    """Return why runs with these policies are not reproducible; empty if they are, as far as their runs show."""
    errors = [outcome.error for outcome in again if outcome.error is not None]
    if errors and errors[0].startswith(f"{PolicyError.__name__}: ") and " at time " not in errors[0]:
        lost = f"{spoken(own)}: not looked at whether runs are reproducible, as another process has no such policy"
        warnings.warn(f"{lost} ({errors[0]})", RuntimeWarning, stacklevel=2)
        return ""
    if not again or any(error.startswith(_CUT_SHORT) for error in errors):
        return ""
    if len({_content(outcome) for outcome in (here, *again[:2], *again[3:])}) == 1:
        return ""
    return (
        f"{spoken(own)}: not reproducible, two runs with one seed differ. A policy draws numbers from "
        "situation.random() alone, and keeps nothing in its class or module from one run to the next"
    )


def _content(outcome: Outcome) -> str:
    return repr((outcome.error, sorted(outcome.values.items())))
