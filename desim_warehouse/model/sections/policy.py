"""Policies as a model names them, with their parameters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, ConfigDict, Field, ValidationInfo, field_validator, model_validator

from desim_warehouse.errors import got
from desim_warehouse.model.messages import Problem
from desim_warehouse.policies import catalogue
from desim_warehouse.values.fields import (
    SECTION,
    Forms,
    FrozenMap,
    Interval,
    Name,
    Part,
    Usual,
    as_json,
    known,
    writable,
    wrong,
)
from desim_warehouse.values.units import quantity

_POLICY = "the name of a policy, or a section with name and parameters"
OF_PODS = ("pod", "storage", "order_station", "put")
KINDS = ("allocation", "routing", "charging", "parking", "batching", *OF_PODS)


def _frozen(value: Any) -> Any:
    """Return parameters that cannot be changed, with their names in one order."""
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

    @property
    def own(self) -> bool:
        """Whether the policy is the user's own; then nothing is known about its code."""
        return ":" in self.name

    def content(self) -> Any:
        """Return the policy as a model file has it: the name alone where no parameter is given."""
        return {"name": self.name, **as_json(self.params)} if self.params else self.name

    @model_validator(mode="after")
    def _finite(self) -> PolicySpec:
        for keys, value in _leaves((), self.params):
            if isinstance(value, float) and not math.isfinite(value):
                raise wrong(f"should be a finite number (got {got(value)})", *keys)
            if isinstance(value, str):
                writable(value)
        return self

    def model_post_init(self, _context: Any, /) -> None:
        """Freeze the parameters."""
        object.__setattr__(self, "__pydantic_extra__", _frozen(self.__pydantic_extra__ or {}))


def _leaves(keys: tuple[str | int, ...], value: Any) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    if isinstance(value, Mapping | tuple):
        for key, item in value.items() if isinstance(value, Mapping) else enumerate(value):
            yield from _leaves((*keys, key), item)
    else:
        yield keys, value


def _named_policy(value: Any) -> Any:
    if isinstance(value, SECTION):
        return value
    if isinstance(value, str):
        return {"name": value}
    raise wrong(f"should be {_POLICY} (got {got(value)})")


Policy = Annotated[PolicySpec, BeforeValidator(_named_policy), Forms(_POLICY, {"type": "string", "minLength": 1})]


def in_model_units(spec: PolicySpec, kind: str, info: ValidationInfo) -> PolicySpec:
    """Return a policy for a kind of decision with its quantities as numbers in the model's units."""
    kinds = catalogue.quantities_of(kind, spec.name)
    numbers = {}
    for key, value in spec.params.items():
        try:
            if isinstance(value, str) and key in kinds:
                numbers[key] = quantity(value, kinds[key], known(info).units)
        except ValueError as error:
            raise wrong(str(error), key) from None
    return PolicySpec(name=spec.name, **{**spec.params, **numbers}) if numbers else spec


class Policies(Part):
    """The policies that make the decisions."""

    allocation: Policy = Field(
        PolicySpec(name="in-order"), title="dispatching", description="which robot fetches which good"
    )
    routing: Policy = Field(PolicySpec(name="highways"), description="which route a robot takes")
    charging: Policy = Field(PolicySpec(name="threshold"), description="when a robot charges")
    parking: Policy = Field(PolicySpec(name="home"), description="where an idle robot waits")
    batching: Policy = Field(PolicySpec(name="single"), description="which tasks a robot does on one tour")
    pod: Policy | None = Field(None, description="with pods: which one is brought to a station; default: nearest")
    storage: Policy | None = Field(None, description="with pods: where one is put down again; default: nearest")
    order_station: Policy | None = Field(
        None, title="station of an order", description="with pods: where an order goes; default: fewest-orders"
    )
    put: Policy | None = Field(
        None, title="pod for goods in", description="with pods: onto which one a bundle is put; default: emptiest"
    )
    interval: Annotated[Interval, Usual(0, "10 min")] = Field(
        0.0,
        title="time between decisions",
        description="time between allocation decisions; 0: whenever a task or a robot becomes free. Otherwise a "
        "robot that has unloaded in a station stays there until the next decision, in the state `awaiting`",
    )

    @field_validator(*KINDS)
    @classmethod
    def _in_the_models_units(cls, spec: PolicySpec | None, info: ValidationInfo) -> PolicySpec | None:
        return None if spec is None else in_model_units(spec, str(info.field_name), info)

    def specs(self) -> dict[str, PolicySpec]:
        """Return the policies by kind, policies of pods only where they are given."""
        return {kind: spec for kind in KINDS if (spec := getattr(self, kind)) is not None}

    def of_pods(self, kind: str) -> PolicySpec:
        """Return the policy for a decision about pods: by default the first of ours."""
        spec: PolicySpec | None = getattr(self, kind)
        return PolicySpec(name=next(iter(catalogue.OURS[kind]))) if spec is None else spec

    def own(self) -> list[str]:
        """Return the policies that are the user's own; nothing is known about their code."""
        return sorted(spec.name for spec in self.specs().values() if spec.own)

    def problems(self, run_code: bool = False) -> list[Problem]:
        """List the problems of making the policies with their parameters; the user's own only with `run_code`."""
        return [
            Problem(("policies", kind, *([parameter] if parameter else ())), text)
            for kind, spec in self.specs().items()
            if run_code or not spec.own
            for parameter, text in catalogue.problems(kind, spec.name, spec.params)
        ]

    def is_random(self, _model: Any) -> bool:
        """Whether a policy draws, by its class attribute `random`; of the user's own nothing is known."""
        classes = (catalogue.find(kind, spec.name) for kind, spec in self.specs().items())
        return bool(self.own()) or any(getattr(policy, "random", False) for policy in classes)

    def sources(self) -> bytes:
        """Return the content of the files of the user's own policies: what a run depends on besides names."""
        return b"".join(catalogue.user_source(spec.name) for spec in self.specs().values())
