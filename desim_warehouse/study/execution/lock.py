"""One study at a time in a folder: a lock that the operating system releases, however a study ends."""

from __future__ import annotations

import os
import platform
import sys
from typing import TYPE_CHECKING

from desim_warehouse.errors import StudyError

if TYPE_CHECKING:
    from pathlib import Path


class FolderLock:
    """Held from its creation until `release`, or until the process ends, even by kill -9."""

    def __init__(self, folder: Path) -> None:
        """Take the lock.

        Raises:
            StudyError: where another study holds it: which process, on which machine.
        """
        self.path = folder / ".lock"
        self.file = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            _lock(self.file)
        except OSError:
            holder = self._holder()
            os.close(self.file)
            raise StudyError(
                f"{folder}: another study is at work there ({holder}); wait for it, or use another folder"
            ) from None
        os.ftruncate(self.file, 0)
        os.pwrite(self.file, f"process {os.getpid()} on {platform.node()}".encode(), 0) if hasattr(
            os, "pwrite"
        ) else os.write(self.file, b"another process")

    def _holder(self) -> str:
        try:
            return self.path.read_text(encoding="utf-8").strip() or "another process"
        except OSError:
            return "another process"

    def release(self) -> None:
        """Release the lock."""
        os.close(self.file)


if sys.platform == "win32":
    import msvcrt

    def _lock(file: int) -> None:
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
