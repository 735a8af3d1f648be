"""As many processes as are worth it: a short study is over before a worker process has started."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from desim_warehouse.study.execution.pool import Pool
    from desim_warehouse.study.execution.work import Outcome, Serial, Wanted

ALONE = 1.0
"""Seconds of runs in this process: about as long as worker processes take to start."""


class Auto:
    """The executor that simulates in this process at first, and in a pool what is then left."""

    def __init__(self, alone: Serial, pool: Pool) -> None:
        self.alone = alone
        self.pool = pool
        self.left = ALONE if pool.timeout is None else 0.0  # a pool can kill what runs too long

    def run(self, wanted: Sequence[Wanted]) -> Generator[tuple[int, Outcome]]:
        """Simulate every wanted run; raises as `Pool.run`."""
        first = 0
        while first < len(wanted) and self.left > 0:
            for _, outcome in self.alone.run([wanted[first]]):
                self.left -= outcome.run_time
                yield first, outcome
            first += 1
        for position, outcome in self.pool.run(wanted[first:]):
            yield first + position, outcome

    def close(self) -> None:
        """End all processes."""
        self.pool.close()
