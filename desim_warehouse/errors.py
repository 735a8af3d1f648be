"""What can go wrong, as one tree of exceptions.

    WarehouseError
    ├── ModelError        the model or study file: all problems of a file at once
    ├── CheckError        a model that cannot work, by a check before it runs
    │   └── LayoutError       the Highways: unreachable places, stops that void the liveness guarantee
    ├── PolicyError       a decision that cannot be carried out, with the policy that made it
    ├── SimulationError   a run that cannot go on
    │   ├── GridlockError     a full ring where the model forbids turning
    │   ├── StallError        work is open and nothing is scheduled
    │   └── BatteryError      a robot ran flat
    ├── StudyError        a study that cannot be run, stored or read
    └── ReportError       a report, replay or export that cannot be made

Catch `WarehouseError` to catch them all.
"""

from __future__ import annotations


class WarehouseError(Exception):
    """Anything this package refuses or cannot do."""


class ModelError(WarehouseError):
    """A model or study file with problems: `problems` lists them all, one line each, with their place."""

    def __init__(self, problems: list[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = list(problems)

    def __reduce__(self) -> tuple[type[ModelError], tuple[list[str]]]:
        return type(self), (self.problems,)


class CheckError(WarehouseError):
    """A model that cannot work, by a check before it runs: `problems` lists them all, one line each, with its code."""

    def __init__(self, problems: list[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = list(problems)

    def __reduce__(self) -> tuple[type[CheckError], tuple[list[str]]]:
        return type(self), (self.problems,)


class LayoutError(CheckError):
    """A layout on which work could stop for good: `problems` lists them all, one line each."""


class PolicyError(WarehouseError):
    """A policy returned something that cannot be done, or could not be loaded."""


class SimulationError(WarehouseError):
    """A run that cannot go on."""


class GridlockError(SimulationError):
    """A full ring of robots that may not turn (`traffic.gridlock: stop`)."""


class StallError(SimulationError):
    """Work is open, and nothing is scheduled that could end it."""


class BatteryError(SimulationError):
    """A robot ran flat outside its charging zone."""


class StudyError(WarehouseError):
    """A study that cannot be run, stored or read."""


class ReportError(WarehouseError):
    """A report, replay, figure or export that cannot be made."""


def reason(error: Exception) -> str:
    """Why something failed, for a message that names the file itself: without error numbers and paths."""
    if isinstance(error, KeyError):
        return f"{error} is missing"
    if isinstance(error, FileExistsError | NotADirectoryError):
        return "a file is in the place of a folder"
    return getattr(error, "strerror", None) or str(error)
