"""Storage of finished runs in an append-only journal, so that a kill at any instant loses none of them.

A study folder holds

    runs.jsonl        the journal: a line for each finished run, with a checksum, synced to disk
    results.parquet   the table of the study, made from the journal, replaced as a whole
    study.json        the resolved study: base model, points and their models, seeds, versions
    .lock             held while a study is running there

A line of the journal is `checksum {"model": ..., "seed": ..., "version": ..., "values": {...}, ...}`. The content of
its model, its seed and our version identify a run, so that a study with more values or replications finds existing
runs. Damaged lines, such as one cut short by a kill, are ignored: their runs are repeated, and `notes` reports this.
Only the journal counts; results.parquet can be rebuilt from it.

Only one study at a time may use a folder. It holds a lock, which the operating system releases however the study ends.
"""

from __future__ import annotations

import errno
import json
import os
import platform
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Annotated, NoReturn, Self

from pydantic import BaseModel, Field

from desim_warehouse._version import __version__
from desim_warehouse.errors import StudyError, path_of, reason
from desim_warehouse.folders import JOURNAL, LOCK, RUN, make_folder
from desim_warehouse.study.execution.cache import Cache, intact, sealed
from desim_warehouse.study.execution.locks import lock
from desim_warehouse.study.execution.work import Outcome


class FolderLock:
    """A lock held from its creation until `release`, or until the process ends, even by kill -9."""

    def __init__(self, folder: Path) -> None:
        """Take the lock.

        Raises:
            StudyError: another study holds the lock; the message names its process and machine.
        """
        self.path = folder / LOCK
        self.file = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            lock(self.file)
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


_SYNC = 0.5  # seconds of results that a power cut may lose; a kill loses none


class Entry(BaseModel, strict=True):
    """A line of the journal, which is a finished run; whole numbers fit into a table column."""

    model: str
    seed: int
    version: str
    values: dict[str, Annotated[int, Field(ge=-(2**63), lt=2**63)] | float]
    time: float
    error: str | None = None
    final: bool = True
    deterministic: bool = False


