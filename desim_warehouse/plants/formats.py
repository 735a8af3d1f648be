"""The formats of other programs that can be read, and how a file is told to be of one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from desim_warehouse.errors import ModelError
from desim_warehouse.plants import opentcs
from desim_warehouse.plants.file import content_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from desim_warehouse.plants.plant import Plant

_START = 4096  # bytes that show what a file is


@dataclass(frozen=True, slots=True)
class Format:
    """A format.

    Attributes:
        title: what a file of it is, for messages and help.
        looks: whether a file may be of it, by its path and its first 4,096 bytes without blanks before them; the first
            format that says yes reads the file and says what is wrong with it.
        read: reads it; raises ModelError with the place.
    """

    title: str
    looks: Callable[[Path, bytes], bool]
    read: Callable[[Path, bytes], Plant]


FORMATS = (Format("a plant model of openTCS (XML, versions 0.0.2 to 7.0.0)", opentcs.looks, opentcs.read),)


def read_plant(path: str | Path) -> Plant:
    """What a foreign file holds: points, links, locations, vehicles.

    Args:
        path: a file in one of `FORMATS`.

    Raises:
        ModelError: where it cannot be read, with the line.
    """
    path, expected = Path(path), " or ".join(one.title for one in FORMATS)
    content = content_of(path, expected)
    start = content[:_START].removeprefix(b"\xef\xbb\xbf").lstrip()
    for one in FORMATS:
        if one.looks(path, start):
            return one.read(path, content)
    raise ModelError([f"{path}: not a layout that can be read, expected {expected}"])
