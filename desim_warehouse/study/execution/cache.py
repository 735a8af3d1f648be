"""Cache of finished runs in a folder of the user, so that a further question simulates only new runs.

The variable DESIM_CACHE names the folder; by default it is `desim-warehouse` among the system's caches. It holds

    runs-PROGRAM/MODEL.jsonl            the finished runs of a model, each a line of a journal (see `store`)
    runs-PROGRAM/settled-MODEL.jsonl    how its fleet stands in the long run (see `kept_fleets`)

PROGRAM is the digest of our code and of the packages that results depend on; MODEL is the digest of a model and of its
own policies' code. Files are only appended to, one whole line at a time, so that commands may share the folder and a
kill loses nothing. They take at most 1 GB; the least recently used are deleted first. A failure of the cache costs time
but never an answer: runs that cannot be read are simulated again.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import platform
import stat
import sys
import zlib
from collections.abc import Callable, Mapping
from functools import cache
from importlib import metadata
from pathlib import Path

from desim_warehouse import _version
from desim_warehouse.errors import reason
from desim_warehouse.folders import make_folder

_PACKAGES = ("simpy", "networkx", "numpy", "scipy", "pydantic")


def versions() -> dict[str, str]:
    """Return the versions that results depend on: of desim-warehouse, Python and packages."""
    return {
        "desim-warehouse": _version.__version__,
        "python": platform.python_version(),
        **_versions_of_packages(),
    }


@cache
def _versions_of_packages() -> dict[str, str]:
    """Return the versions of packages, read from their files once in a process."""
    return {name: metadata.version(name) for name in _PACKAGES}


@cache
def program() -> str:
    """Return a digest of the versions and of our code, which somebody may be changing."""
    digest = hashlib.sha256(repr(sorted(versions().items())).encode())
    home = Path(_version.__file__).parent
    for path in sorted(home.rglob("*.py")):
        digest.update(f"\0{path.relative_to(home)}\0".encode() + path.read_bytes())
    return digest.hexdigest()[:16]


MOST = 1_000_000_000
"""Largest total size of all files, in bytes."""
_SWEEP = 1 / 64
"""Share of `MOST` that is written between two checks of the total size."""
_LEFT = 7 / 8
"""Share of `MOST` that a sweep leaves, so that several commands can write at once."""


def cache_folder() -> Path:
    """Return the folder of the user's cached runs: DESIM_CACHE, or below the caches of the system."""
    folder = os.environ.get("DESIM_CACHE")
    if folder:
        return Path(folder).absolute()
    if sys.platform == "win32":
        usual = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        usual = Path.home() / "Library" / "Caches"
    else:
        usual = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(usual).absolute() / "desim-warehouse"


def sealed(content: Mapping[str, object]) -> bytes:
    """Return a line of a journal, which begins with its checksum."""
    text = json.dumps(content, separators=(",", ":")).encode()
    return b"%08x %s\n" % (zlib.crc32(text), text)


def intact(line: bytes) -> bytes:
    """Return the text of a line of a journal; raises ValueError where it is damaged."""
    text = line[9:]
    if int(line[:8], 16) != zlib.crc32(text):
        raise ValueError("damaged")
    return text


class Cache:
    """The cached runs of each model; a cache that cannot be used reports this once, and is then empty."""

    def __init__(self, say: Callable[[str], None], folder: Path | None = None) -> None:
        """Open the user's cache, or another existing `folder` of journals."""
        self.say = say
        self.written = 0  # bytes since the last sweep
        self.folder = folder
        if folder is not None:
            return
        try:
            root = cache_folder()
            make_folder(root, mode=0o700)
            refuse_foreign(root)
            make_folder(root / f"runs-{program()}", mode=0o700)
        except (OSError, RuntimeError) as error:  # RuntimeError: no home folder
            self._give_up("used", error)
        else:
            self.folder = root / f"runs-{program()}"

    def lines(self, model: str) -> list[bytes]:
        """Return the whole lines of a model's journal, and mark it as the most recently used."""
        if self.folder is None:
            return []
        path = self.folder / f"{model}.jsonl"
        try:
            content = path.read_bytes()
            os.utime(path)
        except FileNotFoundError:
            return []
        except OSError as error:
            self._give_up("read", error)
            return []
        return content[: content.rfind(b"\n") + 1].split(b"\n")

    def keep(self, model: str, line: bytes) -> None:
        """Append a line to a model's journal."""
        if self.folder is None:
            return
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
        whole = b"\n" + line  # on a line of its own, even after a line cut short by a full disk
        try:
            file = os.open(self.folder / f"{model}.jsonl", flags, 0o600)
            try:
                if os.write(file, whole) < len(whole):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            finally:
                os.close(file)
        except OSError as error:
            self._give_up("written", error)
            return
        self.written += len(whole)
        if self.written > _SWEEP * MOST:
            self.sweep()

    def close(self) -> None:
        """Delete the least recently used journals if the cache is too large and anything was written."""
        if self.written and self.folder is not None:
            self.sweep()

    def sweep(self) -> None:
        """Delete the least recently used journals if the cache is too large."""
        assert self.folder is not None
        self.written = 0
        journals = []
        for path in self.folder.parent.glob("runs-*/*.jsonl"):
            try:
                is_ = path.lstat()
            except OSError:  # another command made room
                continue
            journals.append((is_.st_mtime_ns, is_.st_size, path))
        total = sum(size for _, size, _ in journals)
        if total <= (1 - _SWEEP) * MOST:
            return
        for _, size, path in sorted(journals):
            if total <= _LEFT * MOST:
                return
            path.unlink(missing_ok=True)
            total -= size

    def _give_up(self, verb: str, error: Exception) -> None:
        self.folder = None
        self.say(
            f"the cache of finished runs cannot be {verb} ({reason(error)}): the answer is the same, but runs are not "
            "kept; DESIM_CACHE names another folder, --out DIR keeps them in DIR, --no-cache does without"
        )


def refuse_foreign(folder: Path) -> None:
    """Raise PermissionError for a folder in which other users could put results."""
    if not hasattr(os, "getuid"):
        return
    status = folder.stat()
    if status.st_uid != os.getuid() or status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise PermissionError(errno.EACCES, "others may write there, expected a folder of your own (chmod 700)")
