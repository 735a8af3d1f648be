"""A file or a mapping as a document: plain values, and the position of each; YAML 1.2, safe, every key once."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NoReturn, TypeVar

from pydantic import ValidationError

from desim_warehouse.errors import ModelError, got, nearest, reason, with_point
from desim_warehouse.model.messages import FilePositions, Keys, Outline, Position, Problem, from_pydantic, report
from desim_warehouse.values.fields import LIMITS, Known, Part

_TAG = "tag:yaml.org,2002:"
_TEXT = {f"{_TAG}{name}" for name in ("str", "timestamp", "merge", "value")}
_DEEPEST, _MOST = LIMITS["deep"][0], LIMITS["values"][0]
_LARGE = 200_000  # characters of a text whose keys are looked at while it is read
_NESTED = re.compile(rf"(?:[\[{{]\s*){{{_DEEPEST + 1}}}")
_TOO_DEEP = f"too many lists or sections inside one another, expected {_DEEPEST} at most"

Files = Literal["any", "beside", "none"]
"""Which files a document may name: any, those below its folder, or none."""

_SYNTAX = {
    "'\\t'": "a tab before a word, expected spaces",
    "<block": "indented differently from the lines before",
    "mapping values": "a ':' that follows no key, expected 'key: value' on every line",
    "quoted scalar": "an unfinished text, expected a closing quote",
}
"""Jargon of the YAML reader, and our words for it."""
Whole = TypeVar("Whole", bound=Part)


@dataclass
class Document:
    """The content of a YAML text: plain values, where each stands, and what is wrong with them.

    `folder`: where the relative names of files in it start. `files`: which of them may be read. `unread`: keys whose
    file could not be read. `text`: of the file, with its comments; empty where it is none.
    """

    data: Any
    positions: FilePositions
    problems: list[Problem] = field(default_factory=list)
    folder: Path = Path()
    files: Files = "any"
    unread: set[Keys] = field(default_factory=set)
    text: str = ""

    @property
    def kind(self) -> str | None:
        """The kind of content, by its keys: a model, a study, or None where that is unclear."""
        model, study = {"layout", "fleet", "tasks"} & self.data.keys(), {"model", "factors"} & self.data.keys()
        return None if bool(model) == bool(study) else "model" if model else "study"


def from_mapping(source: Mapping[str, Any], name: str) -> Document:
    """Take a mapping of Python as a document; `name`: what messages call it."""
    problems: list[Problem] = []
    return Document(plain(source, (), problems), FilePositions(name), problems)


def from_file(path: Path, name: str, whole: str, outline: Outline) -> Document:
    """Read a file whose top level is a mapping.

    Args:
        path: the file.
        name: what messages call it.
        whole: what it should hold, such as "a model with layout, fleet and tasks".
        outline: the keys that it can have.

    Raises:
        ModelError: where there is no such file, or it cannot be read.
    """
    kind = " ".join(whole.split()[:2])
    try:
        with path.open("rb") as file:
            content = file.read(LIMITS["bytes"][0] + 1)
    except FileNotFoundError:
        near = nearest(path.name, sorted(p.name for p in path.parent.glob("*.y*ml")))
        hint = f"; did you mean '{path.with_name(near)}'?" if near else ""
        raise ModelError([f"{name}: no such file, expected {kind} file{hint}"]) from None
    except (OSError, ValueError) as error:
        raise ModelError([f"{name}: cannot be read ({reason(error)}), expected {kind} file"]) from None
    if len(content) > LIMITS["bytes"][0]:
        raise ModelError([f"{name}: too large, expected {kind} file of at most {LIMITS['bytes'][0]:,} bytes"])
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = content[: error.start]
        line, column = before.count(b"\n") + 1, error.start - before.rfind(b"\n")
        wrong = f"not UTF-8 text (got byte 0x{content[error.start]:02x}), expected the file to be saved as UTF-8"
        raise ModelError([f"{name}:{line}:{column}: {wrong}"]) from None
    document = read_yaml(text, name, is_key=outline.has)
    if document.data is None:
        raise ModelError([f"{name}:1:1: nothing in the file, expected {whole}"])
    if not isinstance(document.data, dict):
        raise ModelError(
            [f"{document.positions.of(()).text}: not a mapping (got {got(document.data)}), expected {whole}"]
        )
    document.folder, document.text = path.parent, text
    return document


def read_yaml(text: str, source: str, most: int = _MOST, is_key: Callable[[Keys], bool] | None = None) -> Document:
    """Read one YAML document.

    Args:
        text: the document.
        source: what messages call it, such as the file's name.
        most: values that it may hold.
        is_key: whether it can have a key; a large text of other keys is not read to its end.

    Raises:
        ModelError: where the text is not YAML.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError
    from ruamel.yaml.reader import ReaderError

    if nested := _NESTED.search(text):  # the YAML reader needs seconds for them
        before = text[: nested.start()]
        _refuse(source, before.count("\n") + 1, nested.start() - before.rfind("\n"), _TOO_DEEP)
    if sum(map(text.count, (",", "\n"))) > most:  # each value takes more than a kilobyte while it is read
        raise ModelError([f"{source}: too many values, expected {most:,} at most"])
    yaml = YAML(typ="safe", pure=True)
    if is_key is not None and len(text) > _LARGE:
        from desim_warehouse.model.strange import watching

        yaml.Composer = watching(is_key, source)
    try:
        return _Reader(source, yaml.constructor, most).document(yaml.compose(text))
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        theirs = " ".join(", ".join(part for part in (error.context, error.problem) if part).split())
        complaint = next((ours for part, ours in _SYNTAX.items() if part in theirs), theirs)
        _refuse(source, mark.line + 1, mark.column + 1, f"not valid YAML: {complaint}")
    except ReaderError as error:
        before = text[: error.position]
        wrong = f"not text (got character {error.character:#04x}), expected text without control characters"
        _refuse(source, before.count("\n") + 1, error.position - before.rfind("\n"), wrong)
    except RecursionError:
        _refuse(source, 1, 1, _TOO_DEEP)


