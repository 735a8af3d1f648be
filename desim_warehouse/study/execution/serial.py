"""One run after the other, in this process."""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

from desim_warehouse.study.execution.work import Bench

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from types import TracebackType

    from desim_warehouse.model import Model
    from desim_warehouse.study.execution.work import Outcome, Wanted


class Serial:
    """Simulates here."""

    def __init__(self, base: Model, timeout: float | None) -> None:
        self.bench = Bench(base)
        self.timeout = timeout

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Nothing is left behind."""

    def run(self, wanted: Sequence[Wanted], done: Callable[[int, Outcome], None]) -> None:
        """Simulate every wanted run, in this order."""
        for position, one in enumerate(wanted):
            done(position, self.bench.run(one, self.timeout))
