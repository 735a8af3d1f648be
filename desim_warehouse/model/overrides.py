"""Changes to a model by dotted keys: `fleet.size`, `fleet.start.0`, `policies.charging.margin`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import ModelError
from desim_warehouse.model import outline
from desim_warehouse.model.parse import plain, read_yaml
from desim_warehouse.model.places import Keys, Places, dotted
from desim_warehouse.model.policy import Policies
from desim_warehouse.model.problems import Problem, got, unknown_key

if TYPE_CHECKING:
    from collections.abc import Mapping


def parse_assignment(text: str, option: str = "--set") -> tuple[str, Any]:
    """Split `KEY=VALUE` of an option of the command line; the value is YAML, such as `3`, `[11, 8]` or `{random: 20}`.

    Raises:
        ModelError: where there is no key or no value, or the value is not YAML.
    """
    key, equals, written = text.partition("=")
    key = key.strip()
    if not equals or not key:
        raise ModelError([f"{option} {text}: no assignment, expected KEY=VALUE such as fleet.size=3"])
    document = read_yaml(written, f"{option} {key}")
    if document.data is None and not written.strip():
        raise ModelError([f"{option} {key}: no value after '=', expected one (null leaves the key out)"])
    if document.problems:
        raise ModelError([f"{option} {key}: {problem.text}" for problem in document.problems])
    return key, document.data


def override(data: dict[str, Any], overrides: Mapping[str, Any], places: Places, named: str) -> list[Problem]:
    """Put overrides into the plain values of a model, sections before what lies in them.

    Args:
        data: the values; changed in place.
        overrides: dotted keys and values, in any order.
        places: where values stand; learns what was overridden.
        named: how messages call an override.

    Returns:
        What is wrong with the overrides.
    """
    problems: list[Problem] = []
    for text in sorted(overrides, key=_rank):
        said = f"{named} {text}"
        if not isinstance(text, str) or not all(text.split(".")):
            problems.append(Problem((str(text),), "not a key, expected one such as 'fleet.size'"))
            places.overridden((str(text),), said)
            continue
        problems += _Override(text, said, places).put(data, overrides[text])
    return problems


def _rank(text: Any) -> list[tuple[int, str]]:
    """Shorter keys first, list entries by number: the order in which overrides are given is no matter."""
    return [(int(key) if key.isdecimal() else -1, key) for key in str(text).split(".")]


class _Override:
    """One override on its way into the values of a model."""

    def __init__(self, text: str, said: str, places: Places) -> None:
        self.keys = _typed(text.split("."))
        self.said = said
        self.places = places

    def put(self, data: dict[str, Any], value: Any) -> list[Problem]:
        """Set the value; returns what is wrong with it or its key."""
        problems: list[Problem] = []
        wrong = _unknown(self.keys)
        if wrong is None:
            section, wrong = self.reach(data)
        if wrong is None:
            section[self.keys[-1]] = plain(value, self.keys, problems)
        self.places.overridden(self.keys, self.said)
        return [wrong] if wrong else problems

    def reach(self, section: Any) -> tuple[Any, Problem | None]:
        """The section or list in which the value is to be set, or why there is none."""
        for size, key in enumerate(self.keys):
            if isinstance(section, dict) and isinstance(key, int):  # a parameter with numbers for names
                self.keys = (*self.keys[:size], str(key), *self.keys[size + 1 :])
            wrong = _closed(section, self.keys[:size], key)
            if wrong:
                return None, Problem(self.keys, wrong)
            if size < len(self.keys) - 1:
                section = self.enter(section, self.keys[: size + 1])
        return section, None

    def enter(self, section: Any, keys: Keys) -> Any:
        """What lies below a key; a policy given by its name becomes a section, a missing section is made."""
        key: Any = keys[-1]
        below = section[key] if isinstance(section, list) else section.get(key)
        if len(keys) == 2 and keys[0] == "policies":  # noqa: PLR2004 - policies.charging
            below = Policies.model_fields[str(key)].default.name if below is None else below
            below = {"name": below} if isinstance(below, str) else below
        elif below is None:
            below = [] if isinstance(self.keys[len(keys)], int) else {}
            self.places.overridden(keys, self.said)
        section[key] = below
        return below


def _typed(keys: list[str]) -> Keys:
    """The same keys with ranks in lists as numbers."""
    typed: Keys = ()
    for key in keys:
        rank = key.isdecimal() and outline.is_list(typed) and key not in outline.keys_at(typed)
        typed = (*typed, int(key) if rank else key)
    return typed


def _unknown(keys: Keys) -> Problem | None:
    """The problem that no model has such a key; the nearest one is named to the end where possible."""
    for size in range(1, len(keys) + 1):
        if not outline.known(keys[:size]):
            problem = unknown_key(keys[:size])
            if problem.meant:
                whole = (*problem.meant.split("."), *keys[size:])
                near = dotted(whole) if outline.known(whole) else problem.meant
                return Problem(keys, f"unknown key, did you mean '{near}'?")
            return Problem(keys, problem.text)
    return None


def _closed(section: Any, keys: Keys, key: str | int) -> str | None:
    """Why there is no such place in a section, if there is none."""
    here = dotted(keys)
    if isinstance(section, list):
        if isinstance(key, int) and key < len(section):
            return None
        have = f"{len(section)} entries, 0 to {len(section) - 1}" if section else "no entries"
        return f"no entry {key} in '{here}' (it has {have}), expected one of these, or '{here}' as a whole"
    if isinstance(section, dict):
        return None
    return f"nothing can be set below '{here}' here (it is {got(section)}), expected '{here}' as a whole"
