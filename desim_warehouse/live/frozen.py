"""The page of `desim what-if --page` and of Share: a live page that contains all answers and needs no server."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from desim_warehouse._version import __version__
from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.parts import Option, ShownNumber
from desim_warehouse.errors import ModelError, ReportError
from desim_warehouse.live.busy import Busy, busy
from desim_warehouse.live.messages import About, Aim, Calculated, Knob, Measured, Tried, Watched, label
from desim_warehouse.look.web import WebPage, joined, safe_json
from desim_warehouse.outcome.targets import Target
from desim_warehouse.questions.compare_words import difference
from desim_warehouse.questions.study import Results
from desim_warehouse.study.plan import StudyPlan
from desim_warehouse.study.table import is_numeric
from desim_warehouse.values.labels import plain, readable

MOST = 120
"""Largest number of designs of a page, which holds the differences of all pairs."""
_ONLINE = ("01-feed.js", "03-watch.js")
_DIGITS = 6


class FrozenPage(WebPage):
    """A what-if page: `save` writes it to a file, and Jupyter displays it."""


def check(plan: StudyPlan) -> None:
    """Refuse a study that a page cannot show, before it is simulated.

    Raises:
        ReportError: too few or too many designs, or some combinations of the factors' values are missing.
    """
    count = len({str(point) for point in plan.points()})
    levels = [len({str(level.label) for level in factor.levels}) for factor in plan.factors]
    if count != math.prod(levels):
        raise ReportError(
            f"a page has a slider for each factor, so every combination must be a design (got {plan.rule}), "
            "expected design: grid"
        )
    if not 1 < count <= MOST:
        cure = "vary something, such as --vary fleet.size=1..6" if count == 1 else "vary less"
        raise ReportError(f"a page compares 2 to {MOST} options (got {count}), {cure}")


def page(
    about: About,
    designs: Sequence[tuple[Calculated, Watched]],
    differences: Sequence[Sequence[str | None]],
    *,
    start: int = 0,
    pinned: int | None = None,
    answers: Sequence[str] = (),
) -> FrozenPage:
    """Return the page of some designs, with all pairwise differences in the main indicator.

    Args:
        about: the model and its keys; values that no design has are removed.
        designs: the quick estimate and the results of each design.
        differences: the difference of each design (column) from each design (row) as text, or None.
        start: index of the design shown first.
        pinned: index of the pinned design, if any.
        answers: sentences above the designs.
    """
    levels = {knob.key: {asked.levels[knob.key] for asked, _ in designs} for knob in about.knobs}
    knobs = [_kept(knob, levels[knob.key]) for knob in about.knobs if len(levels[knob.key]) > 1]
    tried = [design for design in designs[0][1].tried if design.id in {asked.id for asked, _ in designs}]
    data = {
        "about": about.model_copy(update={"knobs": knobs, "colours": {}}).model_dump(),
        "tried": [design.model_dump() for design in tried],
        "designs": [
            [asked.model_dump(), answer.model_copy(update={"tried": [], "floor": False}).model_dump()]
            for asked, answer in designs
        ],
        "differences": differences,
        "start": start,
        "pinned": pinned,
        "answers": list(answers),
    }
    parts = {
        "title": html.escape(about.name),
        "frozen": f'<script type="application/json" id="frozen">{safe_json(data)}</script>',
    }
    return FrozenPage(about.name, joined("desim_warehouse.live", parts, without=_ONLINE))


def _kept(knob: Knob, values: set[Any]) -> Knob:
    """Return a knob reduced to some of its values."""
    kept = [place for place, value in enumerate(knob.values) if value in values]
    today = kept.index(knob.today) if knob.today in kept else None
    kept_values = {"values": [knob.values[place] for place in kept], "texts": [knob.texts[place] for place in kept]}
    return knob.model_copy(update={**kept_values, "today": today})


def what_if_page(study: Results, path: str | Path | None = None, *, command: str = "") -> FrozenPage:
    """Make the what-if page of a study, with the sentences and numbers of its answer.

    Args:
        study: the finished runs of a study whose designs are all combinations of its factors' values.
        path: file to write the page to; None for no file.
        command: the command as typed, which the page shows.

    Returns:
        The page, which Jupyter displays.

    Raises:
        ReportError: a study that a page cannot show (`check`), no finished run, or a path that cannot be written.
    """
    check(study.plan)
    if all(row.outcome.error is not None for row in study.rows):
        raise ReportError(f"{study.plan.name}: no run has finished, so a page has nothing to show")
    made = _Frozen(study, command).page()
    if path is not None:
        made.save(path)
    return made


class _Frozen:
    """The designs of a finished study as messages of a live page without a server."""

    def __init__(self, study: Results, command: str) -> None:
        self.study, self.command, self.answer = study, command, study.answer
        self.main = next(iter(self.answer.measures))
        self.scale = words.scale_of(self.main, study.base, study.estimates(self.main).values())
        self.designs = [design for design in study.designs if study.runs(design)]
        self.keys = study.varied

    def page(self) -> FrozenPage:
        study, about = self.study, self._about()
        watched = [self._watched(rank, design) for rank, design in enumerate(self.designs)]
        base = self.designs.index(study.baseline) if study.baseline in self.designs else 0
        name = None if self.answer.about is None else self.answer.about.name
        start = next((rank for rank, pair in enumerate(watched) if pair[0].words == name), len(watched) - 1)
        pinned = base if base != start else None
        table = [self._differences(design) for design in self.designs]
        return page(about, watched, table, start=start, pinned=pinned, answers=self.answer.answer)

    def _about(self) -> About:
        goal, study = self.study.target, self.study
        runs = max(len(study.runs(design)) for design in self.designs)
        unit = "%" if self.scale.is_share else self.scale.unit
        return About(
            name=self.answer.name,
            hash=study.base.digest(),
            knobs=[self._knob(key) for key in self.keys],
            target=None if goal is None else self._aim(goal, unit),
            indicator=self.main,
            label=words.indicator_name(self.main),
            unit=unit,
            runs=runs,
            promise=f"{self.answer.promise} {numbers.number(self.answer.runs)} runs, desim-warehouse {__version__}.",
            colours={},
            folder=self.command,
        )

    def _aim(self, goal: Target, unit: str) -> Aim:
        value = round(self.scale.by * goal.value, 9)
        label = words.indicator_name(goal.indicator)
        return Aim(
            indicator=goal.indicator, label=label, relation=goal.sense, value=value, least=value, most=value, step=1.0,
            unit=unit,
        )  # fmt: skip

    def _level(self, key: str, value: Any) -> int | float | str:
        value = plain(value)
        return value if is_numeric(self.study.levels(key)) else readable(value)

    def _knob(self, key: str) -> Knob:
        levels = self.study.levels(key)
        return Knob(
            key=key,
            label=words.factor_head(key, self.study.base.units),
            kind="number" if is_numeric(levels) else "choice",
            values=[self._level(key, value) for value in levels],
            texts=[words.level(value) for value in levels],
            today=self._own(key, levels),
        )

    def _own(self, key: str, levels: Sequence[Any]) -> int | None:
        """Return the index of the model's own value among the values tried; None if it is not among them."""
        base = self.study.base
        for rank, level in enumerate(levels):
            try:
                if base.replace({key: level}).digest() == base.digest():
                    return rank
            except ModelError:  # a value that is valid only together with a value of another key
                continue
        return None

    def _watched(self, rank: int, design: str) -> tuple[Calculated, Watched]:
        study, option = self.study, self._option(design)
        name = words.design_spoken({key: self._of(design, key) for key in self.keys})
        levels = {key: self._level(key, self._of(design, key)) for key in self.keys}
        runs = study.runs(design)
        result = option.instead or words.reached(self.main, option.text)
        year = "" if option.cost is None else f", {words.scale('annual_cost', study.base).value(option.cost)} a year"
        values = [value if math.isfinite(value) else None for value in study.values(design, self.main).tolist()]
        failed = all(row.outcome.error is not None for row in runs)
        at_work = Busy("", []) if failed else busy(runs, study.models[design], study.plan.confidence)
        asked = Calculated(id=str(rank), words=name, levels=levels, runs=len(runs), sentence="", more="", needed={})
        same = f"The runs are equal to those of {option.name}." if design in study.same else ""
        return asked, Watched(
            id=str(rank),
            n=len(runs),
            wanted=len(runs),
            done="all",
            seconds_left=None,
            verdict=option.standing,
            label=label(option.standing),
            sentence=capital(f"{result} with {name}{year}."),
            more=[same] if same else [],
            values=[None if value is None else float(f"{self.scale.by * value:.{_DIGITS}g}") for value in values],
            measured=[self._measured(number) for number in option.numbers],
            busiest=at_work.busiest,
            busy=at_work.loads,
            pinned=None,
            pinned_at=None,
            floor=False,
            tried=[] if rank else [self._tried(place, other) for place, other in enumerate(self.designs)],
            notes=list(self.answer.notes),
        )

    def _of(self, design: str, key: str) -> Any:
        return self.study.designs[design][self.study.factors.index(key)]

    def _option(self, design: str) -> Option:
        first = self.study.same.get(design, design)
        kept = [name for name in self.study.designs if self.study.runs(name) and name not in self.study.same]
        return self.answer.options[kept.index(first)]

    def _measured(self, number: ShownNumber) -> Measured:
        scale = words.scale_of(number.of, self.study.base, self.study.estimates(number.of).values())
        low, high = (None if end is None else scale.by * end for end in (number.low, number.high))
        unit = "%" if scale.is_share else scale.unit
        label = words.indicator_name(number.of)
        return Measured(
            name=number.of, label=label, unit=unit, text=number.text, mean=scale.by * number.mean, low=low, high=high
        )

    def _tried(self, rank: int, design: str) -> Tried:
        option = self._option(design)
        estimate = self.study.estimate(self.study.runs(design), self.main)
        return Tried(
            id=str(rank),
            words=words.design_spoken({key: self._of(design, key) for key in self.keys}),
            levels={key: self._level(key, self._of(design, key)) for key in self.keys},
            runs=len(self.study.runs(design)),
            text=numbers.NONE if estimate is None else self.scale.value(estimate.mean),
            verdict=option.standing,
        )

    def _differences(self, base: str) -> list[str | None]:
        """Return the difference of each design from `base` as text; designs with equal runs share a difference."""
        comparison = self.study.compare_finished(self.main, base)
        rows = {} if comparison is None else {str(row.design): row for row in comparison.differences}
        original = {design: self.study.same.get(design, design) for design in self.designs}
        texts = {name: difference(self.study, self.main, row).text for name, row in rows.items()}
        return [
            "none"
            if design != base and original[design] == original[base]
            else texts.get(original[design], texts.get(design))
            for design in self.designs
        ]
