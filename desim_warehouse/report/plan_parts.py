"""The sections of a plan's report: on its page, and one by one in the notebook reports/plan.ipynb."""

from __future__ import annotations

import json
import math
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.errors import ReportError, StudyError, reason
from desim_warehouse.report import html, plot, run_parts
from desim_warehouse.report import page as pages
from desim_warehouse.report.model_parts import model_facts
from desim_warehouse.report.study_parts import versions
from desim_warehouse.report.text import numbers, words
from desim_warehouse.report.text.fleet_words import more_orders
from desim_warehouse.run.folder import PLAN
from desim_warehouse.study.plan import run_seed
from desim_warehouse.study.results import Results
from desim_warehouse.study.statistics import Estimate

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import pandas as pd
    from matplotlib.axes import Axes

    from desim_warehouse.model import Model
    from desim_warehouse.report.html import Html
    from desim_warehouse.report.page import ReportPage
    from desim_warehouse.run import Run

_DEMAND = "orders"
"""The column of the tables of a plan that says for which demand a run was."""


@dataclass(frozen=True)
class PlanFolder:
    """What `desim plan --out` wrote: the content of plan.json, and the studies of each demand, today's first."""

    content: Mapping[str, Any]
    studies: tuple[Results, ...]
    scouts: tuple[Results, ...]

    @property
    def demands(self) -> list[Mapping[str, Any]]:
        """What plan.json says of each demand."""
        return _demands(self.content)

    @property
    def uncertain(self) -> Mapping[str, Any] | None:
        """What plan.json says of inputs that are not known exactly; None where none was given."""
        found: Mapping[str, Any] | None = self.content.get("uncertain")
        return found

    @property
    def design(self) -> Mapping[str, Any]:
        """The last answer, or the largest design looked at; the model as it is where runs ended before any was."""
        last = self.demands[-1]
        if last["best"] or last["too_small"]:
            found: Mapping[str, Any] = last["best"] or last["too_small"][-1]
            return found
        return {"robots": self.studies[-1].base.fleet.size, "chargers": 0, "set": {}}

    @property
    def model(self) -> Model:
        """The model at that design."""
        return self.studies[-1].base.replace(self.design["set"])


