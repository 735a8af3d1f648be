"""A policy is called for its answer, and errors in its code are reported with their file and line."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import TypeVar

from desim_warehouse.errors import PASSED_ON, PolicyError, WarehouseError, shown

Answer = TypeVar("Answer")


def asked(kind: str, policy: object, now: float, ask: Callable[[], Answer]) -> Answer:
    """The answer of a policy. What it raises becomes a PolicyError that says where."""
    try:
        return ask()
    except (WarehouseError, *PASSED_ON):
        raise
    except BaseException as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        raise PolicyError(
            f"policies.{kind} ({type(policy).__name__}) at time {now:g}: raised {shown(error)} "
            f"in {last.filename}, line {last.lineno}"
        ) from error
