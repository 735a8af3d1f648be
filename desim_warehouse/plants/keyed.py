"""Reading of JSON files by tables of the keys that they must and may have, leniently or strictly; for LIF.

Leniently, clear deviations are corrected, and wrong values that are not needed are left out, each noted with its
position. Strictly, all of these are refused.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NoReturn, TypeAlias

from desim_warehouse.errors import ModelError, got
from desim_warehouse.model.messages import printable
from desim_warehouse.plants.plant import Plant
from desim_warehouse.values.fields import LIMITS

_MOST = 20  # problems in one error, at most
_WRONG = 500_000  # values
_LARGEST = LIMITS["number"][0]
_FLAGS = {"true": True, "false": False}
_GONE: Any = object()
POSITION = "\0place"
"""Key under which an object that was read holds its position in the file."""


@dataclass(frozen=True, slots=True)
class Text:
    """The kind of a text; `one_of`: the allowed texts, empty for any."""

    one_of: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Number:
    """The kind of a number from `least` to `most`."""

    least: float = -math.inf
    most: float = math.inf


@dataclass(frozen=True, slots=True)
class Flag:
    """The kind of a truth value."""


@dataclass(frozen=True, slots=True)
class Each:
    """The kind of a list of values of one kind."""

    item: Kind


@dataclass(frozen=True, slots=True)
class Section:
    """The kind of an object: keys `required` by the format, keys `needed` by our reader, and all known `keys`."""

    keys: Mapping[str, Kind]
    required: frozenset[str]
    needed: frozenset[str] = frozenset()


Kind: TypeAlias = Text | Number | Flag | Each | Section
_WORDS = {Text: "text", Number: "a number", Flag: "true or false", Each: "a list", Section: "an object"}


def section(keys: Mapping[str, Kind], required: str = "", needed: str = "") -> Section:
    """Return a section; `required` and `needed` name keys, separated by blanks."""
    return Section(keys, frozenset(required.split()), frozenset(needed.split()))


@dataclass
class Reader:
    """Reader of values by a table; `faults` maps faults of the file (text, remedy) to their positions.

    `unknown` holds the keys that are not in the table, which are left out.

    Args:
        file: the name of the file in messages.
        strict: whether every deviation from the format is an error.
        complete: whether missing keys that the format requires are faults even if they are not needed.
    """

    file: str
    strict: bool
    complete: bool = True
    faults: dict[tuple[str, str], list[str]] = field(default_factory=dict)
    count: int = 0
    unknown: list[tuple[tuple[str, ...], str]] = field(default_factory=list)

    def read(self, value: Any, kind: Kind, position: str) -> Any:
        """Read a value by its kind in the table.

        Raises:
            ModelError: a needed part is missing or wrong.
        """
        made = self._value(value, kind, position)
        if made is _GONE:
            self.refuse(position, f"not {_WORDS[type(kind)]} (got {got(value)}), expected it")
        return made

    def refuse(self, position: str, text: str) -> NoReturn:
        """Raise ModelError for a position."""
        raise ModelError([printable(f"{self.file}: {position}: {text}")])

    def wrong(self, position: str, text: str, become: str) -> None:
        """Note a value that the format does not allow, with its replacement (`become`).

        Raises:
            ModelError: too many such values.
        """
        self.count += 1
        if self.count > _WRONG:
            self.refuse(
                position, f"{text}, as are too many values, expected {_WRONG:,} at most that are not as they should be"
            )
        self.faults.setdefault((text, become), []).append(position)

    def finish(self, plant: Plant, letter: str) -> None:
        """Note all faults in the plant or, if strict, refuse the file; `letter` names the strict check in messages."""
        if self.strict and self.faults:
            lines = [
                f"{self.file}: {position}: {text} ({letter})"
                for (text, _), all_ in self.faults.items()
                for position in all_
            ]
            more = len(lines) - _MOST
            raise ModelError(list(map(printable, lines[:_MOST])) + [f"and {more:,} more problems"] * (more > 0))
        for (text, become), positions in self.faults.items():
            plant.note("changed", "value", list(map(printable, positions)), f"{text}; {become}")
        for keys, position in self.unknown:
            plant.see_keys(map(printable, keys), (), printable(position))

    def _value(self, value: Any, kind: Kind, position: str) -> Any:  # noqa: PLR0911 - a return for each kind
        if isinstance(kind, Section):
            return self._section(value, kind, position) if isinstance(value, dict) else self._bad(value, kind, position)
        if isinstance(kind, Each):
            if not isinstance(value, list):
                return self._bad(value, kind, position)
            made = [self._value(item, kind.item, f"{position}[{rank}]") for rank, item in enumerate(value)]
            return [item for item in made if item is not _GONE]
        if isinstance(kind, Number):
            return self._number(value, kind, position)
        if isinstance(kind, Flag):
            if isinstance(value, bool):
                return value
            if isinstance(value, str) and value.lower() in _FLAGS:
                self.wrong(position, "text for true or false", "read as meant")
                return _FLAGS[value.lower()]
            return self._bad(value, kind, position)
        return self._text(value, kind, position)

    def _section(self, value: dict[str, Any], kind: Section, position: str) -> Any:
        made: dict[str, Any] = {POSITION: position}
        if strange := tuple(key for key in value if key not in kind.keys):
            self.unknown.append((strange, position or "the top level"))
        for key, inner in kind.keys.items():
            here = f"{position}.{key}" if position else key
            if key in value:
                item = self._value(value[key], inner, here)
                if item is not _GONE:
                    made[key] = item
                elif key in kind.needed:
                    self.refuse(here, f"not {_WORDS[type(inner)]} (got {got(value[key])}), expected it")
            elif key in kind.needed:
                self.refuse(position or "the top level", f"no {key}, expected {_WORDS[type(inner)]}")
            elif key in kind.required and self.complete:
                self.wrong(position or "the top level", f"no {key}", "read without it")
        return made

    def _number(self, value: Any, kind: Number, position: str) -> Any:
        if isinstance(value, str):
            try:
                number = float(value)
            except ValueError:
                number = math.nan
            if not abs(number) <= _LARGEST:
                return self._bad(value, kind, position)
            self.wrong(position, "text for a number", "read as meant")
        elif isinstance(value, bool) or not isinstance(value, int | float):
            return self._bad(value, kind, position)
        else:
            number = value
        if not abs(number) <= _LARGEST:
            self.refuse(position, f"not a number of a layout (got {got(value)}), expected one up to {_LARGEST:,}")
        if not kind.least <= number <= kind.most:
            at_most = "" if kind.most == math.inf else f" to {kind.most:g}"
            self.wrong(position, f"out of the range from {kind.least:g}{at_most}", "taken as it is")
        return float(number)

    def _text(self, value: Any, kind: Text, position: str) -> Any:
        if isinstance(value, int | float) and not isinstance(value, bool):
            self.wrong(position, "a number for text", "read as meant")
            value = str(value)
        if not isinstance(value, str):
            return self._bad(value, kind, position)
        if not value.isascii() and any("\ud800" <= character <= "\udfff" for character in value):
            self.refuse(position, "not text (half a character), expected characters that can be written in UTF-8")
        if kind.one_of and value not in kind.one_of:
            near = value.upper()
            text = f"not one of {', '.join(kind.one_of)} (got {got(value)})"
            self.wrong(position, text, "read as meant" if near in kind.one_of else "left out")
            return near if near in kind.one_of else _GONE
        return value

    def _bad(self, value: Any, kind: Kind, position: str) -> Any:
        self.wrong(position, f"not {_WORDS[type(kind)]} (got {got(value)})", "left out")
        return _GONE
