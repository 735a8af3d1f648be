"""Changes to a model by dotted keys: `fleet.size`, `fleet.start.0`, `policies.charging.margin`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum
from typing import Any

from desim_warehouse.errors import ModelError, first_of, got
from desim_warehouse.layout.blocks import Blocks
from desim_warehouse.model.messages import FilePositions, Keys, Outline, Position, Problem, dotted
from desim_warehouse.model.parse import Document, plain, read_yaml
from desim_warehouse.model.sections.policy import Policies

STAR = "*"
MOST_NAMED = 6
"""Names that a message lists, of which others may be varied."""


class Unset(Enum):
    """As the value of an override, `UNSET` removes its key from the model, as if the file had never had it."""

    UNSET = "!unset"


UNSET = Unset.UNSET


def parse_assignment(text: str, option: str = "--set") -> tuple[str, Any]:
    """Split `KEY=VALUE` of a command-line option, where the value is YAML, such as `3`, `[11, 8]` or `{random: 20}`.

    The value `!unset`, as which `--unset` is passed on, is `UNSET`.

    Raises:
        ModelError: where there is no key or no value, or the value is not YAML.
    """
    key, equals, written = text.partition("=")
    key = key.strip()
    if not equals or not key:
        raise ModelError([f"{option} {text}: no assignment, expected KEY=VALUE such as fleet.size=3"])
    if written == UNSET.value:
        return key, UNSET
    document = read_yaml(written, f"{option} {key}")
    if document.data is None and not written.strip():
        raise ModelError([f"{option} {key}: no value after '=', expected one (--unset {key} leaves the key out)"])
    if document.problems:
        raise ModelError([f"{option} {key}: {problem.text}" for problem in document.problems])
    return key, document.data


def options_of(assignments: Iterable[str]) -> list[str]:
    """Return the options of a command line that give these assignments."""
    end = f"={UNSET.value}"
    split = [("--unset", text.removesuffix(end)) if text.endswith(end) else ("--set", text) for text in assignments]
    return [part for option in split for part in option]


def override(document: Document, overrides: Mapping[str, Any], outline: Outline, named: str) -> None:
    """Put overrides into a document, sections before what lies in them.

    Args:
        document: changed in place: its values, where they stand, and what is wrong with them.
        overrides: dotted keys and values, in any order.
        outline: the keys that it can have.
        named: how messages call an override.
    """
    positions, problems = document.positions, document.problems
    for text in sorted(overrides, key=_rank):
        keys: Keys = tuple(str(text).split("."))
        position = positions.of_override(named, str(text))
        if not isinstance(text, str) or not all(keys):
            problems.append(Problem((str(text),), "not a key, expected one such as 'fleet.size'"))
            positions.overridden((str(text),), position)
        elif STAR in keys and not _is_there(document.data, keys[: keys.index(STAR) + 1]):
            problems.append(_starred(document.data, keys))
            positions.overridden(keys, position)
        elif not _is_there(document.data, keys) and not outline.has(keys):
            problems.append(outline.unknown_key(keys))
            positions.overridden(keys, position)
        elif overrides[text] is UNSET:
            positions.overridden(keys, position)
            problems += _remove(document.data, keys)
        else:
            problems += _put(document.data, keys, overrides[text], positions, position)


def _starred(section: Any, keys: Keys) -> Problem:
    """Report a star for which a key must have a name, with the keys of the names that there are."""
    place = keys.index(STAR)
    for key in keys[:place]:
        section = section.get(key) if isinstance(section, dict) else None
    names = list(section) if isinstance(section, dict) else []
    meant = [dotted((*keys[:place], str(name), *keys[place + 1 :])) for name in names]
    expected = f"expected {'one of ' * (len(meant) > 1)}{first_of(meant, MOST_NAMED)}" if meant else "expected a name"
    return Problem(keys, f"a star does not stand for all names here, {expected}", at_key=True)


def _rank(text: Any) -> list[tuple[int, str]]:
    """Rank keys, shorter ones first, list entries by number: the order in which overrides are given does not matter."""
    return [(int(key) if key.isdecimal() else -1, key) for key in str(text).split(".")]


def _put(section: Any, path: Keys, value: Any, positions: FilePositions, position: Position) -> list[Problem]:
    """Set one value, and return what is wrong with it or why it cannot be set."""
    keys: Keys = ()
    problems: list[Problem] = []
    for key in path:
        if _is_entry(section, key):
            step: Any = int(key)
        elif isinstance(section, dict):
            step = key
        else:
            positions.overridden(path, position)
            return [Problem(path, _closed(section, dotted(keys), key))]
        keys = (*keys, step)
        if len(keys) == len(path):
            section[step] = plain(value, keys, problems)
        else:
            section[step] = section = _opened(section, keys, positions, position)
    positions.overridden(keys, position)
    return problems


def _remove(section: Any, path: Keys) -> list[Problem]:
    """Remove a key, if it is there; an entry of a list stays, and is the problem returned."""
    for key in path[:-1]:
        section = (
            section[int(key)] if _is_entry(section, key) else section.get(key) if isinstance(section, dict) else None
        )
    if _is_entry(section, path[-1]):
        return [Problem(path, "an entry of a list, which cannot be left out, expected the list as a whole")]
    if isinstance(section, dict):
        section.pop(path[-1], None)
    return []


def _is_there(section: Any, path: Keys) -> bool:
    """Whether a document has a key already: to make its outline takes longer than to read a model."""
    for key in path:
        if not isinstance(section, dict) or key not in section:
            return False
        section = section[key]
    return True


def _is_entry(section: Any, key: str | int) -> bool:
    return isinstance(section, list) and str(key).isdecimal() and int(key) < len(section)


def _opened(section: Any, keys: Keys, positions: FilePositions, position: Position) -> Any:
    """Return the content below a key: a policy given by name becomes a section, a missing section is made."""
    key: Any = keys[-1]
    below = section[key] if isinstance(section, list) else section.get(key)
    if len(keys) == 2 and keys[0] == "policies" and key in Policies.model_fields:  # noqa: PLR2004 - policies.charging
        below = getattr(Policies.model_fields[key].default, "name", None) if below is None else below
        return {"name": below} if isinstance(below, str) else below
    if keys == ("layout", "blocks", "directions") and (below is None or isinstance(below, str)):
        return dict.fromkeys(("rows", "columns"), below or Blocks.model_fields["directions"].default)
    if below is None:
        positions.overridden(keys, position)
        return {}
    return below


def _closed(section: Any, here: str, key: str | int) -> str:
    """Return the message that nothing can be set below a key, and why."""
    if isinstance(section, list):
        have = f"{len(section)} entries, 0 to {len(section) - 1}" if section else "no entries"
        return f"no entry {key} in '{here}' (it has {have}), expected one of these, or '{here}' as a whole"
    return f"nothing can be set below '{here}' here (it is {got(section)}), expected '{here}' as a whole"
