"""The code of a worker process. A study waits for its workers, so they start as fast as possible."""

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
    """Receive the place of settled fleets and the time-out, then answer batches until the parent ends.

    It sends ("hello", None) when it waits for these. Then
    come ("ready", []), ("done", outcomes) after each batch, and ("failed", text) for an error of ours. Meanwhile it is
    told which runs are to be stopped.
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
    """A batch for a worker: designs of one base model, which is sent along the first time.

    Base models are known by the order in which they came.
    """

    number: int
    base: Model | None
    runs: list[Wanted]


class Given(NamedTuple):
    """A batch that the worker was given, with the stop signal of each of its runs."""

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

    Ctrl-C is left to the parent, which ends the process with what policies start in it: hence a process group. On Linux
    it ends when a parent is killed, too, elsewhere at the next message. No garbage is collected while modules are
    imported, and numerical libraries start no threads of their own: there is a worker for every processor.
    """
    gc.disable()
    alone()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "setpgid"):
        os.setpgid(0, 0)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_END_WITH_PARENT, signal.SIGKILL)
