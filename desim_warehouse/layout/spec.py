"""What a model file says about a layout: blocks to generate, or nodes and edges, and what stands there."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal, NoReturn, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag
from pydantic_core import CoreSchema, core_schema

if TYPE_CHECKING:
    from pydantic.annotated_handlers import GetCoreSchemaHandler, GetJsonSchemaHandler

Key = TypeVar("Key")
Value = TypeVar("Value")

# Numbers are taken as written: no text for a number, no true for 1, no fraction for a whole number.
Count = Annotated[int, Field(strict=True, ge=1)]
Whole = Annotated[int, Field(strict=True, ge=0)]
Integer = Annotated[int, Field(strict=True)]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Flag = Annotated[bool, Field(strict=True)]
Name = Annotated[str, Field(strict=True, min_length=1)]
Text = Annotated[str, Field(strict=True)]
Side = Literal["north", "south", "east", "west"]


class Part(BaseModel):
    """A section of a model file: unknown keys are refused, values cannot be changed after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    def content(self) -> Any:
        """What it holds, defaults too, as plain JSON values."""
        return {field.alias or name: as_json(getattr(self, name)) for name, field in type(self).model_fields.items()}


_EXACT = 2.0**53  # up to here every whole number is a float


def as_json(value: Any) -> Any:
    """A value of a model as JSON knows it; 4.0 as 4, so that both are one."""
    if isinstance(value, Part):
        return value.content()
    if isinstance(value, Mapping):
        return {key: as_json(item) for key, item in value.items()}
    if isinstance(value, tuple):
        return [as_json(item) for item in value]
    if isinstance(value, float) and value.is_integer() and abs(value) < _EXACT:
        return int(value)
    return value


class FrozenMap(dict[Key, Value]):
    """A dict that cannot be changed; it can be compared, hashed, pickled and copied. Its order counts."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("a model cannot be changed; model.replace({...}) gives a changed copy")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __eq__(self, other: object) -> bool:
        if isinstance(other, FrozenMap):
            return list(self.items()) == list(other.items())
        return dict.__eq__(self, other)

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(tuple(self.items()))

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Read and written like a dict."""
        return core_schema.no_info_after_validator_function(cls, handler.generate_schema(dict[Any, Any]))

    def __reduce__(self) -> tuple[type[FrozenMap[Key, Value]], tuple[dict[Key, Value]]]:
        return type(self), (dict(self),)

    def __copy__(self) -> FrozenMap[Key, Value]:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> FrozenMap[Key, Value]:
        return self


Named = Annotated[Mapping[Name, Value], AfterValidator(FrozenMap)]
"""Parts by name, in the order of the file."""


