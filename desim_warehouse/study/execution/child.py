"""What a worker process does. A study waits for its workers, so they begin as fast as they can."""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.model import Model
    from desim_warehouse.study.execution.work import Bench, Outcome, Wanted

_bench: Bench | None = None


def prepare() -> None:
    """Before our code and numpy are imported, which a first message brings about.

    Ctrl-C is left to the parent, and the process ends when the parent does. No garbage is collected while modules
    are read, and numerical libraries start no threads of their own: there is a worker for every processor.
    """
    gc.disable()
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def begin(base: Model) -> int:
    """Take the base model, and say which process this is."""
    from desim_warehouse.study.execution.work import Bench

    global _bench  # noqa: PLW0603 - what a worker process is set up with
    _bench = Bench(base)
    gc.freeze()
    gc.enable()
    return os.getpid()


def work(batch: Sequence[Wanted], timeout: float | None) -> list[Outcome]:
    """Simulate a batch."""
    assert _bench is not None
    return _bench.batch(batch, timeout)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
