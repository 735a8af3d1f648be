"""Calls of policies for their answers; errors name the file and line of the user's own code."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from desim_warehouse.errors import PASSED_ON, PolicyError, WarehouseError, shown
from desim_warehouse.policies.catalogue import METHODS

Answer = TypeVar("Answer")
_LONG = 80
"""The most letters of an answer in a message."""


def asked(kind: str, policy: object, now: float, ask: Callable[[], object], check: Callable[[Any], Answer]) -> Answer:
    """Return the answer of a policy as `check` returns it; exceptions become a PolicyError with file and line.

    So do exceptions of the check: a policy may answer what can be neither compared nor looked up.
    """
    try:
        return check(ask())
    except (WarehouseError, *PASSED_ON):
        raise
    except BaseException as error:
        file = sys.modules[type(policy).__module__].__file__ if type(policy).__module__ in sys.modules else None
        frames = traceback.extract_tb(error.__traceback__)
        own = [frame for frame in frames if frame.filename == file]
        if not own:  # called with other arguments than it has, or its answer cannot be checked
            raise fault(kind, policy, now, f"raised {shown(error)}") from error
        text = f"raised {shown(error)} in {own[-1].filename}, line {own[-1].lineno}"
        raise PolicyError(f"policies.{kind} ({type(policy).__name__}) at time {now:g}: {text}") from error


def place_in(error: BaseException, policies: Iterable[str]) -> str:
    """Return the place in a user's policy at which a traceback ends; empty if it ends elsewhere."""
    places = [name.rpartition(":")[0] for name in policies]
    modules = (sys.modules[place] for place in places if place in sys.modules)
    files = {*places, *(module.__file__ for module in modules)}
    own = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename in files]
    return f" in {own[-1].filename}, line {own[-1].lineno}" if own else ""


def asked_for_all(
    kind: str,
    policy: object,
    now: float,
    ask: Callable[[], object],
    check: Callable[[list[Any]], Answer],
    expected: str,
) -> Answer:
    """Return `asked` for a list of all answers; raises PolicyError, with the `expected` answer, for anything else."""

    def whole(answer: Any) -> Answer:
        if not hasattr(answer, "__iter__"):
            raise fault(kind, policy, now, f"returned {short(answer)}, expected {expected}")
        return check(list(answer))

    return asked(kind, policy, now, ask, whole)


def fault(kind: str, policy: object, now: float, text: str) -> PolicyError:
    """Make the error for an answer that cannot be carried out, with the place of the user's method that returned it."""
    return PolicyError(f"policies.{kind} ({type(policy).__name__}) at time {now:g}: {text}{_place(kind, policy)}")


def is_ours(policy: object) -> bool:
    """Whether a policy belongs to this package rather than to the user."""
    return type(policy).__module__.startswith("desim_warehouse.")


def short(answer: object) -> str:
    """Return an answer for a message, cut where it is long."""
    text = shown(answer)
    return text if len(text) <= _LONG else f"{text[: _LONG - 4]} ..."


def _place(kind: str, policy: object) -> str:
    """Return the place of the method of a user's policy; empty for our policies."""
    code = getattr(getattr(type(policy), METHODS[kind], None), "__code__", None)
    if code is None or is_ours(policy):
        return ""
    return f" ({METHODS[kind]}() in {code.co_filename}, line {code.co_firstlineno})"
