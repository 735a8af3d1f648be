"""Keys that a live page offers to change: robots, chargers, demand and allocation, or keys that the user names."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from desim_warehouse.answer import numbers, words
from desim_warehouse.errors import StudyError, nearest, spoken
from desim_warehouse.model import Model
from desim_warehouse.model.facts.demand import arrival_rate
from desim_warehouse.policies import catalogue
from desim_warehouse.questions.study import Study
from desim_warehouse.study.factors import label, level_of
from desim_warehouse.study.fleet.designs import Designs
from desim_warehouse.study.table import is_numeric
from desim_warehouse.values.labels import readable

ROBOTS, DEMAND, ALLOCATION = "fleet.size", "tasks.demand", "policies.allocation"
_MOST = 60
"""Largest number of steps of a slider whose values the user does not name."""
_DEMANDS = range(5, 21)
"""The demands on offer, in tenths of today's demand."""


@dataclass(frozen=True)
class Offer:
    """A key of the model and the values that the page offers for it: `values[today]` is the value in the model.

    `changes`: overrides of the model for each value. `texts`: each value as text. Numbers have a slider.
    """

    key: str
    label: str
    values: tuple[Any, ...]
    texts: tuple[str, ...]
    changes: tuple[Mapping[str, Any], ...]
    today: int

    @property
    def is_number(self) -> bool:
        """Whether the values of the key are numbers, ascending."""
        return is_numeric(self.values)

    def place(self, value: Any) -> int | None:
        """Return the index of an offered value; None for any other value, or another type."""
        kind = (int, float) if self.is_number else str
        fits = isinstance(value, kind) and not isinstance(value, bool)
        return self.values.index(value) if fits and value in self.values else None


def offers(model: Model, vary: Mapping[str, Any] | Iterable[str] = ()) -> dict[str, Offer]:
    """Offer the keys of a model that a page may change, with their values.

    Args:
        model: the model as it is today.
        vary: keys, with their values as in a study file, or None for the usual values; empty for the usual keys.

    Raises:
        ModelError: invalid values.
        StudyError: a key without values that has no usual values.
    """
    usual = _usual(model)
    if not vary:
        return usual
    wanted = vary if isinstance(vary, Mapping) else dict.fromkeys(vary)
    offered = {}
    for key, values in wanted.items():
        if values is not None:
            offered[key] = _given(model, key, values)
        elif key in usual:
            offered[key] = usual[key]
        else:
            near = nearest(key, usual)
            hint = f"did you mean {near!r}?" if near else f"only {spoken(list(usual), 'and')} can do without values"
            raise StudyError(f"--vary {key}: no values, expected {key}=VALUES; {hint}")
    return offered


def levels_of(offered: Mapping[str, Offer], changes: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the values by key that make exactly these changes to the model; None if no offered values do."""
    levels, made = {}, dict[str, Any]()
    for key, offer in offered.items():
        fits = [place for place, change in enumerate(offer.changes) if change and change.items() <= changes.items()]
        place = fits[0] if fits else offer.today
        levels[key] = offer.values[place]
        made |= offer.changes[place]
    return levels if made == changes else None


def spoken_design(offered: Mapping[str, Offer], places: Mapping[str, int]) -> str:
    """Return a design in words: its robots and chargers, and all other values that differ from the model's.

    `places`: the index of the value of each key.
    """
    chosen = {}
    for key, offer in offered.items():
        counted = key == ROBOTS or key.endswith(".total_chargers")
        if counted or places[key] != offer.today:
            chosen[key] = offer.values[places[key]] if offer.key != DEMAND else None
    demand = chosen.pop(DEMAND, 0)
    text = words.design_spoken(chosen) if chosen else ""
    if demand is None:
        offer = offered[DEMAND]
        more = f"{offer.texts[places[DEMAND]]}" + (" orders an hour" if "demand" not in offer.label else " demand")
        text = f"{text}, {more}" if text else more
    return text or "the model as it is"


def _usual(model: Model) -> dict[str, Offer]:
    size = model.fleet.size
    usual = {}
    if not model.fleet.kinds:
        usual[ROBOTS] = _counts(ROBOTS, "Robots", size, [{ROBOTS: n} for n in _range(size)], _range(size))
    designs = Designs(model)
    if designs.zone is not None:
        here = designs.today - designs.elsewhere
        key, some = f"layout.bays.{designs.zone}.total_chargers", _range(here)
        name = f"Chargers in {designs.zone}" if designs.elsewhere else "Chargers"
        usual[key] = _counts(key, name, here, [designs.of_chargers(designs.elsewhere + n) for n in some], some)
    if model.tasks.grow:
        usual[DEMAND] = _demand(model)
    now = model.policies.allocation
    if not now.params:
        complete = (
            name for name in sorted(catalogue.OURS["allocation"]) if not catalogue.problems("allocation", name, {})
        )
        names = tuple(dict.fromkeys((now.name, *complete)))
        changes = tuple({} if name == now.name else {ALLOCATION: name} for name in names)
        usual[ALLOCATION] = Offer(
            ALLOCATION, "Dispatching", names, tuple(words.policy(ALLOCATION, name) for name in names), changes, 0
        )
    return usual


def _range(today: int) -> list[int]:
    """Return integers around today's number, up to more than twice this number."""
    most = max(math.ceil(2.2 * today), 6)
    step = math.ceil(most / _MOST)
    return sorted({today, *range(step, most + 1, step)})


def _counts(key: str, name: str, today: int, changes: Sequence[Mapping[str, Any]], some: list[int]) -> Offer:
    texts = tuple(numbers.number(value) for value in some)
    own = tuple({} if value == today else change for value, change in zip(some, changes, strict=True))
    return Offer(key, name, tuple(some), texts, own, some.index(today))


def _demand(model: Model) -> Offer:
    now, rate = model.tasks.demand, arrival_rate(model)
    parts = [round(now * tenths / 10, 9) for tenths in _DEMANDS]
    hour = model.units.hour
    texts = (
        [f"{tenths * 10} %" for tenths in _DEMANDS]
        if rate is None
        else [numbers.number(rate * hour * tenths / 10, 0) for tenths in _DEMANDS]
    )
    changes = tuple({} if part == now else {DEMAND: part} for part in parts)
    name = "Orders an hour" if rate is not None else "Share of today's demand"
    return Offer(DEMAND, name, tuple(parts), tuple(texts), changes, _DEMANDS.index(10))


def _given(model: Model, key: str, values: Any) -> Offer:
    """Offer the values that a user names, and the model's value."""
    (factor,) = Study(model, {key: values}).plan.factors
    levels: dict[Any, Mapping[str, Any]] = {level.label: level.overrides for level in factor.levels}
    now = label(level_of(model, key))
    levels[now] = {}
    is_number = is_numeric(list(levels))
    ordered = sorted(levels) if is_number else list(levels)
    texts = tuple(words.level(value) for value in ordered)
    unit = words.factor_head(key, model.units)
    as_sent = tuple(ordered if is_number else [readable(value) for value in ordered])
    return Offer(key, unit, as_sent, texts, tuple(levels[value] for value in ordered), ordered.index(now))
