"""Policies as a model names them, with their parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, ConfigDict, Field

from desim_warehouse.layout.spec import FrozenMap, Name, NotNegative, Part, Says, as_json
from desim_warehouse.policies.catalogue import user_source


def _frozen(value: Any) -> Any:
    """Parameters that nobody can change, their names in one order."""
    if isinstance(value, Mapping):
        return FrozenMap({key: _frozen(value[key]) for key in sorted(value)})
    if isinstance(value, list | tuple):
        return tuple(_frozen(item) for item in value)
    return value


class PolicySpec(Part):
    """A policy by name (ours), `module:Class` or `file.py:Class` (yours), with its parameters beside it."""

    model_config = ConfigDict(extra="allow", frozen=True, defer_build=True)

    name: Name = Field(description="a policy of ours, module:Class or file.py:Class")

    @property
    def params(self) -> Mapping[str, Any]:
        """The parameters: every key but the name."""
        return self.__pydantic_extra__ or FrozenMap()

    def content(self) -> Any:
        """As a model file has it: the name alone where no parameter is given."""
        return {"name": self.name, **as_json(self.params)} if self.params else self.name

    def model_post_init(self, _context: Any, /) -> None:
        """Freeze the parameters."""
        object.__setattr__(self, "__pydantic_extra__", _frozen(self.__pydantic_extra__ or {}))


def _named_policy(value: Any) -> Any:
    return {"name": value} if isinstance(value, str) else value


Policy = Annotated[
    PolicySpec,
    BeforeValidator(_named_policy),
    Says("the name of a policy, or a section with name and parameters", {"type": "string", "minLength": 1}),
]


KINDS = ("allocation", "routing", "charging", "parking")


class Policies(Part):
    """Who decides what."""

    allocation: Policy = Field(PolicySpec(name="in-order"), description="which robot fetches which good")
    routing: Policy = Field(PolicySpec(name="highways"), description="which way a robot takes")
    charging: Policy = Field(PolicySpec(name="threshold"), description="when a robot charges")
    parking: Policy = Field(PolicySpec(name="home"), description="where an idle robot waits")
    interval: NotNegative = Field(
        0.0, description="time between allocation decisions; 0: whenever a task or a robot becomes free"
    )

    def own(self) -> list[str]:
        """The policies that are the user's own, whose code we know nothing of."""
        return sorted(name for kind in KINDS if ":" in (name := getattr(self, kind).name))

    def sources(self) -> bytes:
        """The content of the files that the user's own policies come from: what a run depends on besides names."""
        return b"".join(user_source(getattr(self, kind).name) for kind in KINDS)
