"""As many processes as are worth it: a short study is over before a worker process has started."""

from __future__ import annotations

from typing import TYPE_CHECKING

from desim_warehouse.study.execution.handle import Handle

if TYPE_CHECKING:
    from collections.abc import Generator, Sequence

    from desim_warehouse.study.execution.pool import Pool
    from desim_warehouse.study.execution.work import Serial, Wanted

ALONE = 1.0
"""Seconds of runs in this process: about as long as worker processes take to start."""


class Auto:
    """The executor that simulates in this process at first, and in a pool what is then left."""

    def __init__(self, alone: Serial, pool: Pool) -> None:
        self.alone = alone
        self.pool = pool
        self.left = ALONE if pool.timeout is None else 0.0  # a pool can kill what runs too long

    def submit(self, run: Wanted) -> Handle:
        """Have a run simulated, as soon as somebody waits for it."""
        return Handle(run, self._stop)

    def ended(self, handles: Sequence[Handle]) -> Generator[Handle]:
        """These runs, each as soon as it has ended; raises as `Pool.ended`."""
        first = 0
        while first < len(handles) and self.left > 0:
            for handle in self.alone.ended([handles[first]]):
                self.left -= 0.0 if handle.outcome is None else handle.outcome.run_time
                yield handle
            first += 1
        for handle in handles[first:]:
            self.pool.add(handle)
        yield from self.pool.ended(handles[first:])

    def close(self) -> None:
        """End all processes."""
        self.pool.close()

    def _stop(self, handle: Handle) -> None:
        self.alone.stop(handle)
        self.pool.stop(handle)
