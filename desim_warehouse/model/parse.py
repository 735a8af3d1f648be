"""YAML with the place of every key and value: safe, version 1.2, every key once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NoReturn

from desim_warehouse.errors import ModelError
from desim_warehouse.layout.spec import Part
from desim_warehouse.model.places import Keys, Place, Places
from desim_warehouse.model.problems import Problem, got

_TAG = "tag:yaml.org,2002:"
_DEEPEST = 30  # lists and sections inside one another; a model needs about 6
_TOO_DEEP = f"too many lists or sections inside one another, expected {_DEEPEST} at most"
_MOST = 1_000_000  # values in a file, aliases counted at every use


@dataclass
class Document:
    """What a YAML text says: plain values, where each stands, and what is wrong with them."""

    data: Any
    places: Places
    problems: list[Problem] = field(default_factory=list)


def read_yaml(text: str, source: str) -> Document:
    """Read one YAML document.

    Args:
        text: the document.
        source: what messages call it, such as the file's name.

    Raises:
        ModelError: where the text is not YAML.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError
    from ruamel.yaml.reader import ReaderError

    try:
        root = YAML(typ="safe", pure=True).compose(text)
        return _Reader(source).document(root)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        _refuse(source, mark.line + 1, mark.column + 1, _syntax(error))
    except ReaderError as error:
        before = text[: error.position]
        column = error.position - before.rfind("\n")
        text = f"not text (got character {error.character:#04x}), expected text without control characters"
        _refuse(source, before.count("\n") + 1, column, text)
    except YAMLError as error:
        raise ModelError([f"{source}: not valid YAML: {' '.join(str(error).split())}"]) from None
    except RecursionError:
        _refuse(source, 1, 1, _TOO_DEEP)


_SYNTAX = {
    r"found character '\t'": "a tab before a word, expected spaces",
    "but found '<block mapping start>'": "indented further than the line before, expected the same",
    "expected <block end>": "indented otherwise than the lines before, expected as one of them",
    "mapping values are not allowed": "a ':' that follows no key, expected 'key: value' in every line",
    "expected ',' or ']'": "a list without an end, expected ',' or ']'",
    "expected ',' or '}'": "a mapping without an end, expected ',' or '}'",
    "unexpected end of stream": "a text without an end, expected a closing quote",
    "found another document": "a second document, expected one (--- begins a document)",
    "could not find expected ':'": "a line without ':', expected 'key: value'",
}
"""Words of the YAML reader, and ours."""


def _syntax(error: Any) -> str:
    said = " ".join(str(part) for part in (error.problem, error.context) if part)
    ours = next((text for theirs, text in _SYNTAX.items() if theirs in said), None)
    return f"not valid YAML: {ours or said}"


def _refuse(source: str, line: int, column: int, text: str) -> NoReturn:
    raise ModelError([f"{source}:{line}:{column}: {text}"]) from None


