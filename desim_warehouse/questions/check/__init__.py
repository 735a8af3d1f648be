"""The verb `check`: errors and warnings of a model, and its quick estimate, before anything is simulated."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING

from desim_warehouse.errors import number_of
from desim_warehouse.model import as_model

if TYPE_CHECKING:
    import pandas as pd

    from desim_warehouse.feasibility.estimate import QuickEstimate
    from desim_warehouse.findings import Finding
    from desim_warehouse.look.web import StillPage
    from desim_warehouse.model import Source


@dataclass(frozen=True, repr=False)
class Check:
    """The findings and the answer of `check`; `print` shows them as `desim check` does.

    Attributes:
        facts: facts about the model in words, as `desim check --details` prints them.
        findings: errors and warnings, accepted errors included, worst first.
        calculation: the quick estimate; None if the layout has errors, hours never come, or a robot alone does none of
            the work.
        accepted: codes of the errors that the model accepts.
        lines: the figures of the quick estimate, one per line, as `desim check --details` prints them.
        sentences: the answer: the demand, and what robots, chargers and stations can do by the estimate.
    """

    facts: list[str]
    findings: list[Finding]
    calculation: QuickEstimate | None
    accepted: tuple[str, ...]
    lines: list[str]
    sentences: list[str]

    @property
    def errors(self) -> list[Finding]:
        """The errors for which `simulate` refuses the model."""
        return [item for item in self.findings if item.level == "error" and item.code not in self.accepted]

    @property
    def verdict(self) -> str:
        """The line that counts errors and warnings."""
        errors, warnings = len(self.errors), sum(item.level == "warning" for item in self.findings)
        waived = sum(item.level == "error" for item in self.findings) - errors
        counts = number_of(errors, "error") if errors else "no errors"
        counts += f", {number_of(warnings, 'warning')}" if warnings else ""
        counts += f", {number_of(waived, 'error')} accepted" if waived else ""
        return counts + (": this model would be refused" if errors else "")

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
        return "\n".join([self.verdict, *findings, *self.sentences])

    @property
    def details(self) -> str:
        """The facts about the model and the figures of the estimate, in lines."""
        estimate = ["quick estimate:", *(f"  {line}" for line in self.lines)] if self.lines else []
        return "\n".join([*self.facts, *estimate])

    def __repr__(self) -> str:
        return f"Check({self.facts[0].partition(':')[0]}: {self.verdict})"

    def _repr_html_(self) -> str:
        """Show the verdict, the findings and the quick estimate, in a frame."""
        return _page(self)._repr_html_()


def check(model: Source) -> Check:
    """Check a model or its file before a run: find errors and warnings, and make the quick estimate.

    Returns:
        Findings, worst first, and the quick estimate; see `Check`.

    Raises:
        ModelError: a model that cannot be read.
    """
    from desim_warehouse.questions.check import details
    from desim_warehouse.questions.check.words import sentences
    from desim_warehouse.run.examined import examined
    from desim_warehouse.run.quick import choice, in_wide_aisles, with_nearer

    model = as_model(model)
    facts = details.of_model(model)
    findings, estimate = examined(model)
    lines, nearest, chosen, wider = [], None, None, None
    if estimate is not None:
        lines = details.of_estimate(estimate, model.units)
        if not any(item.level == "error" and item.code not in model.accept for item in findings):
            nearest, chosen = with_nearer(model), choice(model, estimate)
            wider = in_wide_aisles(model, estimate)
            facts += details.of_savings(model, nearest, chosen, estimate)
    checked = Check(facts, findings, estimate, model.accept, lines, sentences(model, estimate, nearest, chosen, wider))
    logging.getLogger("desim_warehouse").info("check of %s: %s", model.name, checked.verdict)
    return checked


def _page(check: Check) -> StillPage:
    """Compose the page of a check: its verdict, the findings, the quick estimate, and facts about the model."""
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
        answer=(sentence(check.verdict), *check.sentences),
        tables=(
            Folded(title="What would be refused or holds robots up", head=head, rows=tuple(findings), printed=True),
            Folded(title="Quick estimate", rows=tuple((line,) for line in check.lines)),
            Folded(title="The model", rows=tuple((fact,) for fact in (size, *check.facts[1:]))),
        ),
        runs=0,
        confidence=None,
    )
    return StillPage(name, page(answer))
