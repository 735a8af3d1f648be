"""Where every value of a model was written: line and column of a file, or the override that set it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

Keys = tuple[str | int, ...]
"""The way to a value: keys of sections and ranks in lists, as in ("fleet", "start", 0)."""


def dotted(keys: Keys) -> str:
    """Write the way to a value as people and overrides do: `fleet.start.0`."""
    return ".".join(str(key) for key in keys)


@dataclass(frozen=True, order=True)
class Place:
    """A place that a message points to; places are ordered as a reader meets them."""

    rank: int  # the model file first, then the tables it reads, overrides last
    line: int
    column: int
    said: str  # how the message names it
    names: int = field(default=0, compare=False)  # how many keys `said` stands for; 0: the message has them, too

    @classmethod
    def in_file(cls, rank: int, file: str, line: int, column: int) -> Place:
        """A line and a column of a file, both counted from 1."""
        return cls(rank, line, column, f"{file}:{line}:{column}")


_OVERRIDES = 1_000_000
_PAIR: dict[str | int, int] = {"from": 0, "to": 1}  # an edge may be written [A, B]


@dataclass
class Places:
    """Places of the keys and values of one model."""

    source: str
    keys: dict[Keys, Place] = field(default_factory=dict)
    values: dict[Keys, Place] = field(default_factory=dict)
    _overrides: dict[Keys, Place] = field(default_factory=dict)
    _tables: int = 0

    def of(self, keys: Keys, *, at_key: bool = False) -> Place:
        """The place of a value (or of its key), or of the nearest section around it that has one."""
        for size in range(len(keys), -1, -1):
            part = keys[:size]
            if part in self._overrides:
                return self._overrides[part]
            known = self.keys if at_key or size < len(keys) else self.values
            if part in known:
                return known[part]
            if part and part[-1] in _PAIR and (*part[:-1], _PAIR[part[-1]]) in known:
                return known[*part[:-1], _PAIR[part[-1]]]
        return Place(0, 0, 0, self.source)

    def line(self, keys: Keys, *, at_key: bool = False) -> tuple[Place, str]:
        """The place, and how a message begins: the place and the key, the key once only."""
        place, key = self.of(keys, at_key=at_key), dotted(keys)
        if place.names:  # ranks of values say nothing to whoever wrote 1..6
            below = dotted(tuple(key for key in keys[place.names :] if isinstance(key, str)))
            return place, f"{place.said}: {below}" if below else place.said
        said = place.said if not key or place.said.endswith(f" {key}") else f"{place.said}: {key}"
        return place, said

    def overridden(self, keys: Keys, said: str) -> None:
        """From here on, the value at `keys` and all in it were set by an override."""
        for known in (self.keys, self.values):
            for stale in [other for other in known if other[: len(keys)] == keys]:
                del known[stale]
        self._overrides[keys] = Place(_OVERRIDES + len(self._overrides), 0, 0, said)

    def given(self, keys: Keys, option: str) -> None:
        """The value at `keys` was given by an option of the command line: messages name it, and not the keys."""
        self.overridden(keys, option)
        self._overrides[keys] = replace(self._overrides[keys], names=len(keys))

    def table(self) -> int:
        """Rank of a table that is read next."""
        self._tables += 1
        return self._tables

    def number(self, data: Mapping[str, Any]) -> None:
        """Give the values of a mapping, which have no lines, the order in which they stand."""
        self._number((), data)

    def _number(self, keys: Keys, value: Any) -> None:
        if keys in self._overrides:
            return
        place = Place(0, len(self.values), 0, self.source)
        self.keys[keys] = self.values[keys] = place
        if isinstance(value, Mapping):
            for key, item in value.items():
                self._number((*keys, key), item)
        elif isinstance(value, list | tuple):
            for rank, item in enumerate(value):
                self._number((*keys, rank), item)
