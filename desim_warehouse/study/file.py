"""The keys of a study file and of the arguments of `Study`, as `study.reading` checks them, and their JSON Schema.

For `desim study` and `Study`; `desim schema` prints the JSON Schema.

An example, of which only `model` must be there:

    name: Fleet size                       # for tables and figures
    description: one or two sentences
    model: ../models/multibots.yaml        # a model file, relative to the study file; or a whole model
    set:                                   # changes to the model, for all runs, as `--set` makes them
      tasks.goods: {random: 20}
    factors:                               # what is varied: any key of a model, and its values
      fleet.size: 1..6                     # whole numbers, both ends; 1..12..2 in steps of 2
      battery.threshold: [2, 3.5, 5]       # a list; ranges such as 1..3 may stand in it
      battery.capacity: {linspace: [5, 20, 4]}  # 4 values from 5 to 20
      policies.charging:                   # whole policies, with parameters
        - threshold
        - {name: opportunity, margin: 1}
      tasks.goods:                         # values with names: tables and figures show the names
        named: {group 1: [11, 8, 39], group 2: [74, 50, 62]}
      demand:                              # several keys changed together; the factor has a name of its own
        cases:
          today: {tasks.goods: {poisson: 200}}
          plus 30 %: {tasks.goods: {poisson: 260}, fleet.size: 6}
    design: grid                           # all combinations (default); or
                                           # paired: first values of all factors, then second values, ...
    replications: 20                       # a number; or until the mean is known well enough:
    # replications: {indicator: T, half_width: 2 %, confidence: 0.95, minimum: 30, cap: 200}
    seed: 0                                # replication r has the same run seed at every point
    indicators: [T, S, C]                  # columns of the table; default: all
    baseline: {fleet.size: 3}              # the design that others are compared with; default: the first
    confidence: 0.95
    target: on_time >= 95 %                # what designs should meet: reports name those that do
    timeout: 60                            # seconds that a run may take; default: no limit
    warm_up: auto                          # run.warm_up of each design from five pilot runs; default: the model's
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)

from desim_warehouse.errors import StudyError, got
from desim_warehouse.model import Model, json_schema
from desim_warehouse.model.messages import Outline
from desim_warehouse.outcome.indicators import INDICATORS, hint, look_up
from desim_warehouse.study.design import Rule, baseline_point, count, points
from desim_warehouse.study.factors import DRAW, Factor, Form, Label, factor_of, label, repeated
from desim_warehouse.study.statistics.limits import MOST_POINTS, MOST_REPLICATIONS, MOST_RUNS
from desim_warehouse.study.target import read_target
from desim_warehouse.values.fields import (
    NUMBER,
    SECTION,
    TOP,
    Count,
    Forms,
    Fraction,
    Part,
    Positive,
    Text,
    Whole,
    all_wrong,
    by_type,
    form,
    wrong,
)

if TYPE_CHECKING:
    from pydantic_core import PydanticCustomError

_MODEL = "a model file, relative to the study file, or a whole model"
_REPLICATIONS = "a number of at least 1, or {indicator: T, half_width: 2 %}"
_Several = Annotated[int, Field(strict=True, ge=2, le=MOST_REPLICATIONS)]


def _indicator(name: Any) -> Any:
    if isinstance(name, str) and look_up(name) is not None:
        return name
    raise wrong(f"unknown indicator (got {got(name)}), {hint(str(name), INDICATORS)}")


def _auto(value: Any) -> Any:
    if value in ("auto", None):
        return value
    time = f", or a time for all designs as set: {{run.warm_up: {got(value)}}}" if isinstance(value, NUMBER) else ""
    raise wrong(f"should be auto (got {got(value)}){time}")


def _target(text: str) -> str:
    try:
        read_target(text)
    except StudyError as error:
        raise wrong(str(error)) from None
    return text


IndicatorName = Annotated[str, BeforeValidator(_indicator)]


class Until(Part):
    """Replicate each point until the half-width of an indicator is a small share of its mean."""

    indicator: IndicatorName = Field(description="the name of an indicator")
    half_width: Fraction = Field(description="a share of the mean, such as 2 % or 0.02")
    confidence: Fraction = Field(0.95, description="a number between 0 and 1, such as 0.95")
    # 30, as a start that happens to be calm would end it too early (`statistics.precision`)
    minimum: _Several = Field(30, description=f"a whole number from 2 to {MOST_REPLICATIONS:,}")
    cap: _Several = Field(200, description=f"a whole number from 2 to {MOST_REPLICATIONS:,}")

    @model_validator(mode="before")
    @classmethod
    def _few_if_capped(cls, data: Any) -> Any:
        """Lower the minimum to a cap below it, where no minimum is given."""
        cap = data.get("cap") if isinstance(data, Mapping) else None
        usual = cls.model_fields["minimum"].default
        return {**data, "minimum": cap} if isinstance(cap, int) and cap < usual and "minimum" not in data else data

    @field_validator("cap")
    @classmethod
    def _not_below_minimum(cls, cap: int, info: ValidationInfo) -> int:
        least = info.data.get("minimum", cap)
        if cap < least:
            raise wrong(f"below the minimum (got {cap}), expected at least {least}")
        return cap


class StudyFile(Part):
    """The content of a study file, or the arguments of a study."""

    name: Text = Field("", description="text")
    description: Text = Field("", description="text")
    model: Annotated[Any, form("model"), Forms(_MODEL, pick=by_type(model=(str, Path, Mapping, Model)))] = Field(
        description=_MODEL
    )
    set: Mapping[str, Any] = Field({}, description="keys of the model and their values")
    factors: Mapping[str, Form] = Field({}, description="keys of the model, each followed by its values")
    design: Rule = Field("grid", description="grid or paired", validate_default=True)
    replications: Annotated[
        Annotated[Count, form("number")] | Annotated[Until, form("rule")],
        Forms(_REPLICATIONS, pick=by_type(number=NUMBER, rule=SECTION)),
    ] = Field(1, description=_REPLICATIONS)
    seed: Whole = Field(0, description="a whole number of at least 0")
    indicators: Annotated[tuple[IndicatorName, ...], Field(min_length=1)] = Field(
        (), description="a list of indicators such as [T, S, C]"
    )
    baseline: Mapping[str, Any] = Field({}, description="a value for each factor, such as {fleet.size: 3}")
    confidence: Fraction = Field(0.95, description="a number between 0 and 1, such as 0.95")
    target: Annotated[Text, AfterValidator(_target)] = Field(
        "", description="what designs should meet, such as on_time >= 95 %: reports name those that do"
    )
    timeout: Positive | None = Field(None, description="seconds that a run may take, above 0")
    warm_up: Annotated[Literal["auto"] | None, BeforeValidator(_auto)] = Field(
        None, description="`auto`: each design has its own `run.warm_up`, from five pilot runs of it (MSER-5)"
    )

    # What is checked over several keys; a check is left out where a key that it needs is wrong

    @model_validator(mode="before")
    @classmethod
    def _none_sampled(cls, data: Any) -> Any:
        """Refuse a sampled design with one message: the ranges of its factors would be refused as well."""
        design = data.get("design") if isinstance(data, Mapping) else None
        if isinstance(design, SECTION):
            raise wrong(f"no sampled designs since 0.4 (got {got(design)}), {DRAW}", "design")
        return data

    # A factor is read together with its key, so that a wrong key and a wrong value are found at once
    @field_validator("factors", mode="before")
    @classmethod
    def _with_keys(cls, factors: Any) -> Any:
        return {key: (key, value) for key, value in factors.items()} if isinstance(factors, Mapping) else factors

    @field_validator("design")
    @classmethod
    def _fits_the_factors(cls, design: Rule, info: ValidationInfo) -> Rule:
        if "factors" in info.data:
            problems = list(_misfits(_factors(info.data["factors"]), design))
            if problems:
                raise all_wrong(problems)
        return design

    @field_validator("replications")
    @classmethod
    def _not_too_many(cls, replications: int | Until, info: ValidationInfo) -> int | Until:
        many = replications.minimum if isinstance(replications, Until) else replications
        if many > MOST_REPLICATIONS:
            raise wrong(f"too many (got {many}), expected at most {MOST_REPLICATIONS:,}")
        if "factors" in info.data and "design" in info.data:
            runs = many * count(_factors(info.data["factors"]), info.data["design"])
            if runs > MOST_RUNS:
                expected = f"at most {MOST_RUNS:,} runs in all, fewer replications or designs"
                raise wrong(f"too many runs (got {runs:,}), expected {expected}")
        return replications

    @field_validator("baseline")
    @classmethod
    def _is_a_design(cls, baseline: Mapping[str, Any], info: ValidationInfo) -> Mapping[str, Any]:
        if not baseline or not {"factors", "design"} <= info.data.keys():
            return baseline
        factors = _factors(info.data["factors"])
        unknown = [key for key in baseline if key not in {factor.key for factor in factors}]
        if unknown:
            raise wrong(f"'{unknown[0]}' is no factor, expected values of factors (got {got(baseline)})")
        try:
            baseline_point(points(factors, info.data["design"]), labels(baseline))
        except StudyError as error:
            raise wrong(str(error).removeprefix("baseline: ")) from None
        return baseline

    @field_validator("warm_up")
    @classmethod
    def _given_once(cls, warm_up: str | None, info: ValidationInfo) -> str | None:
        for part in ("set", "factors"):
            if warm_up and "run.warm_up" in info.data.get(part, ()):
                raise wrong(f"auto, and run.warm_up is among the {part}: expected one of them")
        return warm_up

    # What a plan has of it

    def varied(self) -> tuple[Factor, ...]:
        """Return the factors that the study varies."""
        return _factors(self.factors)


def study_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of study files, for editors."""
    schema = StudyFile.model_json_schema()
    title = "desim-warehouse study"
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": title}


