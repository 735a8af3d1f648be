"""Code of a worker process, which starts as fast as possible, because a study waits for its workers."""

from __future__ import annotations

import ctypes
import gc
import os
import signal
import sys
import threading
from contextlib import suppress
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, NamedTuple

from desim_warehouse.study.execution.process import alone

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    from desim_warehouse.model import Model
    from desim_warehouse.run.stop import StopSignal
    from desim_warehouse.study.execution.work import Wanted

_END_WITH_PARENT = 1  # PR_SET_PDEATHSIG of Linux


def main(parent: Connection[Any, Any]) -> None:
    """Receive the folder of settled fleets and the time-out, then process batches until the parent ends.

    The worker sends ("hello", None) when it waits for these, then ("ready", []), ("done", outcomes) after each batch,
    and ("failed", text) for an error of ours. Meanwhile it receives messages about runs to stop.
    """
    _prepare()
    process = os.getpid()
    try:
        from desim_warehouse.study.execution.kept_fleets import KeptFleets
        from desim_warehouse.study.execution.work import Simulator

        parent.send(("hello", None))
        place, timeout = parent.recv()
        simulator = Simulator(KeptFleets(place))
        gc.freeze()
        gc.enable()
        parent.send(("ready", []))
        batches: SimpleQueue[Given | None] = SimpleQueue()
        threading.Thread(target=_listen, args=(parent, batches), daemon=True).start()
        while (batch := batches.get()) is not None:
            outcomes = simulator.batch(batch.base, batch.runs, timeout, batch.stops)
            if os.getpid() != process:  # a policy forked: the copy has nothing to say
                os._exit(0)
            parent.send(("done", outcomes))
    except (EOFError, ConnectionError):
        return
    except Exception as error:  # noqa: BLE001 - the parent says it, in one line
        parent.send(("failed", f"{type(error).__name__}: {error}"))


class RunBatch(NamedTuple):
    """A batch for a worker: runs of designs of one base model, which is sent along the first time.

    Base models are numbered in the order in which they were sent.
    """

    number: int
    base: Model | None
    runs: list[Wanted]


class Given(NamedTuple):
    """A batch received by a worker, with the stop signal of each of its runs."""

    base: Model
    runs: list[Wanted]
    stops: list[StopSignal]


def _listen(parent: Connection[Any, Any], batches: SimpleQueue[Given | None]) -> None:
    """Pass on batches, and stop the runs named by other messages: the number of a batch, and a run's place in it."""
    from desim_warehouse.run.stop import StopSignal

    bases: list[Model] = []
    count, stops = 0, list[StopSignal]()
    with suppress(EOFError, OSError):
        while True:
            message = parent.recv()
            if isinstance(message, RunBatch):
                if message.base is not None:
                    bases.append(message.base)
                count, stops = count + 1, [StopSignal() for _ in message.runs]
                batches.put(Given(bases[message.number], message.runs, stops))
            elif message[0] == count:
                stops[message[1]].ask()
    batches.put(None)


def _prepare() -> None:
    """Prepare the process before our code and numpy are imported.

    The parent handles Ctrl-C, and ends this process together with any that policies start in it; hence a process group.
    If the parent is killed, the process ends at once on Linux, and elsewhere at the next message. Garbage collection is
    off during imports, and numerical libraries start no threads, because there is a worker for every processor.
    """
    gc.disable()
    alone()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "setpgid"):
        os.setpgid(0, 0)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_END_WITH_PARENT, signal.SIGKILL)
