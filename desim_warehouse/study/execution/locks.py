"""File locks that the operating system releases however a process ends.

For the journals of studies and of the user's cache.
"""

from __future__ import annotations

import errno
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep

if sys.platform == "win32":
    import msvcrt

    def lock(file: int) -> None:
        """Lock an open file; raises OSError where another process has."""
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)

    def unlock(file: int) -> None:
        """Release the lock of an open file."""
        msvcrt.locking(file, msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    def lock(file: int) -> None:
        """Lock an open file; raises OSError where another process has."""
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def unlock(file: int) -> None:
        """Release the lock of an open file, and of copies of it that a fork made."""
        fcntl.flock(file, fcntl.LOCK_UN)


_POLL = 0.02  # seconds between two attempts at a lock
_TAKEN = {errno.EAGAIN, errno.EACCES, errno.EDEADLK}


@contextmanager
def turn(path: Path, patience: float, waiting: Callable[[], object]) -> Iterator[None]:
    """Run a block in one process at a time (mutual exclusion), by the lock of a file, which is created if needed.

    A process enters without the lock after `patience` seconds, since another may be halted, and where files cannot be
    locked. `waiting` is called between two attempts, and may raise to end the wait.
    """
    try:
        file = path.open("ab")
    except OSError:  # a full or read-only disk
        yield
        return
    with file:  # closed even where a time-out strikes before this line, as nothing else refers to it
        end = monotonic() + patience
        while not (held := _is_locked(file.fileno())) and monotonic() < end:
            sleep(_POLL)
            waiting()
        try:
            yield
        finally:
            if held:
                with suppress(OSError):
                    unlock(file.fileno())


def _is_locked(file: int) -> bool:
    """Whether the file is locked for us now, or cannot be locked at all."""
    try:
        lock(file)
    except OSError as error:
        return error.errno not in _TAKEN
    return True