def _demands(content: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [content[name] for name in ("today", "grown") if content[name] is not None]


def read(folder: str | Path | None) -> PlanFolder:
    """The plan of a folder; None: a small one made now.

    Raises:
        ReportError: no plan there, or it is damaged.
    """
    if folder is None:
        with tempfile.TemporaryDirectory() as made:
            return _small(Path(made))
    path = Path(folder) / PLAN
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        names = [demand["study"] for demand in _demands(content)]
        studies = (tuple(Results.load(path.parent / f"{name}{end}") for name in names) for end in ("", "-scout"))
        return PlanFolder(content, *studies)
    except (OSError, ValueError, KeyError, TypeError, RecursionError, StudyError) as error:
        raise ReportError(f"{path}: not the plan of desim plan --out ({reason(error)})") from error


def _small(folder: Path) -> PlanFolder:
    from desim_warehouse.report.text.fleet_words import save
    from desim_warehouse.study.fleet import plan_fleet

    model = pages.example()
    found = plan_fleet(model, "on_time >= 75 %", growth=2, strategies={}, robots=range(1, 5), out=folder)
    save(found, model, [], folder)
    return read(folder)


def page(folder: str | Path, replay: str | None = None) -> ReportPage:
    """The report of the plan of a folder; `replay` is a file for the replay of one run, which the first page links."""
    plan = read(folder)
    run = example_run(plan)
    return pages.ReportPage(
        title=plan.content["name"],
        first=[first_page(plan, run, replay), first_figure(plan)],
        sections={
            "Where the time goes": [account(plan, run), *run_parts.account_figures(run)],
            **({"What is not known exactly": [uncertain(plan)]} if plan.uncertain else {}),
            "What shows it": [evidence(plan)],
            **run_parts.places(run),
        },
        appendix={
            "The commands that show each number": [commands(plan)],
            "The warehouse": [plot.layout(plan.model), warehouse(plan)],
            "Method and reproducibility": [method(plan)],
        },
    )


def first_page(plan: PlanFolder, run: Run | None, replay: str | None = None) -> Html:
    """The question, and the answer as `desim plan` prints it."""
    content = plan.content
    unsure = [plan.uncertain["in_short"]] if plan.uncertain else []
    said = [*content["answer"], *unsure, *content["notes"]]
    return pages.first_page(
        content["name"], plan.model.description, content["question"], numbers_of(plan), said, run, replay
    )


def numbers_of(plan: PlanFolder) -> list[tuple[str, str, str]]:
    """The numbers of today's answer: robots, chargers, what they reach, and what they cost; none without an answer."""
    best, goal = plan.content["today"]["best"], plan.content["target"]
    if best is None:
        return []
    found = [(str(best["robots"]), f"robot{'s' * (best['robots'] != 1)}", "")]
    found += [(str(best["chargers"]), f"charger{'s' * (best['chargers'] != 1)}", "")] if best["chargers"] else []
    if best["mean"] is not None:
        scale = words.scale(goal["indicator"], plan.model, (best["mean"],))
        found.append(scale.tile(_estimate(best, plan.content["confidence"]), words.in_sentence(goal["indicator"])))
    if best["cost"] is not None:
        found.append((numbers.Scale(words.money(plan.model)).value(best["cost"]), "a year", ""))
    return found


def _estimate(design: Mapping[str, Any], confidence: float) -> Estimate:
    """What plan.json says of a design's runs."""
    exact, unknown = design["interval"] is None, math.nan
    interval = None if exact else tuple(design["interval"])
    return Estimate(design["runs"], design["mean"], interval, unknown, unknown, {}, exact, confidence)


def first_figure(plan: PlanFolder) -> Axes:
    """What the target asks for by robots, a line for each number of chargers, a panel for each demand."""
    import pandas as pd

    goal = plan.content["target"]
    table = pd.concat([part for part in _tables(plan, goal["indicator"]) if not part.empty], ignore_index=True)
    common: dict[str, Any] = {
        "group": "chargers" if "chargers" in table else None,
        "confidence": plan.content["confidence"],
        "model": plan.model,
        "target": goal["value"],
    }
    if len(plan.demands) == 1:
        return plot.by_factor(table, "fleet.size", goal["indicator"], **common)
    return plot.facets(table, "fleet.size", goal["indicator"], by=[_DEMAND], **common)


def _tables(plan: PlanFolder, indicator: str) -> Iterator[pd.DataFrame]:
    """The runs of the designs that were judged; of others those of the search before."""
    for demand, study, scout in zip(plan.demands, plan.studies, plan.scouts, strict=True):
        if not scout.rows:  # the runs allowed had ended before
            continue
        judged = study.frame([indicator])
        factors = list(study.factors)
        seen = set(judged[factors].itertuples(index=False, name=None))
        before = scout.frame([indicator])
        others = before[[row not in seen for row in before[factors].itertuples(index=False, name=None)]]
        for table in (judged, others) if study.rows else (before,):
            part = table[[*factors, "replication", indicator, "deterministic"]].copy()
            if "chargers" in part:
                part["chargers"] = part["chargers"].astype(int)
            part.insert(0, _DEMAND, _demand(demand))
            yield part


def _demand(demand: Mapping[str, Any]) -> str:
    rate = demand["orders_per_hour"]
    when = "today" if demand["growth"] == 1 else more_orders(demand["growth"])
    return when if rate is None else f"{when} ({numbers.number(rate)} an hour)"


def example_run(plan: PlanFolder) -> Run | None:
    """A run of the last answer, simulated again with everything logged."""
    return pages.in_full(plan.model, run_seed(plan.studies[-1].plan.seed, 0))


def account(plan: PlanFolder, run: Run | None) -> Html | None:
    """The biggest part of a task's time, and which run that was."""
    fleet = words.fleet(plan.design["robots"], plan.design["chargers"])
    name = f"{fleet}, {_demand(plan.demands[-1])}"
    return None if run is None else run_parts.account_of(run, name)


def evidence(plan: PlanFolder) -> Html:
    """The numbers behind the answer."""
    rows = [[one["what"], one["found"], numbers.number(one["runs"])] for one in plan.content["evidence"]]
    shown = html.table(
        ["design", words.indicator_name(plan.content["target"]["indicator"]), "runs"], rows, words=2, name="evidence"
    )
    return shown + html.paragraph(plan.content["promise"], "note")


def uncertain(plan: PlanFolder) -> Html | None:
    """Where inputs that are not known exactly tip the answer, and what knowing them is worth."""
    if plan.uncertain is None:
        return None
    said, (head, *rows) = plan.uncertain["answer"], plan.uncertain["table"]
    if not rows:
        return html.paragraph(" ".join(said))
    return html.paragraph(said[0]) + html.table(head, rows, words=2, name="uncertain")


def commands(plan: PlanFolder) -> Html | None:
    """The line that shows each number again."""
    parts = [html.paragraph(one["what"]) + html.code(one["command"]) for one in plan.content["evidence"]]
    return html.Html("\n").join(parts) if parts else None


def warehouse(plan: PlanFolder) -> Html:
    """The model in numbers."""
    return model_facts(plan.model)


def method(plan: PlanFolder) -> Html:
    """How the answer was found, and with what."""
    steps = [
        "A scout halves the ranges of robots and chargers with three runs of each design.",
        (
            "The design that it names, and those that rule out every smaller one, are judged with fresh runs until the "
            "bounds are clear of the target; all verdicts on one demand hold at once."
        ),
        "A design whose backlog grows, or whose batteries fall, does not count as enough.",
    ]
    rows = [("Runs", numbers.number(plan.content["runs"]))]
    return html.bullets(steps) + html.facts([*rows, *versions(plan.studies[0])], "method")