def _refuse(source: str, line: int, column: int, text: str) -> NoReturn:
    raise ModelError([f"{source}:{line}:{column}: {text}"]) from None


class _Reader:
    """Turns the nodes of one document into plain values."""

    def __init__(self, source: str, constructor: Any, most: int) -> None:
        self.positions = FilePositions(source)
        self.constructor = constructor
        self.most = most
        self.problems: list[Problem] = []
        self.sizes: dict[int, int] = {}
        self.around: list[Any] = []

    def document(self, root: Any) -> Document:
        if root is not None:
            self.size(root)
        data = None if root is None else self.value(root, ())
        self.positions.keys[()] = Position.in_file(0, self.positions.source, 1, 1)
        self.positions.values.setdefault((), self.positions.keys[()])
        return Document(data, self.positions, self.problems)

    def position(self, node: Any) -> Position:
        mark = node.start_mark
        return Position.in_file(0, self.positions.source, mark.line + 1, mark.column + 1)

    def size(self, node: Any) -> int:
        """Count the values that a node stands for, before a million of them is made."""
        if id(node) not in self.sizes:
            self.sizes[id(node)] = 1  # for an alias in what it stands for, which `value` refuses
            inside = [item for _, item in node.value] if node.id == "mapping" else node.value
            count = 1 if node.id == "scalar" else 1 + sum(map(self.size, inside))
            if count > self.most:
                complaint = (
                    f"too many values, expected {self.most:,} at most, with those of aliases counted at every use"
                )
                raise ModelError([f"{self.position(node).text}: {complaint}"])
            self.sizes[id(node)] = count
        return self.sizes[id(node)]

    def value(self, node: Any, keys: Keys) -> Any:
        self.positions.values[keys] = self.position(node)
        if node in self.around:
            raise ModelError([f"{self.position(node).text}: an alias that contains itself, expected a value that ends"])
        if len(keys) > _DEEPEST:
            raise ModelError([f"{self.position(node).text}: {_TOO_DEEP}"])
        if node.id == "scalar":
            return self.scalar(node, keys)
        if str(node.tag) not in {f"{_TAG}map", f"{_TAG}seq"}:
            self.tag(node, keys)
        self.around.append(node)
        if node.id == "mapping":
            made: Any = self.mapping(node, keys)
        else:
            made = [self.value(item, (*keys, rank)) for rank, item in enumerate(node.value)]
        self.around.pop()
        return made

    def mapping(self, node: Any, keys: Keys) -> dict[str, Any]:
        made: dict[str, Any] = {}
        before: Any = None
        for key_node, item in node.value:
            if made and (number := _decimal_comma(before, key_node, item)):
                wrong = f"a decimal comma (got {number}), expected a decimal point; write {with_point(number)}"
                self.problems.append(Problem((*keys, [*made][-1]), wrong))
                continue
            before = item
            key = self.key(key_node, keys)
            here, position = (*keys, key), self.position(key_node)
            if key in made:
                text = f"given twice (first on line {self.positions.keys[here].line}), expected once"
                self.problems.append(Problem(here, text, at_key=True))
            self.positions.keys[here] = position
            if key not in made:
                made[key] = self.value(item, here)
        return made

    def key(self, node: Any, keys: Keys) -> str:
        if node.id != "scalar":
            raise ModelError([f"{self.position(node).text}: not a key (a list or a section), expected a name"])
        key, name = self.scalar(node, keys), str(node.value)
        if not isinstance(key, str):
            text = f"not a name (got {got(key)}), expected a name; write it in quotes: '{name}'"
            self.problems.append(Problem((*keys, name), text, at_key=True))
        return name

    def scalar(self, node: Any, keys: Keys) -> Any:
        from ruamel.yaml.constructor import ConstructorError

        if str(node.tag) in _TEXT:
            return str(node.value)
        try:
            return self.constructor.construct_object(node)
        except ConstructorError:
            self.tag(node, keys)
        except ValueError:  # marked as a number that it is not, or one of thousands of digits
            pass
        return str(node.value)

    def tag(self, node: Any, keys: Keys) -> None:
        name = str(node.tag).replace(_TAG, "!!")
        self.problems.append(Problem(keys, f"unknown tag (got {name}), expected a value without a tag"))


def _decimal_comma(before: Any, key: Any, item: Any) -> str | None:
    """Return the number with a decimal comma that YAML reads in {speed: 1,5} as a value and a key; else None."""
    if (
        not before.id == key.id == item.id == "scalar"
        or item.value
        or before.end_mark.index + 1 != key.start_mark.index
    ):
        return None
    return number if with_point(number := f"{before.value},{key.value}") else None


def plain(value: Any, keys: Keys, problems: list[Problem]) -> Any:  # noqa: PLR0911 - one for each kind
    """Turn a value given from Python into plain values as in a file: parts of a model, tuples and NumPy's numbers."""
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


def valid(document: Document, kind: type[Whole], outline: Outline) -> Whole:
    """Check the values of a document, and return them as a whole.

    Args:
        document: its values, and what is wrong with them so far.
        kind: what it should hold.
        outline: the keys that it can have.

    Raises:
        ModelError: with every problem, in the order of the file.
    """
    problems = list(document.problems)
    try:
        checked = kind.model_validate(document.data, context=Known())
    except ValidationError as error:  # what a table lacks says nothing about the model
        problems += [item for item in from_pydantic(error, outline) if item.keys[:2] not in document.unread]
    if problems:
        raise ModelError(report(problems, document.positions))
    return checked
