"""Faults of closures, slow zones, people and breakdowns: unknown names, and places closed, cut off or blocked.

For `desim check`, and for the examination before every run.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from dataclasses import replace
from itertools import pairwise

from desim_warehouse.findings import Finding, amount
from desim_warehouse.layout import Layout, checks
from desim_warehouse.layout.checks import Use
from desim_warehouse.layout.layout import Edge
from desim_warehouse.layout.zones import edges_inside, edges_of, zones_on
from desim_warehouse.model import Model
from desim_warehouse.model.facts.disturbances import breakdowns, occupied, with_storage
from desim_warehouse.values.distributions import mean_of

LONGEST_BLOCKED = 300.0
"""Seconds after which a robot that stands in a lane is usually pushed or carried away."""
MOST_OCCUPIED = 0.9
"""Share of the time with people above which an aisle is practically closed."""


def errors(model: Model, layout: Layout, use: Use) -> Iterator[Finding]:
    """Find the errors of closures, slow zones, people and breakdowns, for which `simulate` refuses a model."""
    traffic = model.traffic
    if not (traffic.closures or traffic.slow or model.people):
        return
    inside = edges_inside(layout, use.contact, zones_on(layout, traffic.zones))
    for kind, named in (("closures", traffic.closures), ("slow", traffic.slow)):
        for name, spec in named.items():
            place = f"traffic.{kind}.{name}"
            edges = [member for member in spec.members if not isinstance(member, str)]
            yield from _missing(layout, place, edges)
            if kind == "closures":
                yield from _inside(place, edges_of(layout, spec.members), inside)
    for name, people in model.people.items():
        place = f"people.{name}"
        edges = [edge for line in people.aisles for edge in pairwise(line)]
        yield from _missing(layout, place, edges)
        yield from _inside(place, edges_of(layout, edges), inside)
        if not people.aisles and not with_storage(layout) - inside:
            text = "there is no edge with storage places that is long enough to wait before it"
            yield Finding("CLOSURE", place, text, "say which aisles people come to")
    yield from _cut_off(model, layout, use)


def warnings(model: Model, layout: Layout) -> Iterator[Finding]:
    """Find aisles that people occupy nearly all the time, and lanes that broken robots block for long."""
    yield from _blocked(model)
    for name, people in model.people.items():
        share = occupied(model, layout, people) or 0.0
        if share > MOST_OCCUPIED:
            yield Finding(
                "AISLES_OCCUPIED",
                f"people.{name}",
                f"an aisle has somebody in it for {100 * share:.3g} % of the time on average",
                "fewer visits, shorter stays, or more aisles",
            )


def _blocked(model: Model) -> Iterator[Finding]:
    """Find breakdowns without `clear` whose mean repair blocks a lane for longer than `LONGEST_BLOCKED`."""
    for place, spec in breakdowns(model).items():
        if spec.clear is not None or mean_of(spec.repair) * model.units.seconds <= LONGEST_BLOCKED:
            continue
        yield Finding(
            "LANES_BLOCKED",
            f"{place}.repair",
            f"a robot that breaks down blocks its lane for {amount(mean_of(spec.repair))} {model.units.time} on "
            "average, until it is repaired",
            f"{place}.clear: the time until it is off the lanes",
        )


def _missing(layout: Layout, place: str, edges: Iterable[Edge]) -> Iterator[Finding]:
    for a, b in edges:
        if not edges_of(layout, [(a, b)]):
            yield Finding("CLOSURE", place, f"there is no edge between {a} and {b}", "name others")


def _inside(place: str, edges: Iterable[Edge], inside: Container[Edge]) -> Iterator[Finding]:
    for a, b in edges:
        if (a, b) in inside:
            text = f"{a}>{b} lies in an intersection, so no robot can wait before it"
            yield Finding("CLOSURE", place, text, "name the edges that lead there")


def _cut_off(model: Model, layout: Layout, use: Use) -> Iterator[Finding]:
    """Find places that no robot can reach, or leave, at any time of the run."""
    for name, closure in model.traffic.closures.items():
        begin, end = model.hours(closure.hours).following(0.0)
        if begin > 0 or end < model.run.end:
            continue
        shut = edges_of(layout, closure.members)
        graph = layout.graph.copy()
        graph.remove_edges_from(shut)
        place = f"traffic.closures.{name}"
        cure = "close it at times, or leave out the edge"
        for edge in shut:
            behind = [
                str(good.number) for good in layout.storage if good.edge == edge and edge[::-1] not in graph.edges
            ]
            if behind:
                what = f"good{'s' * (len(behind) > 1)} {checks.some(behind)}"
                yield Finding("CUT_OFF", place, f"closed for the whole run; {what} on {'>'.join(edge)}", cure)
        for finding in checks.unreachable(replace(layout, graph=graph), use):
            if finding.code == "UNREACHABLE":
                node = finding.place.removeprefix("layout: ")
                yield Finding("CUT_OFF", place, f"closed for the whole run; {node} {finding.text}", cure)
