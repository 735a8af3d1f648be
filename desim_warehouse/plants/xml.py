"""Safe reading of XML from untrusted sources, as elements with their lines.

Document types are refused, and with them all entities but XML's own five. So nothing is expanded, and no other file is
opened. Size, depth and the number of elements are limited.

For the readers of GraphML and openTCS.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

from desim_warehouse.errors import ModelError, did_you_mean, got, reason
from desim_warehouse.values.fields import LIMITS

_DEEPEST, _MOST = LIMITS["deep"][0], LIMITS["elements"][0]


@dataclass(slots=True)
class Element:
    """An element with its attributes, children and text; `file` and `line` are its position."""

    tag: str
    attributes: dict[str, str]
    file: str
    line: int
    children: list[Element] = field(default_factory=list)
    content: str = ""

    @property
    def position(self) -> str:
        """Position of the element in its file, for messages."""
        return f"line {self.line}"

    def all(self, tag: str) -> Iterator[Element]:
        """Yield the children with a tag."""
        return (child for child in self.children if child.tag == tag)

    def text(self, *names: str) -> str:
        """Return the attribute under the first of its names that is present; raise ModelError if none is."""
        for name in names:
            if name in self.attributes:
                return self.attributes[name]
        return self.refuse(f"no {names[0]}, expected one{did_you_mean(names[0], self.attributes)}")

    def number(self, *names: str, default: float | None = None) -> float:
        """Return the number in an attribute, under the first name that is present; raise ModelError without one."""
        if default is not None and not any(name in self.attributes for name in names):
            return default
        text = self.text(*names)
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not abs(value) <= LIMITS["number"][0]:
            self.refuse(f"{names[0]}: not a number (got {got(text)}), expected one")
        return value

    def refuse(self, text: str) -> NoReturn:
        """Raise ModelError for this element."""
        name = self.attributes.get("name")
        raise ModelError([f"{self.file}:{self.line}: {self.tag}{f' {got(name)}' if name else ''}: {text}"]) from None


def looks(path: Path, start: bytes) -> bool:
    """Return whether a file may be XML."""
    return start.startswith(b"<") or path.suffix.lower() == ".xml"


def read_xml(path: Path, content: bytes, expected: str) -> Element:
    """Return the root element of a file.

    Args:
        path: the file, for messages.
        content: its bytes.
        expected: what it should hold, for messages.

    Raises:
        ModelError: no XML, a document type, or too many elements.
    """
    return _Reader(str(path), expected).read(content)


class _Reader:
    """Maker of the elements of an XML file, from the events of the parser."""

    def __init__(self, file: str, expected: str) -> None:
        self.file = file
        self.expected = expected
        self.count = 0
        self.open: list[Element] = []
        self.texts: list[list[str]] = []
        self.root: Element | None = None
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.StartDoctypeDeclHandler = self.doctype
        self.parser.CharacterDataHandler = self.text
        self.parser.buffer_text = True

    def read(self, content: bytes) -> Element:
        try:
            self.parser.Parse(content, True)
        except expat.ExpatError as error:
            text = f"not XML ({expat.ErrorString(error.code)}), expected {self.expected}"
            raise ModelError([f"{self.file}:{error.lineno}:{error.offset + 1}: {text}"]) from None
        except (ValueError, LookupError) as error:  # an encoding that Python does not know
            raise ModelError([f"{self.file}:1: not XML ({reason(error)}), expected {self.expected}"]) from None
        assert self.root is not None
        return self.root

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self.count += 1
        element = Element(tag, attributes, self.file, self.parser.CurrentLineNumber)
        if self.count > _MOST:
            element.refuse(f"too many elements, expected {_MOST:,} at most")
        if len(self.open) >= _DEEPEST:
            element.refuse(f"too many elements inside one another, expected {_DEEPEST} at most")
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)
        self.texts.append([])

    def text(self, data: str) -> None:
        self.texts[-1].append(data)

    def end(self, _: str) -> None:
        self.open.pop().content = "".join(self.texts.pop()).strip()

    def doctype(self, *_: object) -> None:
        text = "a document type, which may define entities, expected none"
        raise ModelError([f"{self.file}:{self.parser.CurrentLineNumber}: {text}"])
