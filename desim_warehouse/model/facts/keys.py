"""Facts about a key of the model, read off its field in the schema: what people call it, and its kind of unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin

from desim_warehouse.model.schema import Model
from desim_warehouse.model.sections.policy import PolicySpec
from desim_warehouse.values.distributions import Distribution
from desim_warehouse.values.fields import By, Part, Unit

if TYPE_CHECKING:
    from collections.abc import Iterator

    from pydantic.fields import FieldInfo


@dataclass(frozen=True)
class Key:
    """A key of the model.

    Attributes:
        short: what it is, for the head of a table: `chargers`.
        label: `short` with the name of the part that it belongs to, for an axis: `chargers in parking`.
        kind: of its unit: time, length, speed, acceleration, rate, share, energy, power, angle; empty for counts, names
            and plain numbers.
        meaning: the description in the schema.
    """

    short: str = ""
    label: str = ""
    kind: str = ""
    meaning: str = ""


@lru_cache(maxsize=1024)
def about(key: str) -> Key | None:
    """Describe a dotted key by its label and unit, such as `layout.bays.parking.chargers`; None if models lack it.

    It is called by the title of its field, else by its name. Parameters of a distribution are added to what varies:
    `load time, mean`. None: models have no such key.
    """
    forms: list[tuple[Any, Key]] = [(Model, Key())]
    place = ""
    for part in key.split("."):
        steps = [step for annotation, before in forms for step in _step(annotation, part, before)]
        if not steps:
            return None
        forms = [(annotation, after) for annotation, after, _ in steps]
        place += next((f" {by.preposition} {part}" for _, _, by in steps if by is not None), "")
    first = forms[0][1]
    subject, comma, parameter = first.short.partition(", ")
    return replace(first, label=f"{subject}{place}{comma}{parameter}")


def sections(annotation: Any) -> Iterator[type[Part]]:
    """Iterate over the sections that a value may be, in any of its forms; not sections in it by name or in a list."""
    if isinstance(annotation, type) and issubclass(annotation, Part):
        yield annotation
    elif get_origin(annotation) not in {tuple, Mapping}:
        for inner in get_args(annotation):
            yield from sections(inner)


def containers(annotation: Any, by: By | None = None) -> Iterator[tuple[Any, By | None]]:
    """Iterate over what a value may hold in a list (None), or by name, and how that name is said."""
    origin, inner = get_origin(annotation), get_args(annotation)
    if origin is Mapping:
        yield inner[1], by or By("of")
    elif origin is tuple:
        yield from ((item, None) for item in inner if item is not Ellipsis)
    else:
        naming = next((note for note in getattr(annotation, "__metadata__", ()) if isinstance(note, By)), by)
        for form in inner:
            yield from containers(form, naming)


def _step(annotation: Any, part: str, before: Key) -> Iterator[tuple[Any, Key, By | None]]:
    """Iterate over what stands at a key below a value of some form, with how its name is said, if it is one."""
    for section in sections(annotation):
        for name, field in section.model_fields.items():
            if part in {name, field.alias}:
                whole = whole_annotation(field)
                yield whole, _below(before, section, name, field, kind_of(whole)), None
        if section is PolicySpec and part != "name":
            yield None, Key(short=in_words(part), meaning=f"a parameter of {before.meaning}"), None
    for inner, by in containers(annotation):
        if by is not None or part.isdecimal():
            yield inner, replace(before, kind=kind_of(inner) or before.kind), by


def _below(before: Key, section: type[Part], name: str, field: FieldInfo, kind: str) -> Key:
    """Describe a field in the section that holds it."""
    meaning = field.description or ""
    if issubclass(section, Distribution):  # the key of a distribution; its section is what varies, too
        return replace(before, short=_and(before.short, field.title), kind=kind, meaning=meaning)
    if ", " not in before.short and _of_distribution(section):
        return Key(f"{before.short}, {field.title or in_words(name)}", "", kind, meaning)
    return Key(field.title or in_words(name), "", kind, meaning)


def _and(what: str, parameter: str | None) -> str:
    return f"{what}, {parameter}" if parameter else what


def _of_distribution(section: type[Part]) -> bool:
    """Whether a section holds the parameters of a distribution."""
    kinds = Distribution.__subclasses__()
    return any(section in sections(field.annotation) for kind in kinds for field in kind.model_fields.values())


def whole_annotation(field: FieldInfo) -> Any:
    """Return the annotation of a field with what stands beside its type, which pydantic keeps apart."""
    return Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation


def kind_of(annotation: Any) -> str:
    """Return the kind of unit of a number, or of the numbers in a list; empty where there is none."""
    for note in getattr(annotation, "__metadata__", ()):
        if isinstance(note, Unit):
            return note.kind
    if isinstance(annotation, type) or get_origin(annotation) is Mapping:
        return ""
    return next((kind for inner in get_args(annotation) if (kind := kind_of(inner))), "")


def in_words(name: str) -> str:
    """Write a name as one says it: `node_time` as `node time`."""
    return name.replace("_", " ").replace("-", " ")
