"""From a study file, or from arguments, to a plan: every problem at once, each with its place."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import ModelError, got, nearest, spoken
from desim_warehouse.model import Model, load
from desim_warehouse.model.messages import Places, Problem, report
from desim_warehouse.model.parse import Document, plain
from desim_warehouse.model.read import kind_of, read_document
from desim_warehouse.policies.catalogue import resolved_in
from desim_warehouse.study.design import RULES, SAMPLED, Rule
from desim_warehouse.study.factors import RESERVED, Factor, Keys, label, read_factor
from desim_warehouse.study.plan import Plan, Until, check_baseline, models
from desim_warehouse.study.until import is_indicator, is_number, read_until

if TYPE_CHECKING:
    from collections.abc import Iterable

KEYS = {
    "name": "text",
    "description": "text",
    "model": "a model file, relative to the study file, or a whole model",
    "set": "keys of the model and their values",
    "factors": "keys of the model, each followed by its values",
    "design": "grid, paired, {latin-hypercube: 50}, {sobol: 64} or {saltelli: 64}",
    "replications": "a number of at least 1, or {indicator: T, half_width: 2 %}",
    "seed": "a whole number of at least 0",
    "indicators": "a list of indicators such as [T, S, C]",
    "baseline": "a value for each factor, such as {fleet.size: 3}",
    "confidence": "a number between 0 and 1, such as 0.95",
    "timeout": "seconds that a run may take, above 0",
}
_MOST_POINTS = 1_000_000


def read_study(path: str | Path, overrides: Mapping[str, Any] | None = None, *, named: str = "override") -> Plan:
    """The plan of a study file.

    Args:
        path: the file.
        overrides: further changes to the model, for all runs; they win over the file's `set`.
        named: how messages call an override; the command line says `--set`.

    Raises:
        ModelError: with every problem of the study, and of its model.
    """
    document = read_document(Path(path), str(path), "a study with model and factors")
    if kind_of(document.data) == "model":
        takers = f"desim run {path} simulates it, desim what-if and desim best vary it with --vary"
        raise ModelError([f"{path}: a model file, expected a study file; {takers}"])
    return read_plan(document, Path(path).parent, overrides or {}, named)


def plan_of(
    base: str | Path | Mapping[str, Any] | Model,
    content: Mapping[str, Any],
    options: Mapping[Keys, str] | None = None,
) -> Plan:
    """The plan of a study given by arguments.

    Args:
        base: a model, its file, or its content.
        content: the keys of a study file but `model`.
        options: where keys were given on the command line, and how messages name them.

    Raises:
        ModelError: with every problem of the study, its model and its designs.
    """
    problems: list[Problem] = []
    made = plain({key: value for key, value in content.items() if value is not None}, (), problems)
    places = Places(str(made.get("name", "study")) if options else "study")
    for keys, option in (options or {}).items():
        places.given(keys, option)
    return _Reader(Document(made, places, problems)).plan(lambda changes: _base(base, changes), "study")


def read_plan(document: Document, folder: Path, overrides: Mapping[str, Any], named: str) -> Plan:
    """The plan of a study that was read from a file in `folder`."""
    reader = _Reader(document)
    for part in ("set", "factors"):
        if part in document.data:
            document.data[part] = resolved_in(document.data[part], folder)
    changes = document.data.get("set") or {}
    if overrides and isinstance(changes, Mapping):
        document.data["set"] = {**changes, **overrides}
        for key in overrides:
            document.places.given(("set", key), f"{named} {key}")
    given = document.data.pop("model", None)
    name = Path(document.places.source).stem
    if isinstance(given, str):
        given = Path(given) if Path(given).is_absolute() else folder / given
    elif not isinstance(given, Mapping):
        wrong = "missing" if given is None else f"not a file name (got {got(given)})"
        reader.problems.append(Problem(("model",), f"{wrong}, expected {KEYS['model']}"))
        given = None
    return reader.plan(lambda changes: _base(given, changes), name)


def _base(given: Any, changes: Mapping[str, Any]) -> Model | None:
    """The model that the study varies; studies need no more than indicators, so little is logged."""
    if given is None:
        return None
    changes = {"log": "tasks", **changes}
    if isinstance(given, Model):
        return given.replace(changes, run_code=True)
    return load(given, changes, named="set", run_code=True)


class _Reader:
    """Reads the keys of one study."""

    def __init__(self, document: Document) -> None:
        self.data: dict[str, Any] = document.data
        self.places = document.places
        self.problems = document.problems

    def plan(self, base: Callable[[Mapping[str, Any]], Model | None], name: str) -> Plan:
        """The plan, or every problem.

        Raises:
            ModelError: with the problems of the study, then those of its model or of its designs.
        """
        for key in self.data:
            if key not in KEYS:
                near = nearest(key, KEYS)
                hint = f"did you mean '{near}'?" if near else f"expected {spoken(KEYS, 'or')}"
                self.problems.append(Problem((key,), f"unknown key, {hint}", at_key=True))
        changes = self.section("set")
        fields: dict[str, Any] = {
            "name": self.text("name", name),
            "description": self.text("description", ""),
            "factors": tuple(self.factors()),
            "rule": self.rule(),
            "replications": self.replications(),
            "seed": self.number("seed", 0, whole=True, least=0),
            "indicators": tuple(self.indicators()),
            "baseline": {key: label(value) for key, value in self.section("baseline").items()} or None,
            "confidence": self.number("confidence", 0.95, above=0, below=1),
            "timeout": self.number("timeout", None, above=0),
        }
        self.fits(fields["factors"], fields["rule"])
        lines: list[str] = []
        try:
            model = base(changes)
        except ModelError as error:
            model, lines = None, [self.in_set(text) for text in error.problems]
        if not self.problems and model is not None:
            self.checked(Plan(model, **fields))
        if self.problems or lines or model is None:
            raise ModelError([*self.lines(), *lines])
        return Plan(model, **fields)

    def checked(self, plan: Plan) -> None:
        """See that every design is a model, and that there is such a baseline."""
        wrong = check_baseline(plan)
        if wrong:
            self.problems.append(Problem(("baseline",), wrong))
        try:
            models(plan, plan.points(), self.places, run_code=True)
        except ModelError as error:
            raise ModelError([*self.lines(), *error.problems]) from None

    def lines(self) -> list[str]:
        return report(self.problems, self.places)

    def in_set(self, text: str) -> str:
        """A problem of the model, said where `set` makes it if it does."""
        for key in sorted(self.section("set"), key=len, reverse=True):
            begin = f"set {key}: "
            if text.startswith(begin):
                return f"{self.places.line(('set', key))[1]}: {text.removeprefix(begin)}"
        return text

    # Keys, one by one

    def wrong(self, keys: Keys, wrong: str, value: Any, expected: str | None = None) -> None:
        self.problems.append(Problem.of(keys, wrong, value, expected or KEYS[str(keys[0])]))

    def text(self, key: str, default: str) -> str:
        value = self.data.get(key, default)
        if not isinstance(value, str):
            self.wrong((key,), "not text", value)
            return default
        return value

    def section(self, key: str) -> Mapping[str, Any]:
        value = self.data.get(key)
        if value is None:
            return {}
        if not isinstance(value, Mapping):
            self.wrong((key,), "not a section", value)
            return {}
        return value

    def number(
        self,
        key: str,
        default: float | None,
        *,
        whole: bool = False,
        least: float = -math.inf,
        above: float = -math.inf,
        below: float = math.inf,
    ) -> float | None:
        value = self.data.get(key, default)
        if value is None:
            return default
        if not is_number(value, whole=whole) or value < least or not above < value < below:
            self.wrong((key,), "not understood", value)
            return default
        return float(value) if not whole else int(value)

    def indicators(self) -> Sequence[str]:
        value = self.data.get("indicators")
        if value is None:
            return []
        if not isinstance(value, list) or not value:
            self.wrong(("indicators",), "not a list of names", value)
            return []
        return [name for rank, name in enumerate(value) if is_indicator(("indicators", rank), name, self.problems)]

    def factors(self) -> Iterable[Factor]:
        for key, spec in self.section("factors").items():
            if key in RESERVED:
                self.problems.append(Problem(("factors", key), "a name that tables use, expected another", at_key=True))
                continue
            factor = read_factor(key, spec, self.problems)
            if factor is not None:
                yield factor

    def rule(self) -> Rule:
        value = self.data.get("design", "grid")
        if isinstance(value, str) and value in RULES:
            return Rule(value)
        if isinstance(value, Mapping) and len(value) == 1:
            name, size = next(iter(value.items()))
            if name not in SAMPLED:
                near = nearest(name, SAMPLED)
                hint = f"did you mean '{near}'?" if near else f"expected {spoken(SAMPLED, 'or')}"
                self.problems.append(Problem(("design", name), f"unknown key, {hint}", at_key=True))
            elif not is_number(size, whole=True) or not 1 <= size <= _MOST_POINTS:
                self.wrong(("design", name), "not a number of points", size, "a whole number of at least 1")
            elif name != "latin-hypercube" and (size < 2 or size & (size - 1)):  # noqa: PLR2004
                self.wrong(("design", name), "not a power of 2", size, "32, 64, 128, ...")
            else:
                return Rule(name, size)
        else:
            self.wrong(("design",), "not understood", value)
        return Rule()

    def replications(self) -> int | Until:
        value = self.data.get("replications", 1)
        if is_number(value, whole=True) and value >= 1:
            return int(value)
        if isinstance(value, Mapping):
            return read_until(value, self.problems) or 1
        self.wrong(("replications",), "not understood", value)
        return 1

    def fits(self, factors: Sequence[Factor], rule: Rule) -> None:
        """See that the factors fit the rule."""
        sampled = rule.name in SAMPLED
        for factor in factors:
            if factor.between and not sampled:
                keys: Keys = ("factors", factor.key, "between")
                said = f"a range to draw from needs a sampled design, expected design {spoken(SAMPLED, 'or')}"
                self.problems.append(Problem(keys, f"{said}, or a list of values"))
        if sampled and len(factors) < (2 if rule.name == "saltelli" else 1):
            self.wrong(("design", rule.name), "too few factors", len(factors), "factors to draw values for")
        if rule.name == "paired" and len({len(factor.levels) for factor in factors}) > 1:
            said = ", ".join(f"{factor.key}: {len(factor.levels)}" for factor in factors)
            self.problems.append(
                Problem(("design",), f"lists of different lengths ({said}), expected as many values of each factor")
            )
        if rule.name == "grid" and math.prod(len(factor.levels) for factor in factors) > _MOST_POINTS:
            self.problems.append(Problem(("factors",), f"more than {_MOST_POINTS:,} designs, expected fewer"))