def schema(*, study: bool = False) -> dict[str, Any]:
    """Return the JSON Schema of model files or study files, for editors and forms.

    Returns:
        The schema as plain JSON values.
    """
    return study_schema() if study else json_schema()


def labels(baseline: Mapping[str, Any]) -> dict[str, Label]:
    """Return the values of a baseline as tables show them."""
    return {key: label(value) for key, value in baseline.items()}


def _factors(forms: Mapping[str, Any]) -> tuple[Factor, ...]:
    return tuple(factor_of(key, values) for key, values in forms.items())


def _misfits(factors: tuple[Factor, ...], rule: Rule) -> Iterator[PydanticCustomError]:
    """Yield the reasons for which the rule cannot make designs of these factors."""
    if rule == "grid":
        for level in (level for factor in factors for level in repeated(factor)):
            yield wrong(f"given twice (got {got(level.label)}), expected once", TOP, *level.keys)
    elif len({len(factor.levels) for factor in factors}) > 1:
        lengths = ", ".join(f"{factor.key}: {len(factor.levels)}" for factor in factors)
        yield wrong(f"lists of different lengths ({lengths}), expected as many values of each factor")
    if count(factors, rule) > MOST_POINTS:
        yield wrong(f"more than {MOST_POINTS:,} designs, expected fewer", TOP, "factors")


OUTLINE = Outline(StudyFile)
"""The keys that a study file can have."""
