"""Settled fleets kept in the user's cache, so that each design settles only once, in whichever process comes first.

Each fleet is a line of its own journal, `settled-MODEL.jsonl`, under the digest of the model of its settling run;
`cache` describes how damaged, full or read-only caches are treated. A process that needs a fleet waits while another
process computes it. If that process is killed, its lock is released, and one of the waiting processes starts over.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory

from desim_warehouse.model import Model
from desim_warehouse.study.execution.cache import Cache, intact, sealed
from desim_warehouse.study.execution.locks import turn
from desim_warehouse.world.robots.settled import Fleet, SettledFleets, Standing

_PATIENCE = 120.0
"""Seconds after which a process stops waiting for another, which may have been halted."""
_LOCKS = 2
"""Digits of a digest that name its lock: at most 256 files, and two designs of a question rarely share one."""


class KeptFleets(SettledFleets):
    """Settled fleets that processes share in a folder of journals; without a folder, in this process only."""

    def __init__(self, folder: Path | None = None) -> None:
        super().__init__()
        self._folder = folder

    @property
    def folder(self) -> Path | None:
        """The folder that keeps the fleets; None if no folder can."""
        return None if self.cache is None else self.cache.folder

    @cached_property
    def cache(self) -> Cache | None:
        """The cache that keeps the fleets."""
        return None if self._folder is None else Cache(_in_silence, self._folder)

    def once(
        self, model: Model, settle: Callable[[], Sequence[Fleet]], waiting: Callable[[], object]
    ) -> Sequence[Fleet]:
        """Look up the fleets of a model's settling run, or have one process at a time simulate it."""
        if self.cache is None or self.cache.folder is None:
            return settle()
        digest = model.digest()
        kept = _kept(self.cache, digest)
        if kept is not None:
            return kept
        with turn(self.cache.folder / f".settling-{digest[:_LOCKS]}", _PATIENCE, waiting):
            kept = _kept(self.cache, digest)  # of the process that was waited for
            if kept is not None:
                return kept
            fleets = settle()
            self.cache.keep(f"settled-{digest}", sealed({"model": digest, "fleets": fleets}))
        return fleets


class FleetsOfACommand(KeptFleets):
    """Settled fleets in the user's cache or, without it, in a temporary folder of the command."""

    def __init__(self, *, cache: bool) -> None:
        super().__init__()
        self._cached = cache
        self._own: TemporaryDirectory[str] | None = None

    @cached_property
    def cache(self) -> Cache | None:
        """The cache that keeps the fleets, opened on first use."""
        if self._cached:
            return Cache(_in_silence)
        try:
            self._own = TemporaryDirectory(prefix="desim-", ignore_cleanup_errors=True)
            folder = Path(self._own.name, "runs")
            folder.mkdir()
        except OSError:  # no room: each process has its own fleets
            return None
        return Cache(_in_silence, folder)

    def close(self) -> None:
        """Remove the folder of the command."""
        if self._own is not None:
            self._own.cleanup()


def _kept(cache: Cache, digest: str) -> Sequence[Fleet] | None:
    """Return the settled fleets of a model from a cache; None if there is no intact record."""
    for line in reversed(cache.lines(f"settled-{digest}")):
        with suppress(ValueError, KeyError, TypeError):
            content = json.loads(intact(line))
            if content["model"] == digest:
                return [tuple(Standing(*robot) for robot in fleet) for fleet in content["fleets"]]
    return None


def _in_silence(_: str) -> None:
    """Print nothing, because the store of runs already reports problems of the cache."""
