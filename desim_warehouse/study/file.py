"""What a study file can say.

An example, of which only `model` must be there:

name: Fleet size                       # for tables and figures
description: one or two sentences
model: ../models/multibots.yaml        # a model file, relative to the study file; or a whole model
set:                                   # changes to the model, for all runs, as `--set` makes them
tasks.goods: {random: 20}
factors:                               # what is varied: any key of a model, and its values
fleet.size: 1..6                     # whole numbers, both ends; 1..12..2 in steps of 2
battery.threshold: [2, 3.5, 5]       # a list; ranges such as 1..3 may stand in it
battery.capacity: {linspace: [5, 20, 4]}    # 4 values from 5 to 20
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
# {latin-hypercube: 50}, {sobol: 64}: so many points; then a factor may
#   also be {between: [2, 5]} (whole numbers if both ends are whole;
#   {between: [2.0, 5.0]} is continuous)
# {saltelli: 64}: for Sobol indices, 64 x (factors + 2) points
replications: 20                       # a number; or until the mean is known well enough:
# replications: {indicator: T, half_width: 2 %, confidence: 0.95, minimum: 30, cap: 200}
seed: 0                                # replication r has the same run seed at every point
indicators: [T, S, C]                  # columns of the table; default: all
baseline: {fleet.size: 3}              # the design that others are compared with; default: the first
confidence: 0.95
timeout: 60                            # seconds that a run may take; default: no limit
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Discriminator,
    Field,
    ValidationError,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from desim_warehouse.errors import StudyError, got, nearest, spoken
from desim_warehouse.fields import Part, Positive, Text, Whole, form
from desim_warehouse.indicators import INDICATORS
from desim_warehouse.model import Model
from desim_warehouse.model.messages import Problem
from desim_warehouse.study.design import SAMPLED, Rule, baseline_point, count, points
from desim_warehouse.study.factors import (
    ABSOLUTE,
    EXPECTED,
    FORMS,
    RESERVED,
    Factor,
    Form,
    Keys,
    Label,
    factor_of,
    is_known,
    label,
    no_such_key,
    refusal,
    refused,
)
from desim_warehouse.study.limits import MOST_POINTS, MOST_REPLICATIONS, MOST_RUNS

if TYPE_CHECKING:
    from collections.abc import Iterator

_SHARE = re.compile(r"\s*(\d+\.?\d*|\.\d+)\s*%\s*")


def share(value: Any) -> Any:
    """2 % as 0.02; anything else as it is."""
    match = _SHARE.fullmatch(value) if isinstance(value, str) else None
    return float(match[1]) / 100 if match else value


def _indicator(name: Any) -> Any:
    if name in INDICATORS:
        return name
    near = nearest(str(name), INDICATORS)
    hint = f"did you mean '{near}'?" if near else f"expected one of {', '.join(INDICATORS)}"
    raise refusal([Problem((), f"unknown indicator (got {got(name)}), {hint}")])


def _power_of_two(size: int) -> int:
    if size < 2 or size & (size - 1):  # noqa: PLR2004
        raise refusal([Problem.of((), "not a power of 2", size, "32, 64, 128, ...")])
    return size


Share = Annotated[
    float,
    BeforeValidator(share),
    Field(strict=True, gt=0, lt=1),
    WithJsonSchema({"type": ["number", "string"], "exclusiveMinimum": 0, "exclusiveMaximum": 1}),
]
"""A share of 1, given as 0.02 or as 2 %."""
Indicator = Annotated[str, BeforeValidator(_indicator)]
_Size = Annotated[int, Field(strict=True, ge=1, le=MOST_POINTS)]
_Several = Annotated[int, Field(strict=True, ge=2, le=MOST_REPLICATIONS)]


class Until(Part):
    """Replicate each point until the half-width of an indicator is a small share of its mean."""

    indicator: Indicator = Field(description="the name of an indicator")
    half_width: Share = Field(description="a share of the mean, such as 2 % or 0.02")
    confidence: Share = Field(0.95, description="a number between 0 and 1, such as 0.95")
    minimum: _Several = Field(30, description=f"a whole number from 2 to {MOST_REPLICATIONS:,}")
    cap: _Several = Field(200, description=f"a whole number from 2 to {MOST_REPLICATIONS:,}")

    @model_validator(mode="before")
    @classmethod
    def _few_if_capped(cls, data: Any) -> Any:
        """A cap below the usual minimum is the minimum, where none is given."""
        cap = data.get("cap") if isinstance(data, Mapping) else None
        usual = cls.model_fields["minimum"].default
        return {**data, "minimum": cap} if isinstance(cap, int) and cap < usual and "minimum" not in data else data

    @field_validator("cap")
    @classmethod
    def _not_below_minimum(cls, cap: int, info: ValidationInfo) -> int:
        least = info.data.get("minimum", cap)
        if cap < least:
            raise refusal([Problem.of((), "below the minimum", cap, f"at least {least}")])
        return cap


class Sampled(Part):
    """A design that draws its points: one of these, with a number of points."""

    latin_hypercube: _Size | None = Field(
        None, alias="latin-hypercube", description=f"a whole number from 1 to {MOST_POINTS:,}"
    )
    sobol: Annotated[_Size, AfterValidator(_power_of_two)] | None = Field(None, description="a power of 2")
    saltelli: Annotated[_Size, AfterValidator(_power_of_two)] | None = Field(None, description="a power of 2")

    @property
    def rule(self) -> Rule:
        """The rule that is given."""
        return next(Rule(name, size) for name, size in self.content().items() if size is not None)


def _one_rule(given: Any) -> Any:
    if isinstance(given, Mapping) and len(given) != 1:
        raise refused("not understood")
    return given


def _section(given: Any) -> str:
    return "\0section" if isinstance(given, Mapping | Part) else "\0plain"


def _is_model(given: Any) -> Any:
    if not isinstance(given, str | Path | Mapping | Model):
        raise refused("not a file name")
    return given


class StudyFile(Part):
    """What a study file says, or the arguments of a study."""

    name: Text = Field("", description="text")
    description: Text = Field("", description="text")
    model: Annotated[Any, BeforeValidator(_is_model)] = Field(
        description="a model file, relative to the study file, or a whole model"
    )
    set: Mapping[str, Any] = Field({}, description="keys of the model and their values")
    factors: Mapping[str, Form] = Field({}, description="keys of the model, each followed by its values")
    design: Annotated[
        Annotated[Literal["grid", "paired"], form("plain")] | Annotated[Sampled, form("section")],
        Discriminator(_section),
        BeforeValidator(_one_rule),
    ] = Field(
        "grid",
        description="grid, paired, {latin-hypercube: 50}, {sobol: 64} or {saltelli: 64}",
        validate_default=True,
    )
    replications: Annotated[
        Annotated[int, Field(strict=True, ge=1), form("plain")] | Annotated[Until, form("section")],
        Discriminator(_section),
    ] = Field(1, description="a number of at least 1, or {indicator: T, half_width: 2 %}")
    seed: Whole = Field(0, description="a whole number of at least 0")
    indicators: Annotated[tuple[Indicator, ...], Field(min_length=1)] = Field(
        (), description="a list of indicators such as [T, S, C]"
    )
    baseline: Mapping[str, Any] = Field({}, description="a value for each factor, such as {fleet.size: 3}")
    confidence: Share = Field(0.95, description="a number between 0 and 1, such as 0.95")
    timeout: Positive | None = Field(None, description="seconds that a run may take, above 0")

    # What is checked over several keys; a check is left out where a key that it needs is wrong

    @field_validator("factors", mode="wrap")
    @classmethod
    def _varied_keys(cls, given: Any, read: ValidatorFunctionWrapHandler) -> Any:
        problems = []
        for key, given_as in given.items() if isinstance(given, Mapping) else ():
            if key in RESERVED:
                text = "a name that tables use, expected another"
                problems.append(Problem(("factors", key), text, at_key=True))
            elif not (isinstance(given_as, Mapping) and "cases" in given_as) and not is_known(key):
                problems.append(no_such_key(("factors", key), key))
        try:
            made = read(given)
        except ValidationError as error:
            problems += problems_of(error, {"factors": given}, ("factors",))
        if problems:
            raise refusal(problems, absolute=True)
        return made

    @field_validator("design")
    @classmethod
    def _fits_the_factors(cls, design: Any, info: ValidationInfo) -> Any:
        if "factors" in info.data:
            problems = list(_misfits(_factors(info.data["factors"]), _rule(design)))
            if problems:
                raise refusal(problems, absolute=True)
        return design

    @field_validator("replications")
    @classmethod
    def _not_too_many(cls, replications: int | Until, info: ValidationInfo) -> int | Until:
        many = replications.minimum if isinstance(replications, Until) else replications
        if many > MOST_REPLICATIONS:
            raise refusal([Problem.of((), "too many", many, f"at most {MOST_REPLICATIONS:,}")])
        if "factors" in info.data and "design" in info.data:
            runs = many * count(_factors(info.data["factors"]), _rule(info.data["design"]))
            if runs > MOST_RUNS:
                expected = f"at most {MOST_RUNS:,} runs in all, fewer replications or designs"
                raise refusal([Problem((), f"too many runs (got {runs:,}), expected {expected}")])
        return replications

    @field_validator("baseline")
    @classmethod
    def _is_a_design(cls, baseline: Mapping[str, Any], info: ValidationInfo) -> Mapping[str, Any]:
        if not baseline or not {"factors", "design", "seed"} <= info.data.keys():
            return baseline
        factors = _factors(info.data["factors"])
        unknown = [key for key in baseline if key not in {factor.key for factor in factors}]
        if unknown:
            text = f"'{unknown[0]}' is no factor, expected values of factors (got {got(baseline)})"
            raise refusal([Problem((), text)])
        try:
            baseline_point(points(factors, _rule(info.data["design"]), info.data["seed"]), labels(baseline))
        except StudyError as error:
            raise refusal([Problem((), str(error).removeprefix("baseline: "))]) from None
        return baseline

    # What a plan has of it

    def varied(self) -> tuple[Factor, ...]:
        """The factors."""
        return _factors(self.factors)

    @property
    def rule(self) -> Rule:
        """How designs come from the factors."""
        return _rule(self.design)


def study_schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of study files, for editors."""
    schema = StudyFile.model_json_schema()
    title = "desim-warehouse study"
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": title}


