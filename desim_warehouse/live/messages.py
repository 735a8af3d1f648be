"""Messages between a live page and its server: their types, and the OpenAPI document made from them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic.json_schema import models_json_schema

from desim_warehouse._version import __version__
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.standing import WORDS, Standing

Verdict = Standing | Literal["estimate", "first run", "early"]
_APART: dict[Verdict, str] = {
    "estimate": "Quick estimate",
    "first run": "First run",
    "early": "First runs",
    "met": "Target met",
    "known": "Simulated",
}
"""Labels of verdicts that differ from the words of answers, or exist only on this page."""


def label(verdict: Verdict) -> str:
    """Return the label of a verdict."""
    return capital(_APART.get(verdict) or WORDS[verdict])  # type: ignore[index] # the others are above


class Message(BaseModel):
    """A message, which has exactly the keys of its type."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Ask(Message):
    """A request for a design: offered values by key; omitted keys are as in the model."""

    levels: Annotated[dict[str, int | float | str], Field(max_length=50)]


class ShareAsk(Message):
    """A request for a shared page: its designs, the baseline first."""

    ids: Annotated[list[str], Field(min_length=2, max_length=120)]


class Knob(Message):
    """A key that the page offers: its values, their texts, and the index of the model's value, if it is among them."""

    key: str
    label: str
    kind: Literal["number", "choice"]
    values: list[int | float | str]
    texts: list[str]
    today: int | None


class Aim(Message):
    """The target of designs, with values as the page shows them (95 for 95 %)."""

    indicator: str
    label: str
    relation: Literal[">=", "<=", ">", "<"]
    value: float
    least: float
    most: float
    step: float
    unit: str


class About(Message):
    """The model of the page, the keys on offer, and the statement on verdicts."""

    version: Literal[1] = 1
    name: str
    hash: str
    knobs: list[Knob]
    target: Aim | None
    indicator: str
    label: str
    unit: str
    runs: int
    promise: str
    colours: dict[str, Any]
    folder: str


class Calculated(Message):
    """The quick estimate of a design; `needed` holds sufficient values by key."""

    id: str
    words: str
    levels: dict[str, int | float | str]
    runs: int
    sentence: str
    more: str
    needed: dict[str, float]


class Measured(Message):
    """An indicator over the runs of a design; `text` is as in `desim what-if`, and numbers are in `unit`."""

    name: str
    label: str
    unit: str
    text: str
    mean: float
    low: float | None
    high: float | None


class Tried(Message):
    """A design with runs, for the list of designs tried."""

    id: str
    words: str
    levels: dict[str, int | float | str]
    runs: int
    text: str
    verdict: Verdict


class Watched(Message):
    """The state of a design; every event holds the whole state, so that a missed event loses nothing.

    `n`: number of runs that count, without gaps. `values`: the main indicator in each run. `pinned_at`: mean and
    interval of the pinned design. `done`: why no more runs are simulated; empty before. `busiest`: sentence on the
    busiest group. `busy`: name and load of each group, the largest load first.
    """

    id: str
    n: int
    wanted: int
    done: Literal["", "verdict", "all", "fails", "exact"]
    seconds_left: float | None
    verdict: Verdict
    label: str
    sentence: str
    more: list[str]
    values: list[float | None]
    measured: list[Measured]
    busiest: str
    busy: list[tuple[str, float]]
    pinned: str | None
    pinned_at: tuple[float, float | None, float | None] | None
    floor: bool
    tried: list[Tried]
    notes: list[str]


class Refusal(Message):
    """Why a call was refused: a line for each problem, with the key, the value and the cure."""

    problems: list[str]


# A long list of calls.
def openapi() -> dict[str, Any]:
    """Return the calls and their types as OpenAPI 3.1."""
    types = (Ask, ShareAsk, About, Calculated, Watched, Refusal)
    place = "#/components/schemas/{model}"
    made, schemas = models_json_schema([(kind, "validation") for kind in types], ref_template=place)
    refused = {
        "description": "refused",
        "content": {"application/json": {"schema": made[Refusal, "validation"]}},
    }

    def call(text: str, kind: type[Message] | None, media: str, ask: type[Message] | None = None) -> dict[str, Any]:
        schema = {"type": "string"} if kind is None else made[kind, "validation"]
        operation: dict[str, Any] = {
            "summary": text,
            "responses": {
                "200": {"description": "done", "content": {media: {"schema": schema}}},
                "default": refused,
            },
        }
        if ask is not None:
            body = {"application/json": {"schema": made[ask, "validation"]}}
            operation["requestBody"] = {"required": True, "content": body}
        return operation

    def parameter(name: str, where: str, kind: str) -> dict[str, Any]:
        return {"name": name, "in": where, "required": where == "path", "schema": {"type": kind}}

    design = [parameter("id", "path", "string")]
    kinds = {"runs": "integer", "pinned": "string", "target": "number", "floor": "integer"}
    asked = [parameter(name, "query", kind) for name, kind in kinds.items()]
    js = "application/json"
    return {
        "openapi": "3.1.0",
        "info": {"title": "desim serve", "version": __version__},
        "security": [{"token": []}],
        "paths": {
            "/api/model": {"get": call("The model, and what may be changed", About, js)},
            "/api/design": {"post": call("Estimate what a design does", Calculated, js, Ask)},
            "/api/design/{id}/events": {
                "get": call("Simulate a design while somebody listens", Watched, "text/event-stream"),
                "parameters": [*design, *asked],
            },
            "/api/design/{id}/floor": {"get": call("What a page plays of one run", None, js), "parameters": design},
            "/api/share": {"post": call("These designs as a page without a server", None, "text/html", ShareAsk)},
            "/api/openapi.json": {"get": call("This document", None, js)},
        },
        "components": {
            "schemas": schemas["$defs"],
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
        },
    }
