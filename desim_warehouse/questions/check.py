"""Will it work? What would be refused or holds robots up, and the quick estimate, before anything is simulated."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from desim_warehouse.errors import number_of
from desim_warehouse.model import as_model
from desim_warehouse.values.distributions import Distribution

if TYPE_CHECKING:
    import pandas as pd

    from desim_warehouse.feasibility.estimate import QuickEstimate
    from desim_warehouse.findings import Finding
    from desim_warehouse.look.web import StillPage
    from desim_warehouse.model import Model, Source


@dataclass(frozen=True, repr=False)
class Check:
    """What `check` found; printing prints it, as `desim check` does.

    Attributes:
        facts: about the layout, in words.
        findings: worst first, accepted errors too.
        calculation: the quick estimate; None where the layout has errors, hours never come, or a robot by itself does
            none of the work.
        accepted: codes of the errors that the model accepts.
        lines: the quick estimate in words.
    """

    facts: list[str]
    findings: list[Finding]
    calculation: QuickEstimate | None
    accepted: tuple[str, ...]
    lines: list[str]

    @property
    def errors(self) -> list[Finding]:
        """What `simulate` refuses."""
        return [item for item in self.findings if item.level == "error" and item.code not in self.accepted]

    @property
    def verdict(self) -> str:
        """All in a line: how many errors and warnings there are."""
        errors, warnings = len(self.errors), sum(item.level == "warning" for item in self.findings)
        waived = sum(item.level == "error" for item in self.findings) - errors
        said = number_of(errors, "error") if errors else "no errors"
        said += f", {number_of(warnings, 'warning')}" if warnings else ""
        said += f", {number_of(waived, 'error')} accepted" if waived else ""
        return said + (": this model would be refused" if errors else "")

    @property
    def table(self) -> pd.DataFrame:
        """A row for each finding, worst first: level, accepted, code, place, text, cure."""
        import pandas as pd

        columns = ("level", "accepted", "code", "place", "text", "cure")
        rows = [
            (item.level, self._accepts(item), item.code, item.place, item.text, item.cure) for item in self.findings
        ]
        return pd.DataFrame(rows, columns=list(columns))

    def _accepts(self, item: Finding) -> bool:
        return item.level == "error" and item.code in self.accepted

    def __str__(self) -> str:
        findings = [f"{'accepted ' if self._accepts(item) else ''}{item}" for item in self.findings]
        estimate = ["quick estimate:", *(f"  {line}" for line in self.lines)] if self.lines else []
        return "\n".join([self.verdict, *findings, *self.facts, *estimate])

    def __repr__(self) -> str:
        return f"Check({self.facts[0].partition(':')[0]}: {self.verdict})"

    def _repr_html_(self) -> str:
        """Show the verdict, the findings and the quick estimate, in a frame."""
        return _page(self)._repr_html_()


def check(model: Source) -> Check:
    """Check a model or its file before it runs: what would be refused or holds robots up, and the quick estimate.

    Returns:
        Findings, worst first, and the quick estimate; see `Check`.

    Raises:
        ModelError: a model that cannot be read.
    """
    from desim_warehouse.feasibility.asked import orders_a_day, orders_asked_for
    from desim_warehouse.layout import checks
    from desim_warehouse.run.examined import examined
    from desim_warehouse.run.quick import left_out, with_choice, with_nearer

    model = as_model(model)
    layout = model.floor
    graph = layout.graph
    contact = model.fleet.contact
    length, speed, fleet = model.units.length, model.fleet.fastest, model.fleet.size
    parts = (len(graph), "node"), (graph.number_of_edges(), "edge"), (len(layout.storage), "storage place")
    facts = [
        f"{model.name}: {', '.join(number_of(*part) for part in parts)}",
        f"robots keep D = {contact:g} {length} and drive up to {speed:g} {length}/{model.units.time}",
        f"the lanes hold {number_of(checks.room(layout, contact), 'robot')} at once, the fleet has {fleet:,}",
    ]
    if model.fleet.slowness:
        stop = model.fleet.slowness * speed
        facts.append(f"a stop on the way costs up to {stop:.3g} {model.units.time} of braking and gathering speed")
    if braking := model.fleet.longest_braking:
        facts.append(
            f"those that keep their braking distance stay up to {braking:.3g} {length} farther behind while they drive"
        )
    facts += [*orders_a_day(model), *orders_asked_for(model), *_times_that_vary(model), *left_out(model, layout)]
    for ring in checks.shortest_rings(graph):
        around = sum(graph.edges[edge]["length"] for edge in pairwise(ring))
        facts.append(f"ring of {around:g} {length}: {' > '.join(ring)}")
    findings, calculation = examined(model)
    if calculation is not None and not any(
        item.level == "error" and item.code not in model.accept for item in findings
    ):
        facts += [*with_nearer(model), *with_choice(model, calculation)]
    lines = [] if calculation is None else [*calculation.lines(model.units), *_busiest(model, calculation)]
    checked = Check(facts, findings, calculation, model.accept, lines)
    logging.getLogger("desim_warehouse").info("check of %s: %s", model.name, checked.verdict)
    return checked


def _busiest(model: Model, calculation: QuickEstimate) -> list[str]:
    """Say who is busiest by the quick estimate; empty where it foresees no rate."""
    from desim_warehouse.answer.busiest import are
    from desim_warehouse.feasibility.loads import loads

    line = are(loads(model, calculation), "of the time" if calculation.on_duty == 1 else "of their hours")
    return [line] if line else []


def _times_that_vary(model: Model) -> list[str]:
    """The distributions of the model, in words."""
    times = {"loading": model.tasks.load_time, "unloading": model.tasks.unload_time}
    return [
        f"{name} varies: {time.words(model.units.time)}"
        for name, time in times.items()
        if isinstance(time, Distribution)
    ]


def _page(check: Check) -> StillPage:
    """Compose the page of the verdict, the findings, the quick estimate, and the layout in words."""
    from desim_warehouse.answer.answer import Answer
    from desim_warehouse.answer.numbers import sentence
    from desim_warehouse.answer.page import page
    from desim_warehouse.answer.parts import Folded
    from desim_warehouse.look.web import StillPage

    name, _, size = check.facts[0].partition(": ")
    findings = [
        ("accepted error" if item.code in check.accepted else item.level, item.place, item.text, item.cure, item.code)
        for item in check.findings
    ]
    head = ("finding", "place", "what is wrong", "what to do", "code")
    answer = Answer(
        kind="check",
        name=name,
        question="Will it work?",
        answer=(sentence(check.verdict),),
        tables=(
            Folded(title="What would be refused or holds robots up", head=head, rows=tuple(findings), printed=True),
            Folded(title="Quick estimate", rows=tuple((line,) for line in check.lines), printed=True),
            Folded(title="The model", rows=tuple((fact,) for fact in (size, *check.facts[1:]))),
        ),
        runs=0,
        confidence=None,
    )
    return StillPage(name, page(answer))