class Store:
    """The finished runs of a folder or of the user's cache or, without either, of this process only."""

    def __init__(
        self,
        folder: Path | None,
        say: Callable[[str], None],
        *,
        cache: Cache | None = None,
        read_only: bool = False,
        version: str | None = None,
    ) -> None:
        """Open a folder, which is created if needed, and read the runs of this or the given version from its journal.

        Without a folder, runs are read from the cache, model by model on request, and kept there.

        Raises:
            StudyError: where another study is running there, or the folder cannot be used.
        """
        self.folder = folder
        self.say = say
        self.cache = cache
        self.recalled: set[str] = set()  # models whose runs were read from the cache
        self.version = version or __version__
        self.runs: dict[tuple[str, int], Outcome] = {}
        self.again: set[tuple[str, int]] = set()  # runs whose error may not happen again
        self.foreign: dict[str, int] = {}  # runs of other versions, by version
        self.file: int | None = None
        self.lock: FolderLock | None = None
        self.end = 0  # of the last whole line
        self.synced = monotonic()
        if folder is not None:
            self._open(folder, read_only=read_only)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def get(self, model: str, seed: int) -> Outcome | None:
        """Return the outcome of a run, or None if it is not finished."""
        self._recall(model)
        return self.runs.get((model, seed))

    def missing(self, model: str, seed: int) -> bool:
        """Whether a run is still to be done: it is not stored, or it failed with an error that may not recur."""
        self._recall(model)
        return (model, seed) not in self.runs or (model, seed) in self.again

    def add(self, model: str, seed: int, outcome: Outcome) -> None:
        """Store a finished run.

        Raises:
            StudyError: the run cannot be written, such as on a full disk; earlier runs are kept.
        """
        if self.file is not None:
            self._write(_line(model, seed, outcome))
        elif self.cache is not None and outcome.final:
            self.cache.keep(model, _line(model, seed, outcome))
        self.runs[model, seed] = outcome
        self.again.discard((model, seed))

    def reload(self) -> None:
        """Read the journal again, since after Ctrl-C it may be one run ahead of this store."""
        if self.folder is not None:
            say, self.say = self.say, lambda _: None
            self.runs.clear()
            self._read(self.folder / JOURNAL, mend=False)
            self.say = say

    def close(self) -> None:
        """Flush everything to disk and release the lock."""
        if self.cache is not None:
            self.cache.close()
        if self.file is not None:
            os.fsync(self.file)
            os.close(self.file)
            self.file = None
        if self.lock is not None:
            self.lock.release()
            self.lock = None

    # The journal

    def _recall(self, model: str) -> None:
        """Read the runs of a model from the cache, once. Damaged lines are not used."""
        if self.cache is not None and model not in self.recalled:
            self.recalled.add(model)
            for line in self.cache.lines(model):
                self._take(line)

    def _open(self, folder: Path, *, read_only: bool) -> None:
        if not read_only and (folder / RUN).exists():
            raise StudyError(f"{folder}: holds a run; a study needs a folder of its own")
        try:
            if not read_only:
                make_folder(folder)
                self.lock = FolderLock(folder)
            self._read(folder / JOURNAL, mend=not read_only)
            if not read_only:
                flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
                self.file = os.open(folder / JOURNAL, flags, 0o644)
        except OSError as error:
            self.close()
            raise StudyError(f"{path_of(folder)}: cannot be used as a study folder ({reason(error)})") from error

    def _read(self, path: Path, *, mend: bool) -> None:
        """Take over the journal. `mend` cuts off a last line that was never finished."""
        try:
            content = path.read_bytes()
        except FileNotFoundError:
            return
        damaged = 0
        self.end = content.rfind(b"\n") + 1
        for line in content[: self.end].splitlines():
            damaged += not self._take(line)
        torn = len(content) - self.end
        if torn and mend:
            os.truncate(path, self.end)
        if damaged:
            self.say(f"{path}: {_runs(damaged)} damaged and not used; done again where needed")
        if torn:
            self.say(f"{path}: the last line was cut short when the study was stopped; that run is done again")
        for version, count in self.foreign.items():
            anew = f"{self.version} simulates anew"
            self.say(f"{path}: {_runs(count)} of version {version} not used again, but kept; {anew}")

    def _take(self, line: bytes) -> bool:
        """Take a line of the journal, and return False if it is damaged."""
        try:
            data = json.loads(intact(line))
            if b"\\u" in line:
                json.dumps(data, ensure_ascii=False).encode()  # fails at a lone surrogate, which no table holds
            entry = Entry.model_validate(data)
        except (ValueError, RecursionError):
            return False
        if entry.version != self.version:
            self.foreign[entry.version] = self.foreign.get(entry.version, 0) + 1
            return True
        key = (entry.model, entry.seed)
        outcome = Outcome(entry.values, entry.time, entry.error, entry.final, entry.deterministic)
        self.runs[key] = outcome
        (self.again.discard if outcome.final else self.again.add)(key)
        return True

    def _write(self, line: bytes) -> None:
        assert self.file is not None
        try:
            written = os.write(self.file, line)
            if written < len(line):  # the disk is full in the middle of a line
                self._give_up(OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
            self.end += written
            if monotonic() - self.synced > _SYNC:
                os.fsync(self.file)
                self.synced = monotonic()
        except OSError as error:
            self._give_up(error)

    def _give_up(self, error: OSError) -> NoReturn:
        """Cut the journal to whole lines when the disk is full or gone, and raise an error that lists what is kept."""
        assert self.folder is not None
        with suppress(OSError):  # a torn line is cut off when the journal is read next
            os.truncate(self.folder / JOURNAL, self.end)
        raise StudyError(
            f"{self.folder / JOURNAL}: cannot be written ({reason(error)}); finished runs are kept: "
            "make room and start the study again"
        ) from error


def _line(model: str, seed: int, outcome: Outcome) -> bytes:
    entry: dict[str, object] = {
        "model": model,
        "seed": seed,
        "version": __version__,
        "values": outcome.values,
        "time": outcome.run_time,
    }
    if outcome.deterministic:
        entry["deterministic"] = True
    if outcome.error is not None:
        entry |= {"error": outcome.error, "final": outcome.final}
    return sealed(entry)


def _runs(count: int) -> str:
    return f"{count} run is" if count == 1 else f"{count} runs are"
