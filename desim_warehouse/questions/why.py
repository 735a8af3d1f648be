"""The verb `why`, which finds the bottleneck of a warehouse and what it costs (`study.held_up`), and its answer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.answer import Answer, Answered
from desim_warehouse.answer.busiest import was
from desim_warehouse.answer.frame import number_columns
from desim_warehouse.answer.numbers import capital, sentence
from desim_warehouse.answer.parts import BigNumber, Folded, Option, Rows, ShownNumber
from desim_warehouse.answer.root_words import root
from desim_warehouse.answer.standing import Standing
from desim_warehouse.errors import number_of, spoken
from desim_warehouse.model import Source
from desim_warehouse.outcome.indicators import find
from desim_warehouse.questions import judged
from desim_warehouse.questions.run import Run
from desim_warehouse.study.held_up import Failure, Health, HeldUp, held_up
from desim_warehouse.study.search import USUAL, Search
from desim_warehouse.study.statistics.effects import Gain
from desim_warehouse.study.suspects import Suspect

if TYPE_CHECKING:
    import pandas as pd

_ROOTS = 3
_NAMED = 3
"""Most changes that are named in a sentence."""
_MANY = 1000  # per cent
_FAILS = {"BatteryError": "runs flat", "StallError": "stalls", "GridlockError": "jams for good"}
"""What a run that could not go on did, by its error."""
_PER = "per 10 % more"


@dataclass(frozen=True, repr=False)
class Why(Answered, HeldUp):
    """The bottleneck of a warehouse, and what it costs: the result of `why`.

    Attributes:
        answer: the answer in words; shown by `print`.
        indicator: the indicator in which costs are measured.
        ranked: each suspect with its gain, competing suspects first.
        as_it_is: mean and interval of the indicator without changes; None if runs could not go on.
        lost: root causes of waits, each with its share of the fleet's time.
        verdicts: verdicts on the run that was examined.
    """

    @property
    def bottleneck(self) -> str | None:
        """The suspect that costs most; None if none does, or if the runs do not decide."""
        if not (self.is_held_up and self.is_clear):
            return None
        return next(suspect.name for suspect, gain in self.ranked if gain.competes)

    @property
    def table(self) -> pd.DataFrame:
        """A row for each change that was tried, competing changes first.

        Columns: suspect, change, gain with `_low` and `_high` (of the whole change, in the model's units; positive is
        better), gain_of_10_percent likewise (nan if the change is not a dose), runs.
        """
        import pandas as pd

        rows = []
        for suspect, gain in self.ranked:
            dose = gain.each if gain.scale is not None and suspect.dose is not None else None
            ends = (None, None, None) if dose is None else (dose.mean, dose.low, dose.high)
            rows.append(
                {
                    "suspect": suspect.name,
                    "change": suspect.relief,
                    **number_columns("gain", gain.mean, gain.low, gain.high),
                    **number_columns("gain_of_10_percent", *ends),
                    "runs": gain.n,
                }
            )
        return pd.DataFrame(rows).astype({name: float for name in rows[0] if "gain" in name} if rows else {})

    def in_short(self) -> str:
        """Return the bottleneck in a few words."""
        if 0 in self.failures:
            return fails(self.failures[0])
        if not self.is_held_up:
            return "no bottleneck"
        return f"{self.bottleneck or 'not clear yet'}: {self.indicator}"


def why(
    source: Run | Source,
    *,
    indicator: str | None = None,
    search: Search = USUAL,
) -> Why:
    """Find the bottlenecks of a warehouse and what each costs: relieve each suspect, and simulate the same days.

    Args:
        source: a run with `log: all`, or a model or its file, which is then simulated once.
        indicator: the indicator in which costs are measured (default: throughput where work always waits, else time).
        search: settings of runs; the answer is written to its folder `out`.

    Returns:
        Each suspect with its gain when relieved, and the answer in words; see `Why`.

    Raises:
        StudyError: an indicator without a better direction, or a run that failed but could have gone on.

    Source: paired differences on the same days, one-sided, with alpha spending over the looks. Relieving one resource
    at a time defines a bottleneck by its effect (the sensitivity of throughput to each resource); see
    docs/how-to/find-the-bottleneck.md.
    """
    return worded(held_up(source, indicator, search), search)


def worded(costs: HeldUp, search: Search = USUAL) -> Why:
    """Add the answer to the costs of the suspects, and write it to the folder of the search."""
    return Why(**vars(costs), answer=answer(costs).keep(search.out, search.command))


def answer(costs: HeldUp) -> Answer:
    """Put the gains of relieving the suspects into words."""
    return _Held(costs).answer()


def fails(failure: Failure) -> str:
    """Return in words what runs that could not go on did, and how many of them."""
    verb = next((word for kind, word in _FAILS.items() if failure.text.startswith(kind)), "fails")
    return f"{verb} in {failure.failed} of {number_of(failure.runs, 'run')}"


class _Held:
    """The costs of all suspects, with the scale in which gains are written."""

    def __init__(self, costs: HeldUp) -> None:
        self.costs, self.model = costs, costs.model
        means = [gain.mean for _, gain in costs.ranked if math.isfinite(gain.mean)]
        scale = words.scale(costs.indicator, self.model, means)
        self.scale = numbers.Scale("points", 100.0) if scale.is_share else scale
        self.competing = [(suspect, gain) for suspect, gain in costs.ranked if gain.competes]
        self.of = words.in_sentence(costs.indicator) if costs.indicator else ""

    def answer(self) -> Answer:
        costs, model = self.costs, self.model
        lines = [self._bottleneck(), *(sentence(verdict.text) for verdict in costs.verdicts), was(costs.loads)]
        lines += [self._lost(), self._batched()]
        broken = 0 in costs.failures
        return Answer(
            kind="why",
            name=model.name,
            description=model.description,
            question="What is the bottleneck?",
            measures={costs.indicator: "gain, per 10 %"},
            answer=tuple(filter(None, lines)),
            tiles=() if broken else (*self._as_it_is(), *self._health()),
            options=tuple(self._options()),
            figure=self._figure(),
            about=None if broken else judged.about("the warehouse as it is", model, costs.seed),
            tables=tuple(self._changes()),
            promise=judged.promise("intervals", costs.gains.confidence, exact=costs.gains.exact),
            notes=tuple(f"Not tried: {line}." for line in costs.left_out),
            runs=costs.gains.runs,
            confidence=costs.gains.confidence,
            made={"seed": str(costs.seed), "model": model.digest()},
            indicator=costs.indicator,
            clear=costs.is_clear,
            base=_finite(costs.gains.base),
            held_up=costs.is_held_up,
            lost_time=[{"root": loss.cause, "at": loss.at, "share": share} for loss, share in costs.lost.items()],
            waiting_for_batch=costs.batched,
            busy={load.group.name: load.mean for load in costs.loads},
            failed=costs.gains.failed,
            left_out=list(costs.left_out),
            verdicts=[verdict.content() for verdict in costs.verdicts],
            reliefs=[_facts(suspect, gain) for suspect, gain in costs.ranked],
        )

    # Sentences

    def _bottleneck(self) -> str:
        """Return the sentences on the bottleneck and its cost, or that there is none."""
        costs, failure = self.costs, self.costs.failures.get(0)
        if failure is not None:
            reason = sentence(failure.text.partition(": ")[2] or failure.text)
            return f"As it is, the warehouse {fails(failure)}. {reason}"
        if not costs.is_held_up and costs.state is not None:
            is_decided = costs.gains.none or costs.is_clear
            return f"There is no bottleneck: {_state(costs.state)}.{f' {self._gains()}' if is_decided else ''}"
        return self._gains()

    def _gains(self) -> str:
        """Return the sentences on the largest gain of an equal dose, and on the most that any other change gains."""
        costs = self.costs
        if not self.competing:
            return f"No change tried made any difference in {number_of(costs.gains.runs, 'run')}."
        if costs.gains.none:
            return f"No change tried improves {self.of} by {self.scale.value(costs.gains.delta)} or more."
        if costs.is_clear:
            return self._best(*self.competing[0])
        near = [(suspect, gain) for suspect, gain in self.competing if not gain.beaten and gain.high > 0][:_NAMED]
        listed = spoken([f"{suspect.relief} {self._number(gain.each).text}" for suspect, gain in near])
        per = f", {_PER}" if any(suspect.dose is not None for suspect, _ in near) else ""
        runs = number_of(self.competing[0][1].n, "run")
        unclear = f"{runs} do not yet show what helps most. Gain in {self.of}{per}: {listed}."
        return unclear + self._largest(near[0][0])

    def _best(self, suspect: Suspect, most: Gain) -> str:
        """Return the sentences on the gain of the best change, and on the most that any other change gains."""
        costs = self.costs
        falls = "falls" if find(costs.indicator).better == "less" else "rises"
        more = "" if suspect.dose is None else f" ({dose(suspect)})"
        line = f"{capital(suspect.relief)}{more}: {self.of} {falls} by {self._number(most).text}"
        line += "" if suspect.scale == 1 else f", or {self._number(most.each).text} per 10 %"
        if costs.is_held_up:
            line = f"{capital(suspect.name)} {_is(suspect.name)} the main bottleneck{self._of_tried()}. {line}"
        rest = max((gain.each.high for other, gain in self.competing if other.name != suspect.name), default=None)
        per_dose = " per 10 %" * any(other.dose is not None for other, _ in self.competing)
        if rest is not None and rest >= most.each.low:
            line += f"; on the same days every other ranked change gains less{per_dose}"
        elif rest is not None:
            line += f"; no other ranked change gains more than {self._at_most(rest)}{per_dose}"
        elif len(costs.ranked) > 1 and all(gain.same for _, gain in costs.ranked[1:]):
            line += f"; nothing else made a difference in {number_of(most.n, 'run')}"
        return f"{line}.{self._largest(suspect)}"

    def _of_tried(self) -> str:
        """Return that reliefs which cannot be simulated might gain more; empty if there are none."""
        impossible = self.costs.impossible
        return f" of all that could be tried; {spoken(impossible)} could not be" if impossible else ""

    def _largest(self, named: Suspect) -> str:
        """Return the sentence on the ranked change that gains most as a whole, unless it was named before."""
        suspect, most = max(self.competing, key=lambda item: item[1].mean)
        if suspect is named or most.mean <= 0:
            return ""
        surely = all(gain.high < most.low for other, gain in self.competing if other is not suspect)
        gains = "gains" if surely else "may gain"
        return f" Of whole changes, {suspect.relief} {gains} most: {self._number(most).text}."

    def _at_most(self, value: float) -> str:
        """Return an upper bound in words, rounded up."""
        value = max(value, 0.0) * self.scale.by
        digits = max(0, 1 - math.floor(math.log10(value))) if value else 0
        shown = numbers.number(math.ceil(value * 10**digits) / 10**digits, digits)
        return f"{shown} {self.scale.unit}".rstrip()

    def _lost(self) -> str:
        """Return the sentence on the share of time that robots waited in one run, and for which main causes.

        It is empty if no robot waited.
        """
        lost = self.costs.lost
        if not lost:
            return ""
        most = [f"{numbers.PERCENT.value(part)} {root(loss, self.model)}" for loss, part in list(lost.items())[:_ROOTS]]
        whole = numbers.PERCENT.value(math.fsum(lost.values()))
        return f"In the run looked at, robots spent {whole} of their time waiting: {spoken(most)}."

    def _batched(self) -> str:
        """Return the sentence on the share of time that tasks waited for a batch to fill; empty if no task did."""
        if not self.costs.batched:
            return ""
        share = numbers.PERCENT.value(self.costs.batched)
        return f"In the run looked at, tasks spent {share} of their time waiting for a batch."

    # Numbers

    def _number(self, gain: Gain) -> ShownNumber:
        return judged.within(self.costs.indicator, self.scale, (gain.mean, gain.low, gain.high), 0.0)

    def _as_it_is(self) -> list[BigNumber]:
        base = self.costs.as_it_is
        if base is None:
            return []
        scale = words.scale(self.costs.indicator, self.model, (base.mean,))
        shown = judged.estimated(self.costs.indicator, scale, base)
        return [judged.tile(shown.text, f"{self.of}, as it is")]

    def _health(self) -> list[BigNumber]:
        """Return tiles with the share on time and the idle share of robots, unless a sentence states them."""
        state = self.costs.state
        if state is None or not self.costs.is_held_up:
            return []
        due = [] if state.on_time is None else [BigNumber(value=numbers.PERCENT.value(state.on_time), what="on time")]
        return [*due, BigNumber(value=numbers.PERCENT.value(state.idle), what="of robots' time idle")]

    def _standing(self, suspect: Suspect, gain: Gain) -> Standing:
        costs = self.costs
        if gain.change in costs.failures or gain.failed:
            return "fails"
        if gain.same:
            return "same"
        if gain.scale is None:
            return "apart"
        if suspect is self.competing[0][0] and costs.is_clear:
            return "best"
        return "less" if gain.beaten or gain.high <= 0 else "perhaps"

    def _options(self) -> list[Option]:
        """Return a row for each change, competing changes by their gain of 10 %; changes without effect share a row."""
        same = [suspect.relief for suspect, gain in self.costs.ranked if gain.same]
        rows = []
        for suspect, gain in self.costs.ranked:
            if gain.same and suspect.relief != same[0]:
                continue
            standing, text = self._standing(suspect, gain), ""
            if gain.change in self.costs.failures:
                text = fails(self.costs.failures[gain.change])
            elif gain.failed:
                text = f"no value in {gain.failed} of {number_of(gain.n, 'run')}"
            elif gain.same:
                text = f"no difference in {number_of(gain.n, 'run')}"
            rows.append(
                Option(
                    name=suspect.relief,
                    standing=standing,
                    number=None if text else self._number(gain.each if gain.competes else gain),
                    instead=text,
                    runs=gain.n,
                    set=dict(suspect.overrides),
                    same=tuple(same[1:]) if gain.same else (),
                )
            )
        return rows

    def _figure(self) -> Rows | None:
        bars = (
            judged.bar(suspect.relief, self._number(gain.each), self._standing(suspect, gain))
            for suspect, gain in self.competing
        )
        title = f"What each change gains in {self.of}, {_PER} of it"
        return judged.figure(title, bars, 0.0, "no gain")

    def _changes(self) -> list[Folded]:
        """Return the table of changes: the size of each, the waiting at its place, and the gain of the whole change."""
        rows = tuple(
            (
                suspect.relief,
                dose(suspect),
                "" if suspect.waited is None else numbers.PERCENT.value(suspect.waited),
                "" if math.isnan(gain.mean) else self._number(gain).text,
            )
            for suspect, gain in self.costs.ranked
        )
        note = "Waited: the part of the robots' time, in one run. Gains as a whole, however large the change."
        head = ("change", "how much more", "waited", "gain as a whole")
        return [Folded(title="The changes as a whole", note=note, head=head, rows=rows)] if rows else []


def dose(suspect: Suspect) -> str:
    """Return the size of a change as a percentage of the model's value."""
    if suspect.dose is None:
        return "all"
    percent = 100 * suspect.dose
    text = f"{percent:+,.0f} %" if abs(percent) >= _MANY else f"{percent:+.3g} %"
    return text.replace("-", "\N{MINUS SIGN}")


def _state(now: Health) -> str:
    """Return the idle share of robots and the share on time in the unchanged warehouse, in words."""
    due = [] if now.on_time is None else [f"{numbers.PERCENT.value(now.on_time)} on time"]
    return ", ".join([f"robots idle {100 * now.idle:.0f} % of the time", *due])


def _is(name: str) -> str:
    """Return the verb for a suspect: `are` for intersections, `is` for an intersection."""
    first = name.split(maxsplit=1)[0]
    return "are" if first.endswith("s") or name.endswith("lanes") or first == "people" else "is"


def _facts(suspect: Suspect, gain: Gain) -> dict[str, Any]:
    return {
        "name": suspect.name,
        "relief": suspect.relief,
        "waited": suspect.waited,
        "dose": suspect.dose,
        "gain": _finite(gain.mean),
        "low": _finite(gain.low),
        "high": _finite(gain.high),
        "per_10_percent": None if suspect.dose is None else _finite(suspect.scale * gain.mean),
        "failed": gain.failed,
        "competes": gain.competes,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
