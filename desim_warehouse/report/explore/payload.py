"""What the what-if page holds: designs, their means, the differences of every two of them, and what was run."""

from __future__ import annotations

import math
import shlex
from datetime import datetime
from typing import TYPE_CHECKING, Any

from desim_warehouse._version import simulated_with
from desim_warehouse.outcome.indicators import look_up
from desim_warehouse.report.text import judged, numbers, sentences, words
from desim_warehouse.study.factors import readable
from desim_warehouse.study.table import is_numeric, plain

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from desim_warehouse.report.text.numbers import Scale
    from desim_warehouse.study.results import Results
    from desim_warehouse.study.statistics import Difference, Estimate

DIGITS = 6
"""Significant digits of what is drawn; what is written comes as text."""


def payload(study: Results, command: str) -> dict[str, Any]:
    """The content of the page as JSON. A design is known by its rank in `designs`."""
    first = [study.target.indicator] if study.target else []
    shown = dict.fromkeys([*first, *(study.plan.indicators or study.usual())])
    indicators = [name for name in shown if _has_value(study, name)]
    designs = list(study.designs)
    found = {name: [study.estimate(study.runs(design), name) for design in designs] for name in indicators}
    scales = {name: words.scale_of(name, study.base, of_name) for name, of_name in found.items()}
    differences = {name: _differences(study, name, scales[name]) for name in indicators}
    statements = sorted({said for of_name in differences.values() for said, _ in of_name if said})
    return {
        "model": study.base.name,
        "name": study.plan.name,
        "description": study.plan.description or study.base.description,
        "summary": _summary(study),
        "factors": [_factor(study, key) for key in study.varied],
        "indicators": [_indicator(name, scales[name]) for name in indicators],
        "designs": [_design(study, design) for design in designs],
        "means": {name: [_mean(one, scales[name]) for one in found[name]] for name in indicators},
        "values": {name: [_values(study, design, name, scales[name]) for design in designs] for name in indicators},
        "differences": {name: [rows for _, rows in differences[name]] for name in indicators},
        "statements": statements,
        "promises": {
            name: [statements.index(said) if said else None for said, _ in differences[name]] for name in indicators
        },
        "start": _start(study),
        "target": _target(study, scales),
        "answer": list(study.answer.answer),
        "facts": facts(study),
        "wrong": [sentences.sentence(line) for line in sentences.wrong(study, lasting=True)],
        "command": command
        or (shlex.join(["desim", "study", str(study.folder), "--page", "FILE"]) if study.folder else ""),
    }


def facts(study: Results) -> list[tuple[str, str]]:
    """What was run, in enough detail to run it again."""
    plan, units = study.plan, study.base.units
    failed = sum(row.outcome.error is not None for row in study.rows)
    length = study.base.run.length
    seeds = sorted({(row.replication, row.seed) for row in study.rows})
    rows = [
        ("Model", f"{study.base.name}, SHA-256 {study.base.digest()}"),
        *(
            (words.factor_head(key, units), ", ".join(map(readable, map(plain, study.levels(key)))))
            for key in study.factors
        ),
        ("Designs", f"{len(study.designs)}, all combinations"),
        ("Replications", words.replications(plan)),
        ("Runs", f"{len(study.rows):,}" + (f", {failed:,} of them failed and are left out" if failed else "")),
        ("Run length", "until all work is done" if length is None else numbers.duration(length, units.time)),
        ("Warm-up", words.warm_up(study)),
        ("Seed of the study", str(plan.seed)),
        ("Seeds of the runs", ", ".join(str(seed) for _, seed in seeds) + "; the same for every design"),
        ("Confidence", f"{100 * plan.confidence:g} %"),
        ("Versions", ", ".join(f"{name} {version}" for name, version in study.versions.items())),
        ("Page made", f"{datetime.now().astimezone():%Y-%m-%d}"),
    ]
    varied = {"run.length": "Run length", "run.warm_up": "Warm-up"}
    hidden = {varied[key] for key in study.factors if key in varied}
    return [row for row in rows if row[0] not in hidden]


def _summary(study: Results) -> str:
    """In a line: how many designs and runs, and when they were shown."""
    runs = {len(study.runs(design)) for design in study.designs}
    each = f"{min(runs)}" if len(runs) == 1 else f"{min(runs)} to {max(runs)}"
    return (
        f"{len(study.designs)} designs, {each} run{'s' * (runs != {1})} of each, "
        f"{simulated_with(study.version) or f'desim-warehouse {study.version}'}, {datetime.now().astimezone():%Y-%m-%d}"
    )


