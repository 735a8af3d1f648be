"""What a worker process does. A study waits for its workers, so they begin as fast as they can."""

from __future__ import annotations

import ctypes
import gc
import multiprocessing
import os
import signal
import sys
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from desim_warehouse.model import Model
    from desim_warehouse.study.execution.work import Bench, Outcome, Wanted

_END_WITH_PARENT = 1  # PR_SET_PDEATHSIG of Linux

_bench: Bench | None = None
_process: int | None = None


def prepare() -> None:
    """Before our code and numpy are imported, which a first message brings about.

    Ctrl-C is left to the parent, and the process ends when the parent does. It has a process group of its own, so
    that the parent can end it with what policies start in it. No garbage is collected while modules
    are read, and numerical libraries start no threads of their own: there is a worker for every processor.
    """
    gc.disable()
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "setpgid"):
        os.setpgid(0, 0)
    if sys.platform == "linux":  # a policy in C code may not let the thread below have its turn
        ctypes.CDLL(None).prctl(_END_WITH_PARENT, signal.SIGKILL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def begin(base: Model) -> None:
    """Take the base model; the answer is this worker's hello."""
    from desim_warehouse.study.execution.work import Bench

    global _bench, _process  # noqa: PLW0603 - what a worker process is set up with
    _bench = Bench(base)
    _process = os.getpid()
    gc.freeze()
    gc.enable()


def work(batch: Sequence[Wanted], timeout: float | None) -> list[Outcome]:
    """Simulate a batch."""
    assert _bench is not None
    outcomes = _bench.batch(batch, timeout)
    if os.getpid() != _process:  # a policy forked: the copy has nothing to say
        os._exit(0)
    return outcomes


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    if hasattr(os, "killpg"):
        os.killpg(0, signal.SIGKILL)
    os._exit(1)