def labels(baseline: Mapping[str, Any]) -> dict[str, Label]:
    """The values of a baseline as tables show them."""
    return {key: label(value) for key, value in baseline.items()}


def _factors(forms: Mapping[str, Any]) -> tuple[Factor, ...]:
    return tuple(factor_of(key, form) for key, form in forms.items())


def _rule(design: str | Sampled) -> Rule:
    return design.rule if isinstance(design, Sampled) else Rule(design)


def _misfits(factors: tuple[Factor, ...], rule: Rule) -> Iterator[Problem]:
    """Why the rule cannot make designs of these factors."""
    if not rule.sampled:
        said = f"a range to draw from needs a sampled design, expected design {spoken(SAMPLED, 'or')}"
        for factor in factors:
            if factor.between:
                yield Problem(("factors", factor.key, "between"), f"{said}, or a list of values")
    elif len(factors) < (2 if rule.name == "saltelli" else 1):
        yield Problem.of(("design", rule.name), "too few factors", len(factors), "factors to draw values for")
    if rule.name == "paired" and len({len(factor.levels) for factor in factors}) > 1:
        lengths = ", ".join(f"{factor.key}: {len(factor.levels)}" for factor in factors)
        text = f"lists of different lengths ({lengths}), expected as many values of each factor"
        yield Problem(("design",), text)
    if count(factors, rule) > MOST_POINTS:
        yield Problem(("factors",), f"more than {MOST_POINTS:,} designs, expected fewer")


