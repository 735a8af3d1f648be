"""A model whose figures are those of a real fleet: estimates with intervals and evidence, or not identified."""

from __future__ import annotations

import io
import math
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from desim_warehouse.errors import first_of
from desim_warehouse.fleet_log import read_logs
from desim_warehouse.fleet_log.demand import as_flow, as_they_are, demand
from desim_warehouse.fleet_log.energy import energy
from desim_warehouse.fleet_log.estimates import CONFIDENCE, KeyEstimate, short
from desim_warehouse.fleet_log.floor import Tracks, lay_over
from desim_warehouse.fleet_log.handling import breakdowns, handling
from desim_warehouse.fleet_log.motion import DrivingTimes
from desim_warehouse.fleet_log.table import FleetLog
from desim_warehouse.model import Model, load
from desim_warehouse.model.overrides import UNSET

_NAMED = 12
_OFTEN = 3
"""Passages from which on an edge is said to be missing in the model."""
_CONSUMPTION = "battery.consumption"


@dataclass(frozen=True)
class Calibration:
    """What the log of a fleet says of a model.

    Attributes:
        source: the model file.
        base: its model.
        estimates: for each key a value with interval and evidence, or why there is none.
        overrides: what changes in the model, by dotted key.
        notes: what is wrong with the logs, and where log and model disagree.
    """

    source: Path
    base: Model
    estimates: tuple[KeyEstimate, ...]
    overrides: dict[str, Any]
    notes: tuple[str, ...]

    @property
    def model(self) -> Model:
        """The calibrated model."""
        return load(self.source, self.overrides)

    @property
    def ranges(self) -> dict[str, dict[str, Any]]:
        """For each key that was estimated its interval: low, high, confidence and n."""
        found = {}
        for one in self.estimates:
            if one.identified and math.isfinite(one.low):
                bounds = {"low": short(one.low), "high": short(one.high) if math.isfinite(one.high) else None}
                found[one.ranged or one.key] = {**bounds, "confidence": CONFIDENCE, "n": one.n}
        return found

    def files(self, out: Path) -> dict[Path, str]:
        """The calibrated model file, with its comments and a comment for each change, and the ranges beside it."""
        from ruamel.yaml import YAML

        yaml = YAML()
        yaml.indent(sequence=4, offset=2)
        yaml.width = 4096
        content = yaml.load(self.source.read_text(encoding="utf-8-sig"))
        said = {one.key: one for one in self.estimates}
        for key, value in self.overrides.items():
            _write(content, key.split("."), _relative(value, out.parent), said[key].words() if key in said else "")
        if _CONSUMPTION in self.overrides:
            for state, section in (
                ("." + state, content["battery"]["consumption"]) for state in self.overrides[_CONSUMPTION]
            ):
                if _CONSUMPTION + state in said:
                    section.yaml_add_eol_comment(said[_CONSUMPTION + state].words(), state[1:])
        left = [f"{one.key}: {one.why}" for one in self.estimates if not one.identified]
        head = "\n".join(["Calibrated by desim calibrate. Not identified, so as they were:", *left])
        content.yaml_set_start_comment(head)
        text, ranges = io.StringIO(), io.StringIO()
        yaml.dump(content, text)
        yaml.dump(self.ranges, ranges)
        return {out: text.getvalue(), out.with_name(f"{out.stem}.ranges.yaml"): ranges.getvalue()}


def _relative(value: Any, folder: Path) -> Any:
    """A value in which files are named from the folder of the model."""
    if isinstance(value, dict):
        return {
            key: os.path.relpath(one, folder) if key == "file" else _relative(one, folder) for key, one in value.items()
        }
    return value


