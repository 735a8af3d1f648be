"""Calls of `desim` by the hundred: each in a fork of one process that has imported all, with limits of its own.

`python -m tests.cli.forks` reads a list of argument lists (JSON) from its input and writes a line of JSON for each.
"""

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
SECONDS, BYTES = 10, 1 << 30
PATIENCE = 60
"""Seconds on the clock after which a call that does not use the processor is ended."""


class Done(NamedTuple):
    """How a call ended: exit status (negative: the signal), what it printed, processor time and memory it took."""

    status: int
    out: str
    err: str
    seconds: float
    bytes: int

    @property
    def said(self):
        """The lines of its message, without click's hint on how to get help."""
        return [line for line in self.err.splitlines() if line and not line.startswith(("Usage:", "Try '"))]

    def faults(self):
        """What is wrong with the answer to something that cannot be done."""
        faults = [] if self.status == 2 else [f"exit status {self.status}"]
        faults += [] if self.said else ["no message"]
        faults += [f"{len(self.said)} lines"] if len(self.said) > 51 else []  # several problems are told at once
        faults += [f"a line of {max(map(len, self.said))}"] if max(map(len, self.said), default=0) > 6000 else []
        faults += [word for word in ("Traceback", "Errno") if word in self.out + self.err]
        faults += [f"{self.seconds:.1f} s"] if self.seconds > SECONDS else []
        faults += [f"{self.bytes >> 20} MiB"] if self.bytes > BYTES else []
        return [*faults, f"{self.out[-300:]!r} {self.err[-600:]!r}"] if faults else []


def call_all(calls, folder):
    """Call `desim` in `folder` with each of these arguments."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.cli.forks", str(folder)],
        cwd=ROOT,
        input=json.dumps(calls),
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
    )
    endings = [Done(*json.loads(line)) for line in done.stdout.splitlines()]
    assert len(endings) == len(calls), done.stderr
    return endings


def _call(arguments):
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        child = os.fork()
        if not child:
            _child(arguments, out.fileno(), err.fileno())
        _, status, used = os.wait4(child, 0)
        printed = []
        for file in (out, err):
            file.seek(0)
            printed.append(file.read(1 << 20).decode("utf-8", "backslashreplace"))
    seconds = used.ru_utime + used.ru_stime
    return Done(os.waitstatus_to_exitcode(status), *printed, seconds, used.ru_maxrss * 1024)


def _child(arguments, out, err):
    from desim_warehouse.cli import main

    os.dup2(out, 1)
    os.dup2(err, 2)
    resource.setrlimit(resource.RLIMIT_CPU, (2 * SECONDS, 2 * SECONDS + 1))
    resource.setrlimit(resource.RLIMIT_AS, (4 * BYTES, 4 * BYTES))
    signal.alarm(PATIENCE)
    sys.argv = ["desim", *arguments]
    status = 70
    try:
        main()
        status = 0
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else int(end.code is not None)
        if isinstance(end.code, str):
            sys.stderr.write(end.code)
    except BaseException:  # noqa: BLE001 - shown as Python would
        import traceback

        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _serve():
    from desim_warehouse.cli import COMMANDS, desim

    for heavy in ("matplotlib.figure", "pandas", "pyarrow.parquet", "scipy.stats", "desim_warehouse.study.study"):
        import_module(heavy)
    assert all(desim.get_command(None, name) for name in COMMANDS)
    calls = json.load(sys.stdin)
    os.chdir(sys.argv[1])
    for arguments in calls:
        sys.stdout.write(json.dumps(_call(arguments)) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    _serve()
