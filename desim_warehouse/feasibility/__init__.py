"""Examination of a model before it runs: errors, warnings and the quick estimate.

`examine` returns all findings, for `desim check`; `refuse` raises the errors among them before a run.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from desim_warehouse.errors import CheckError, LayoutError, SimulationError
from desim_warehouse.feasibility import closures, pods, rules
from desim_warehouse.feasibility.estimate import QuickEstimate
from desim_warehouse.feasibility.pods import driven
from desim_warehouse.findings import Finding
from desim_warehouse.layout import Layout, checks
from desim_warehouse.model import Model
from desim_warehouse.model.facts.lifts import with_people
from desim_warehouse.model.facts.places import destinations, ends_in_stations
from desim_warehouse.model.schema import reading
from desim_warehouse.model.sections.orders import files_of, nodes_named

__all__ = ["errors", "examine", "refuse"]


def examine(
    model: Model, layout: Layout, estimate: Callable[[Model], QuickEstimate]
) -> tuple[list[Finding], QuickEstimate | None]:
    """Return all findings, the worst first, and the quick estimate of the model.

    The estimate is None if the layout has errors, if hours never come, or if a robot alone does none of the work.
    """
    use = _use(model, layout)
    findings = checks.examine(layout, use)
    if any(item.level == "error" for item in findings):
        return findings, None
    on_floor = driven(model)
    findings += closures.errors(on_floor, layout, use)
    findings += closures.warnings(on_floor, layout)
    findings += rules.errors(on_floor, layout)
    if any(item.code == "NEVER_OPEN" for item in findings):
        return checks.worst_first(findings), None
    try:
        calculation = estimate(model)
    except SimulationError as error:
        findings.append(
            Finding("NO_ESTIMATE", "tasks", str(error), "see a run with one robot (fleet.size), `desim run`")
        )
        return checks.worst_first(findings), None
    findings += rules.warnings(on_floor, layout, calculation)
    findings += rules.mistakes(model, layout, calculation)
    findings += pods.warnings(model, calculation)
    return checks.worst_first(findings), calculation


@lru_cache(maxsize=64)
def errors(model: Model) -> tuple[Finding, ...]:
    """Return the errors of a model, accepted errors included; computed once for all runs of a model."""
    layout = model.floor
    layout_errors = checks.errors(layout, _use(model, layout))
    model = driven(model)
    return tuple(layout_errors or (*closures.errors(model, layout, _use(model, layout)), *rules.errors(model, layout)))


def refuse(model: Model, layout: Layout) -> None:
    """Raise the errors of a model that it does not accept.

    Raises:
        LayoutError: the layout has an error, accepted or not.
        CheckError: otherwise.
    """
    refused = [item for item in errors(model) if item.code not in model.accept]
    if refused:
        kind = LayoutError if checks.errors(layout, _use(model, layout)) else CheckError
        raise kind([item.problem for item in refused])


def _use(model: Model, layout: Layout) -> checks.Use:
    fleet = model.fleet
    files = files_of(model.tasks.flows)
    named = nodes_named(files, reading(model, layout), layout) if files else ()
    used = tuple(dict.fromkeys((*destinations(model, layout), *named)))
    homes = tuple(fleet.homes(layout.bays)) if fleet.start or layout.bays else ()
    traffic = model.traffic
    people = {lift.name: with_people(model, lift) for lift in layout.lifts}
    timed = frozenset(node for node, _ in traffic.node_times)
    return checks.Use(
        fleet.contact,
        fleet.size,
        fleet.start,
        homes,
        used,
        ends_in_stations(model, layout),
        traffic.gridlock,
        traffic.zones,
        traffic.free_nodes,
        people,
        timed,
    )
