"""Folders: where results are written, and where files lie that people copy (models/gallery, reports)."""

from __future__ import annotations

import errno
import hashlib
import os
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Literal

from desim_warehouse.errors import spoken

_DEEPEST = 200
"""Folders inside one another; `Path.mkdir` takes a call for each, and Python allows some hundred."""
PLACES = {"gallery": "models/gallery", "notebooks": "reports"}
"""A folder of the installed package, and where it is in the source tree; pyproject.toml says the same to the wheel."""
ANSWER = "answer.json"
"""The answer to a question, in the folder of its runs."""
RUN, STUDY, JOURNAL, RESULTS = "run.json", "study.json", "runs.jsonl", "results.parquet"
"""The files by which folders of runs and studies are recognised; the finished runs of a study, and their table."""
PAGE = "report.html"
"""The page of a run or an answer, in its folder."""
LOCK = ".lock"
"""Held while a study is running in its folder."""
_OURS = {
    **dict.fromkeys((RUN, STUDY, ANSWER), re.compile(rb'\A\{\s*"format": ?\d')),
    JOURNAL: re.compile(rb'^[0-9a-f]{8} \{"model":', re.MULTILINE),  # its first line may be damaged
    LOCK: re.compile(rb"\A(process \d+ on|another process)"),
    "kpis.csv": re.compile(rb"\Aindicator,value,unit\r?\n"),
    "kpis.parquet": re.compile(rb'\APAR1.*"name": ?"indicator"', re.DOTALL),
}
"""What nobody else writes into files of these names: a folder with one of them is ours."""
MAKER = "desim-warehouse"
"""Who made a picture, as its file says."""
Made = Literal["page", "notebook", "picture", "trace", "messages"]
_MADE: dict[Made, re.Pattern[bytes]] = {
    "page": re.compile(rb"""<meta http-equiv="Content-Security-Policy" content="default-src 'none'"""),
    "notebook": re.compile(rb'\A\{\s*"cells".*"folder = ', re.DOTALL),
    "picture": re.compile(MAKER.encode()),
    "trace": re.compile(rb'\A\{"traceEvents":'),
    "messages": re.compile(rb'\A\{"headerId":.*"manufacturer":"desim-warehouse"'),
}
"""Text that stands in files that we make, by kind, and hardly in files of others."""
_BEGINNING = 65_536
"""Bytes in which it stands."""


def make_folder(folder: Path, mode: int = 0o777) -> None:
    """Make a folder, and those above it, unless they are there. `mode`: who may use it, less the process's umask.

    Raises:
        OSError: where that cannot be.
    """
    if len(folder.parts) > _DEEPEST:
        raise OSError(errno.ENAMETOOLONG, f"more than {_DEEPEST} folders inside one another", str(folder))
    folder.mkdir(mode, parents=True, exist_ok=True)


@contextmanager
def filled_folder(folder: Path) -> Iterator[None]:
    """Make a folder for what is written within the context; if it stays empty, as on Ctrl-C, what was made goes again.

    Raises:
        OSError: where that cannot be.
    """
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        make_folder(folder)
        yield
    finally:
        for path in missing:
            with suppress(OSError):  # it holds something
                path.rmdir()


def refuse_theirs(folder: Path, files: Iterable[str]) -> None:
    """Refuse to write `files` into a folder that holds some of these names, and nothing by which it is known as ours.

    Raises:
        OSError: which files of somebody else would be overwritten; or they cannot be looked at.
    """
    theirs = [name for name in files if (folder / name).exists() and (folder / name).stat().st_size]
    if theirs and not any(_is_ours(folder / name, words) for name, words in _OURS.items()):
        are = "are files" if len(theirs) > 1 else "is a file"
        raise OSError(errno.EPERM, f"{spoken(theirs)} {are} of somebody else; expected another folder", str(folder))


def refuse_other(path: Path, made: Made) -> None:
    """Refuse to overwrite a file that is there and not of a kind that we make.

    Raises:
        OSError: a file of somebody else, or one that cannot be read.
    """
    if path.is_file() and path.stat().st_size and not _is_ours(path, _MADE[made]):
        raise OSError(errno.EPERM, "a file of somebody else is there; expected another name", str(path))


def drop_page(folder: Path, name: str, text: str) -> None:
    """Remove the page, and the replay, that `desim report` made of a folder, unless its file holds this text already.

    Their figures would be those of another run or answer.
    """
    file = folder / name
    if file.exists() and file.read_text(encoding="utf-8", errors="replace") == text:
        return
    for path in (folder / PAGE, folder / f"{Path(PAGE).stem}-replay.html"):
        if _is_ours(path, _MADE["page"]):
            path.unlink()


def _is_ours(path: Path, words: re.Pattern[bytes]) -> bool:
    """Whether a file is there and reads as we write it."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return words.search(file.read(_BEGINNING)) is not None


def shipped(kind: str) -> Path:
    """Return the folder with files of a kind: in the installed package, or in the source tree."""
    home = Path(__file__).parent
    installed = home / kind
    return installed if installed.is_dir() else home.parent / PLACES[kind]


def gallery() -> dict[str, Path]:
    """Return the model files of the gallery, by name."""
    return {path.stem: path for path in sorted(shipped("gallery").glob("*.yaml"))}


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


OLDEST = (0, 3)
"""The oldest version whose folders are read."""


def too_old(version: str) -> str | None:
    """Return why folders of a version are not read, and which version reads them; None where they are read."""
    made = tuple(int(part) for part in version.split(".")[:2] if part.isdecimal())
    return None if made >= OLDEST else f"of version {version}, expected 0.3 or later; desim-warehouse 0.3.0 reads it"


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Yield the path of a file to write, which replaces `path` at the end of the context; if that fails, it goes."""
    if path.exists() and not path.is_file():  # such as a terminal or a pipe
        yield path
        return
    path = Path(os.path.realpath(path))  # of a link the file itself; `resolve` fails on a link to itself
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def write_whole(path: Path, text: str) -> None:
    """Write a file atomically."""
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8")