def _factor(study: Results, key: str) -> dict[str, Any]:
    levels = [plain(value) for value in study.levels(key)]
    return {
        "key": key,
        "label": words.factor_label(key, study.base.units),
        "head": words.factor_head(key, study.base.units),
        "levels": [readable(value) for value in levels],
        "numbers": levels if is_numeric(levels) else None,
    }


def _indicator(name: str, scale: Scale) -> dict[str, Any]:
    known = look_up(name)
    return {
        "name": name,
        "label": words.with_unit(words.indicator_name(name), scale.unit),
        "better": known.better if known else None,
    }


def _design(study: Results, design: str) -> dict[str, Any]:
    """A design: the ranks of its levels among those of the factors that vary, its runs, and what is wrong with it."""
    levels = dict(zip(study.factors, study.designs[design], strict=True))
    rows = study.runs(design)
    wrong = [verdict.text for verdict in study.verdicts.get(design, ())]
    wrong += [sentences.UNSETTLED] if design in study.unsettled else []
    return {
        "levels": [study.levels(key).index(levels[key]) for key in study.varied],
        "runs": len(rows),
        "failed": sum(row.outcome.error is not None for row in rows),
        "error": next((row.outcome.error for row in rows if row.outcome.error is not None), None),
        "counted_from": numbers.number(study.warm_ups[design]) if study.warm_ups else None,
        "wrong": [sentences.sentence(text) for text in wrong],
        "marks": ", ".join(one.mark for one in study.verdicts.get(design, ())),
        "met": words.met_or_when(study, design) if study.target else None,
    }


def _mean(found: Estimate | None, scale: Scale) -> list[Any] | None:
    """Mean, ends of its interval (None: there is none), and as `desim what-if` prints it."""
    if found is None:
        return None
    low, high = found.interval or (None, None)
    return [*_short((found.mean, low, high), scale), judged.within("", scale, (found.mean, low, high)).text]


def _values(study: Results, design: str, name: str, scale: Scale) -> list[float | None]:
    """The values by replication."""
    values = study.values(design, name).tolist()
    return _short((value if math.isfinite(value) else None for value in values), scale)


def _differences(study: Results, name: str, scale: Scale) -> list[tuple[str, list[list[Any] | None]]]:
    """For each design as the baseline, all others minus it with their confidence, as `desim compare` prints them."""
    made = []
    for baseline in study.designs:
        found = study.compare_finished(name, baseline)
        rows = {one.design: _difference(one, scale) for one in found.differences} if found else {}
        tested = found is not None and any(one.estimate.interval for one in found.differences)
        made.append((found.statement if found and tested else "", [rows.get(design) for design in study.designs]))
    return made


def _difference(one: Difference, scale: Scale) -> list[Any]:
    """The texts of a difference; where it is not shown, also how many runs would show it, if that can be said."""
    return [*scale.difference(one), *([one.runs_to_tell] if one.runs_to_tell else [])]


def _target(study: Results, scales: Mapping[str, Scale]) -> dict[str, Any] | None:
    """What designs should meet: in words, the name of its indicator, and where it lies on the axis."""
    goal = study.target
    if goal is None or goal.indicator not in scales:
        return None
    return {
        "words": words.target(goal),
        "name": goal.indicator,
        "value": scales[goal.indicator].by * goal.value,
    }


def _start(study: Results) -> list[int]:
    """The two designs that are shown first: the baseline, and the one that differs most from it in its first factor."""
    designs = list(study.designs)
    a = designs.index(study.baseline)
    levels, place = list(study.designs[study.baseline]), study.factors.index(study.varied[0])
    among = study.levels(study.varied[0])
    levels[place] = among[-1] if levels[place] != among[-1] else among[0]
    return [a, list(study.designs.values()).index(tuple(levels))]


def _has_value(study: Results, name: str) -> bool:
    return any(math.isfinite(row.value(name)) for row in study.rows)


def _short(values: Iterable[float | None], scale: Scale) -> list[float | None]:
    return [None if value is None else float(f"{scale.by * value:.{DIGITS}g}") for value in values]
