"""study.json: the resolved study, so that a folder can be understood, continued and compared by itself.

For `desim study`, `compare` and `report`, which read the folders of studies.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, get_args

from desim_warehouse.errors import ModelError, StudyError, reason
from desim_warehouse.folders import RUN, STUDY, too_old, write_whole
from desim_warehouse.model import load
from desim_warehouse.study.design import Point, Rule
from desim_warehouse.study.execution.cache import versions
from desim_warehouse.study.execution.own_indicators import OwnIndicator
from desim_warehouse.study.factors import Factor, Label, Level
from desim_warehouse.study.file import Until
from desim_warehouse.study.plan import StudyPlan, models, run_seed

FORMAT = 1


class Record(NamedTuple):
    """The content of study.json: the plan, the digest of each point's model in the journal, and versions."""

    plan: StudyPlan
    keys: Mapping[int, str]
    versions: Mapping[str, str]


def write_record(plan: StudyPlan, points: Sequence[Point], keys: Mapping[int, str], folder: Path) -> None:
    """Write study.json, as a whole or not at all.

    Raises:
        StudyError: where it cannot be written.
    """
    rule = plan.replications
    content = {
        "format": FORMAT,
        "name": plan.name,
        "description": plan.description,
        "versions": versions(),
        "factors": [_factor(factor) for factor in plan.factors],
        "design": {"rule": plan.rule},
        "replications": rule.model_dump() if isinstance(rule, Until) else rule,
        "seed": plan.seed,
        "run_seeds": [run_seed(plan.seed, r) for r in range(plan.most)],
        "indicators": plan.indicators,
        "baseline": plan.baseline,
        "confidence": plan.confidence,
        "target": plan.target,
        "timeout": plan.timeout,
        "warm_up": plan.warm_up,
        "base": plan.base.content(),
        **({"own_indicators": {indicator.name: indicator.digest for indicator in plan.own}} if plan.own else {}),
        "points": [
            {"labels": point.labels, "changes": point.overrides, "model": keys[point.number]} for point in points
        ],
    }
    path = folder / STUDY
    try:
        write_whole(path, json.dumps(content, indent=1) + "\n")
    except OSError as error:
        raise StudyError(f"{path}: cannot be written ({reason(error)}); make room and start again") from error


def _factor(factor: Factor) -> dict[str, Any]:
    levels = [{"label": level.label, "changes": level.overrides, "at": level.keys} for level in factor.levels]
    return {"key": factor.key, "levels": levels}


def read_record(folder: Path) -> Record:
    """Read the study.json of a folder.

    Raises:
        StudyError: where there is none, or it is damaged.
    """
    path = folder / STUDY
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if (why := too_old(content["versions"]["desim-warehouse"])) is not None:
            raise StudyError(f"{path}: {why}")
        keys = {number: point["model"] for number, point in enumerate(content["points"])}
        return Record(_plan(content), keys, content["versions"])
    except FileNotFoundError:
        kind = "a run, and no study" if (folder / RUN).exists() else "no study"
        raise StudyError(f"{folder}: {kind} there; desim study STUDY --out DIR makes one") from None
    except NotADirectoryError:
        raise StudyError(
            f"{folder}: a file, expected a study folder such as desim study STUDY --out DIR "
            "or desim what-if MODEL --out DIR makes"
        ) from None
    except (OSError, ValueError, KeyError, TypeError, RecursionError, ModelError) as error:
        raise StudyError(
            f"{path}: cannot be read ({reason(error)}); the runs are safe: start the study again with this folder"
        ) from error


def recorded_warm_up(plan: StudyPlan, folder: Path) -> tuple[float, ...] | None:
    """Return the warm-ups that the study in a folder found for these very designs, with this version; else None."""
    try:
        record = read_record(folder)
        times = record.plan.warm_up
        if not isinstance(times, tuple) or record.plan.seed != plan.seed or record.versions != versions():
            return None
        settled = replace(plan, warm_up=times)
        keys = {number: settled.run_name(model) for number, model in models(settled, settled.points()).items()}
    except (StudyError, ModelError, ValueError):  # no record, a damaged one, or one of other designs
        return None
    return times if keys == record.keys else None


def _plan(content: Mapping[str, Any]) -> StudyPlan:
    return StudyPlan(
        base=load(content["base"]),
        factors=_factors(content),
        rule="grid" if content["design"]["rule"] == "grid" else "paired",
        replications=_replications(content["replications"]),
        seed=content["seed"],
        indicators=tuple(content["indicators"]),
        baseline=content["baseline"],
        confidence=content["confidence"],
        timeout=content["timeout"],
        name=content["name"],
        description=content["description"],
        warm_up=tuple(content["warm_up"]) if content["warm_up"] else None,
        target=content["target"],
        own=tuple(OwnIndicator(name, digest) for name, digest in content.get("own_indicators", {}).items()),
    )


def _replications(value: Any) -> int | Until | tuple[int, ...]:
    if isinstance(value, list):
        return tuple(value)
    return value if isinstance(value, int) else Until(**value)


def _factors(content: Mapping[str, Any]) -> tuple[Factor, ...]:
    """Read the factors of a study.json; sampled designs of 0.3 have a level for each point, as paired lists."""
    levels = {
        item["key"]: [Level(level["label"], level["changes"], tuple(level["at"])) for level in item.get("levels", ())]
        for item in content["factors"]
    }
    if content["design"]["rule"] in get_args(Rule):
        return tuple(Factor(key, tuple(listed)) for key, listed in levels.items())
    return tuple(
        Factor(key, tuple(_drawn(key, listed, point["labels"][key]) for point in content["points"]))
        for key, listed in levels.items()
    )


def _drawn(key: str, listed: Sequence[Level], label: Label) -> Level:
    """Return the level that was drawn from a list, or from a range, which has no levels."""
    return next((level for level in listed if level.label == label), Level(label, {key: label}, ()))