def _write(section: Any, path: list[str], value: Any, comment: str) -> None:
    """Put a value into a file that was read with its comments, in block style, or take the key away."""
    from ruamel.yaml.comments import CommentedMap

    for key in path[:-1]:
        if not isinstance(section.get(key), dict):
            section[key] = CommentedMap()
        section = section[key]
        section.fa.set_block_style()
    if value is UNSET:
        section.pop(path[-1], None)
        return
    section[path[-1]] = _flowing(value) if path[-1] != "consumption" else CommentedMap(value)
    if comment:
        section.yaml_add_eol_comment(comment, path[-1])


def _flowing(value: Any) -> Any:
    """A section on one line."""
    from ruamel.yaml.comments import CommentedMap, CommentedSeq

    if isinstance(value, dict):
        found: Any = CommentedMap((key, _flowing(one)) for key, one in value.items())
    elif isinstance(value, list):
        found = CommentedSeq(map(_flowing, value))
    else:
        return value
    found.fa.set_flow_style()
    return found


def calibrate(
    model: str | Path, logs: Sequence[str | Path | FleetLog], *, orders: str | Path | None = None
) -> Calibration:
    """Estimate the figures of a model from the logs of its real fleet.

    Args:
        model: the model file; its layout must be that of the real floor, with the same names of nodes.
        logs: a day each: messages of VDA 5050 as JSON lines, trips as CSV, or folders of runs.
        orders: a file of orders that the calibrated model takes its demand from, as they are.

    Raises:
        ReportError: logs that cannot be read or are of another floor. ModelError: the model or orders.
    """
    source = Path(model)
    base = load(source)
    read = read_logs(logs)
    notes = [line for log in read for line in log.notes.lines()]
    tracks = lay_over(base, read) if any(log.step for log in read) else None
    estimates: list[KeyEstimate] = []
    if tracks is not None:
        notes += [*tracks.notes, *_differences(tracks)]
        estimates = [*DrivingTimes(tracks).estimates(), *handling(tracks), *energy(tracks), *breakdowns(tracks)]
    else:
        notes.append("trips alone say nothing of speeds, handling, energy and breakdowns")
    if orders is None:
        estimates += demand(base, read, tracks)
    overrides = _overrides(base, estimates)
    if orders is not None:
        overrides |= as_they_are(base, Path(orders))
    return Calibration(source, base, tuple(estimates), overrides, tuple(notes))


def _overrides(base: Model, estimates: Sequence[KeyEstimate]) -> dict[str, Any]:
    """The changes to a model: consumption as a section, demand by hour as a flow."""
    found: dict[str, Any] = {}
    for one in estimates:
        if not one.identified:
            continue
        if one.key.startswith("tasks.flows."):
            found |= as_flow(base, one.value)
        elif one.key.startswith(_CONSUMPTION):
            assert base.battery is not None
            section = found.setdefault(_CONSUMPTION, dict(base.battery.draws.content()))
            section[one.key.rpartition(".")[2]] = one.value
        else:
            found[one.key] = one.value
    repair = "fleet.robot.breakdowns.repair"
    if repair in found and repair.replace("repair", "every") not in found:
        del found[repair]
    return found


def _differences(tracks: Tracks) -> list[str]:
    """Edges that robots drove and the model does not have, and edges that none drove."""
    names = list(tracks.model.floor.graph)
    passed = (np.diff(tracks.node) != 0) & (np.diff(tracks.robot) == 0) & tracks.joined[1:]
    pairs = Counter(zip(tracks.node[:-1][passed].tolist(), tracks.node[1:][passed].tolist(), strict=True))
    strange = [
        f"{names[a]}>{names[b]} ({count} times)"
        for (a, b), count in pairs.most_common()
        if min(a, b) >= 0 and count >= _OFTEN and not tracks.model.floor.graph.has_edge(names[a], names[b])
    ]
    used = {(names[a], names[b]) for a, b in pairs if min(a, b) >= 0}
    unused = [">".join(edge) for edge in tracks.edges if edge not in used]
    return [
        f"{what}: {first_of(some, _NAMED)}"
        for what, some in (("edges that the model lacks", strange), ("edges that no robot drove", unused))
        if some
    ]