class _Reader:
    """Turns the nodes of one document into plain values."""

    def __init__(self, source: str) -> None:
        self.places = Places(source)
        self.problems: list[Problem] = []
        self.count = 0
        self.around: list[Any] = []

    def document(self, root: Any) -> Document:
        data = None if root is None else self.value(root, ())
        self.places.keys.setdefault((), Place.in_file(0, self.places.source, 1, 1))
        self.places.values.setdefault((), self.places.keys[()])
        return Document(data, self.places, self.problems)

    def place(self, node: Any) -> Place:
        mark = node.start_mark
        return Place.in_file(0, self.places.source, mark.line + 1, mark.column + 1)

    def value(self, node: Any, keys: Keys) -> Any:
        self.places.values[keys] = self.place(node)
        self.count += 1
        if node in self.around or self.count > _MOST:
            said = "an alias that repeats itself without end, expected every value to end"
            raise ModelError([f"{self.place(node).said}: {said}"])
        if len(keys) > _DEEPEST:
            raise ModelError([f"{self.place(node).said}: {_TOO_DEEP}"])
        kind = node.id
        tag = str(node.tag).removeprefix(_TAG)
        if kind == "scalar":
            return self.scalar(node, tag, keys)
        self.around.append(node)
        if tag not in {"map", "seq"}:
            self.tag(tag, keys)
        made = self.mapping(node, keys) if kind == "mapping" else self.sequence(node, keys)
        self.around.pop()
        return made

    def sequence(self, node: Any, keys: Keys) -> list[Any]:
        return [self.value(item, (*keys, rank)) for rank, item in enumerate(node.value)]

    def mapping(self, node: Any, keys: Keys) -> dict[str, Any]:
        made: dict[str, Any] = {}
        for key_node, item in node.value:
            key = self.key(key_node, keys)
            here, place = (*keys, key), self.place(key_node)
            if key in made:
                text = f"given twice (first in line {self.places.keys[here].line}), expected once"
                self.problems.append(Problem(here, text, at_key=True))
                self.places.keys[here] = place
                continue
            self.places.keys[here] = place
            made[key] = self.value(item, here)
        return made

    def key(self, node: Any, keys: Keys) -> str:
        if node.id != "scalar":
            raise ModelError([f"{self.place(node).said}: not a key (a list or a section), expected a name"])
        key = self.scalar(node, str(node.tag).removeprefix(_TAG), keys)
        if isinstance(key, str):
            return key
        name = str(node.value)
        self.problems.append(
            Problem(
                (*keys, name),
                f"not a name (got {got(key)}), expected a name; write it in quotes: '{name}'",
                at_key=True,
            )
        )
        return name

    def scalar(self, node: Any, tag: str, keys: Keys) -> Any:  # noqa: PLR0911 - a return for each kind
        text = str(node.value)
        try:
            match tag:
                case "str" | "timestamp" | "merge":
                    return text
                case "null":
                    return None
                case "bool":
                    return text.lower() in {"true", "yes", "on", "y"}
                case "int":
                    return _whole(text)
                case "float":
                    return _fraction(text)
        except ValueError:
            return text
        self.tag(tag, keys)
        return text

    def tag(self, tag: str, keys: Keys) -> None:
        name = tag if tag.startswith("!") else f"!!{tag}"
        self.problems.append(Problem(keys, f"unknown tag (got {name}), expected a value without a tag"))


def _whole(text: str) -> int:
    digits = text.replace("_", "").lower()
    base = {"0x": 16, "0o": 8, "0b": 2}.get(digits.lstrip("+-")[:2], 10)
    return int(digits, base)


def _fraction(text: str) -> float:
    digits = text.replace("_", "").lower()
    special = {".inf": "inf", "+.inf": "inf", "-.inf": "-inf", ".nan": "nan"}
    return float(special.get(digits, digits))


def plain(value: Any, keys: Keys, problems: list[Problem]) -> Any:  # noqa: PLR0911 - one for each kind
    """A value given from Python as a file could have it: parts of a model, tuples and NumPy's numbers are plain."""
    if value is None or type(value) in (str, int, float, bool):
        return value
    if len(keys) > _DEEPEST:
        problems.append(Problem(keys[:1], _TOO_DEEP))
        return None
    if hasattr(value, "tolist"):
        return plain(value.tolist(), keys, problems)
    if isinstance(value, Part):
        return plain(value.content(), keys, problems)
    if isinstance(value, Mapping):
        made = {}
        for key, item in value.items():
            if not isinstance(key, str):
                problems.append(Problem.of((*keys, str(key)), "not a name", key, "a name, in quotes"))
            made[str(key)] = plain(item, (*keys, str(key)), problems)
        return made
    if isinstance(value, list | tuple | range):
        return [plain(item, (*keys, rank), problems) for rank, item in enumerate(value)]
    for kind in (str, bool, int, float):
        if isinstance(value, kind):
            return kind(value)
    wrong = f"not a value a model file can have (got {type(value).__name__})"
    problems.append(Problem(keys, f"{wrong}, expected numbers, text, lists and mappings"))
    return str(value)
