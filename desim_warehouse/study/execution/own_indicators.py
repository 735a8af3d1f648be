"""User-defined indicators: functions of a run, called in the simulating process and stored like other indicators.

For `indicators` of `Study` in Python.
"""

from __future__ import annotations

import pickle
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

from desim_warehouse.errors import PASSED_ON, StudyError, shown
from desim_warehouse.run import RunData
from desim_warehouse.study.execution.content import digest_of


@dataclass(frozen=True)
class OwnIndicator:
    """A user-defined indicator, identified by its name and a digest of what its function computes (`content`).

    `function` is None if only its values are available, as in the folder of a study, and bytes in another process until
    a run needs it. `as_given`: converts a run to the argument of the function.
    """

    name: str
    digest: str
    function: Callable[[Any], float] | bytes | None = field(default=None, compare=False)
    as_given: Callable[[RunData], Any] | None = field(default=None, compare=False)

    def value(self, run: RunData) -> float:
        """Compute the indicator of a run.

        Raises:
            StudyError: the function raised an error (with its line), or did not return a number.
        """
        assert self.function is not None
        function: Any = None
        try:
            function = pickle.loads(self.function) if isinstance(self.function, bytes) else self.function  # noqa: S301
            return float(function(run if self.as_given is None else self.as_given(run)))
        except PASSED_ON:
            raise
        except BaseException as error:
            frames = traceback.extract_tb(error.__traceback__)
            file = getattr(getattr(function, "__code__", None), "co_filename", None)
            last = ([frame for frame in frames if frame.filename == file] or frames)[-1]
            where = f"{last.filename}, line {last.lineno}"
            raise StudyError(f"indicator {self.name}: raised {shown(error)} in {where}") from error

    def __reduce__(self) -> tuple[Any, ...]:
        function = _packed(self.name, self.function) if callable(self.function) else self.function
        return OwnIndicator, (self.name, self.digest, function, self.as_given)


def own_indicators(
    functions: Mapping[str, Callable[[Any], float]], as_given: Callable[[RunData], Any] | None
) -> tuple[OwnIndicator, ...]:
    """Make the indicators of a study from functions.

    Raises:
        StudyError: a name that is not a text, or a value that is not a function.
    """
    for name, function in functions.items():
        if not isinstance(name, str):
            raise StudyError(f"indicators, {shown(name):.60}: expected a name in quotes")
        if not callable(function):
            raise StudyError(f"indicators, {name}: {shown(function):.60}, expected a function of a run")
    return tuple(OwnIndicator(name, digest_of(function), function, as_given) for name, function in functions.items())


def _packed(name: str, function: Callable[[Any], float]) -> bytes:
    """Pack a function for another process: by its module and name, or as a whole if the process has no such module."""
    if getattr(function, "__module__", "__main__") != "__main__":
        try:
            return pickle.dumps(function)
        except (pickle.PicklingError, AttributeError, TypeError):
            pass
    try:
        cloudpickle = import_module("cloudpickle")
    except ImportError:
        cure = "put it into a module of its own, install cloudpickle, or simulate with workers=1"
        raise StudyError(f"indicator {name}: its function cannot be sent to other processes; {cure}") from None
    packed: bytes = cloudpickle.dumps(function)
    return packed