class Says:
    """What a key with several forms expects, in words, and forms that reading turns into the others.

    The words go into the JSON Schema as `errorMessage`, which editors show, and from there into our messages.
    """

    def __init__(self, text: str, *forms: type[Part] | dict[str, Any]) -> None:
        self.text = text
        self.forms = forms

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Add the words and the other forms to the schema of the annotated type."""
        schema = handler(core)
        more = [
            copy.deepcopy(form) if isinstance(form, dict) else handler(form.__pydantic_core_schema__)
            for form in self.forms
        ]
        return {**({"anyOf": [schema, *more]} if more else schema), "errorMessage": f"expected {self.text}"}


def tagged(tag: str) -> Tag:
    """Mark one form of a key; the mark is taken out of the places of errors again."""
    return Tag(f"\0{tag}")


class Directions(Part):
    """The one-way rule given by hand: a direction for every row (top first) and column (left first)."""

    rows: tuple[Literal["east", "west"], ...] = Field(description="one for each row of nodes, top first")
    columns: tuple[Literal["north", "south"], ...] = Field(description="one for each column of nodes, left first")


def _directions_form(value: Any) -> str:
    return "\0hand" if isinstance(value, Mapping | Directions) else "\0rule"


class Blocks(Part):
    """Blocks of goods with one-way aisles around each: nodes where aisles cross, edges between neighbours."""

    columns: Count = Field(description="blocks side by side")
    rows: Count = Field(description="blocks one below the other")
    block_width: Annotated[int, Field(strict=True, ge=1, le=2)] = Field(2, description="goods across a block: 1 or 2")
    block_depth: Count = Field(description="goods in a block's depth")
    goods_size: Positive = Field(description="side of a good's square")
    aisle_width: Positive = Field(description="width of the aisles (columns)")
    cross_aisle_width: Positive | None = Field(None, description="width of the rows; default: aisle_width")
    directions: Annotated[
        Annotated[Literal["alternating", "ring"], tagged("rule")] | Annotated[Directions, tagged("hand")],
        Discriminator(_directions_form),
        Says("'ring', 'alternating', or a section with rows and columns"),
    ] = Field(
        "ring",
        description="ring: outer aisles clockwise, inner ones alternating; alternating; or by hand",
    )


def _short_edge(value: Any) -> Any:
    """Accept `[A, B]` for `{from: A, to: B}`."""
    if isinstance(value, list | tuple) and len(value) == 2:  # noqa: PLR2004 - a pair
        return {"from": value[0], "to": value[1]}
    return value


class Edge(Part):
    """An edge of the Highways, one-way unless it says otherwise; `[A, B]` for short.

    An edge there and one back between the same nodes are one two-way lane, unless they are side by side.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True, defer_build=True)

    source: Name = Field(alias="from", description="the node it leaves")
    target: Name = Field(alias="to", description="the node it leads to")
    length: Positive | None = Field(None, description="default: the straight distance")
    speed: Positive | None = Field(None, description="speed limit; default: none")
    two_way: Flag = Field(False, description="one lane for both directions, used in one at a time")
    side_by_side: Flag = Field(False, description="with an edge back: two lanes side by side, not one for both")


_PAIR = {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}


class Storage(Part):
    """A storage place beside an edge, `offset` from the edge's start; its number is its rank in the list."""

    edge: tuple[Name, Name] = Field(description="[from, to]: the edge it is picked from")
    offset: Positive = Field(description="distance from the edge's start")
    popularity: NotNegative = Field(1.0, description="weight with which it is asked for")


class StorageFile(Part):
    """Storage places from a CSV file with the columns from, to, offset and perhaps popularity."""

    file: Name = Field(description="CSV file, relative to the model file")


class Places(Part):
    """Nodes by name (`at`), or every n-th node along a side of the layout (`along`, `every`)."""

    at: tuple[Name, ...] = Field((), description="nodes by name")
    along: Side | None = Field(None, description="all nodes along this side")
    every: Count = Field(1, description="with along: every n-th node")


class Bay(Places):
    """Parking places beside a node, entered and left through it; `chargers` of them have a charger."""

    places: Count | None = Field(None, description="a node; default: as many as robots start there")
    chargers: Whole | None = Field(None, description="a node; default: one a place")
    total_chargers: Whole | None = Field(
        None, description="instead of chargers: of all its nodes together, assigned to them round-robin"
    )


class Station(Places):
    """Unloading stations beside nodes: `places` robots fit in, `servers` of them are served at a time."""

    places: Count = Field(4, description="robots that can be inside, a node")
    servers: Count = Field(1, description="robots served at a time, a node")


class LayoutSpec(Part):
    """The layout section: `blocks`, or `nodes` with `edges` and `storage`; then what stands at the nodes."""

    blocks: Blocks | None = Field(None, description="a layout to generate")
    nodes: Named[tuple[Number, Number]] = Field(FrozenMap(), description="name: [x, y], y downwards")
    edges: tuple[
        Annotated[Edge, BeforeValidator(_short_edge), Says("an edge: [A, B] or a section with from and to", _PAIR)],
        ...,
    ] = Field((), description="edges between the nodes")
    storage: Annotated[
        tuple[Storage, ...],
        Says("a list of storage places (edge, offset), or {file: storage.csv}", StorageFile),
    ] = Field((), description="places of goods, numbered from 0 as listed")
    bays: Named[Bay] = Field(FrozenMap(), description="departure, parking and charging zones by name")
    stations: Named[Station] = Field(FrozenMap(), description="stations beside nodes by name")