# From what pydantic finds to messages


def problems_of(error: ValidationError, data: Mapping[str, Any], under: Keys = ()) -> list[Problem]:
    """What is wrong with a study file, in words; `under`: the keys of the value that was checked."""
    return [_problem(item, data, under) for item in error.errors(include_url=False)]


def _problem(item: Any, data: Mapping[str, Any], under: Keys) -> Problem:
    loc: Keys = (*under, *item["loc"])
    if ABSOLUTE in loc:
        loc = loc[loc.index(ABSOLUTE) + 1 :]
    loc = tuple(step for step in loc if not str(step).startswith("\0"))
    keys = _in_file(loc, data)
    match item["type"]:
        case "wrong" if "text" in item["ctx"]:  # of a kind of value that models have, too
            return Problem(keys, item["ctx"]["text"])
        case "problem":
            problem: Problem = item["ctx"]["problem"]
            return replace(problem, keys=keys)
        case "missing" if len(loc) == 1 or loc[0] == "replications":
            return Problem(loc, f"missing, expected {_expected(loc)[1]}", missing=True)
        case "extra_forbidden":
            known = [field.alias or name for name, field in _SECTIONS.get(keys[:-1], StudyFile).model_fields.items()]
            near = nearest(str(keys[-1]), known)
            hint = f"did you mean '{near}'?" if near else f"expected {spoken(known, 'or')}"
            return Problem(keys, f"unknown key, {hint}", at_key=True)
    keys, expected = _expected(keys)
    wrong = item["ctx"]["wrong"] if item["type"] == "wrong" else "not understood"
    return Problem.of(keys, wrong, _value(keys, data), expected)


_SECTIONS: dict[Keys, type[Part]] = {(): StudyFile, ("design",): Sampled, ("replications",): Until}


def _in_file(loc: Keys, data: Any) -> Keys:
    """Where an error is in the file: without steps that are no keys there, such as the names of forms."""
    keys: Keys = ()
    for step in loc:
        if isinstance(data, Mapping) and step in data:
            keys, data = (*keys, step), data[str(step)]
        elif isinstance(data, list | tuple) and isinstance(step, int):
            keys, data = (*keys, step), data[step] if step < len(data) else None
    return keys


def _value(keys: Keys, data: Any) -> Any:
    for key in keys:
        data = data[key]
    return data


def _expected(keys: Keys) -> tuple[Keys, str]:
    """The innermost key around an error of which is known what it expects, and what that is."""
    match keys:
        case ("factors", _, str(form), *_) if form in FORMS:
            return keys[:3], str(FORMS[form].model_fields[form].description)
        case ("factors", _, *_):
            return keys[:2], EXPECTED
        case ("replications" | "design", str(key), *_):
            part = _SECTIONS[keys[:1]]
            names = {field.alias or name: field for name, field in part.model_fields.items()}
            return keys[:2], str(names[key].description)
    return keys[:1], str(StudyFile.model_fields[str(keys[0])].description)
