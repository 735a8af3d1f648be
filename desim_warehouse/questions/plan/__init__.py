"""The verb `plan_fleet`: how many robots, chargers and people meet a target."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.answer.answer import Answered
from desim_warehouse.answer.frame import number_columns
from desim_warehouse.answer.standing import WORDS
from desim_warehouse.errors import number_of
from desim_warehouse.model import Source, as_model
from desim_warehouse.model.facts.people import PACKERS, PEOPLE, PICKERS
from desim_warehouse.model.guesses import guesses as marked
from desim_warehouse.questions import judged
from desim_warehouse.questions.plan.answer import answer as answer_of
from desim_warehouse.study.fleet import FleetSizes, size_fleet
from desim_warehouse.study.fleet.sizes import Shown, Sized
from desim_warehouse.study.search import USUAL, Search

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class Plan(Answered, FleetSizes):
    """The robots, chargers and people that meet a target, for each demand: the result of `plan`.

    Attributes:
        answer: the answer in words; shown by `print`.
        demands: the result for today, then for each larger demand; `best` is the fleet, None if no fleet is enough.
        model: the warehouse.
        target: the target that a fleet has to meet.
        strategy: the better strategy that the fleets use; None: the strategy of the model.
        runs: total number of runs simulated.
    """

    @property
    def robots(self) -> int | None:
        """Number of robots for today's demand; None if no fleet was shown to be enough."""
        return None if self.today.best is None else self.today.best.robots

    @property
    def chargers(self) -> int | None:
        """Number of chargers for today's demand; 0 if chargers are not sized, None without a fleet."""
        return None if self.today.best is None else self.today.best.chargers

    @property
    def packers(self) -> int | None:
        """Number of packers at each node of the sized station; 0 if packers are not sized, None without a fleet."""
        return self._people(PACKERS)

    @property
    def pickers(self) -> int | None:
        """Number of pickers who walk to robots; 0 if pickers are not sized, None without a fleet."""
        return self._people(PICKERS)

    @property
    def cost(self) -> float | None:
        """Annual cost of the fleet, in the currency of the model; None without prices or without a fleet."""
        return None if self.today.best is None else self.today.best.cost

    @property
    def overrides(self) -> dict[str, Any]:
        """Overrides that give the model this fleet, `plan.model.replace(plan.overrides)`; empty without a fleet."""
        best = self.today.best
        return {} if best is None else {**self.today.overrides, **best.overrides}

    @property
    def table(self) -> pd.DataFrame:
        """A row for each fleet that shows the answer, those for today's demand first.

        Columns: growth (demand relative to today's), robots, chargers, packers, pickers, the indicator of the target
        with `_low` and `_high` (of the verdict, in the model's units), verdict, annual_cost, runs.
        """
        import pandas as pd

        rows = []
        for sized in self.demands:
            fleets = {shown.counts: shown for shown in (*sized.below, *([sized.best] if sized.best else []))}
            rows += [self._row(sized, fleets[counts]) for counts in sorted(fleets)]
        return pd.DataFrame(rows)

    def in_short(self) -> str:
        """Return the fleet for each demand in a few words."""
        later = [f"{self._fleet(sized, short=True)} {_when(sized)}" for sized in self.demands[1:]]
        return "; ".join([self._fleet(self.today), *later])

    def _fleet(self, sized: Sized, *, short: bool = False) -> str:
        """Return the fleet for a demand in words: `9 robots + 1 charger`, in short `9 + 1`."""
        best = sized.best
        if best is None:
            return (
                "not decided" if sized.undecided or sized.open else f"no fleet{' tried' * sized.is_cut_off} is enough"
            )
        nouns = ("robot", "charger", *(kind.noun for kind in self.designs.people))
        counts = [(count, noun) for count, noun in zip(best.counts, nouns, strict=True) if count]
        return " + ".join(str(count) if short else number_of(count, noun) for count, noun in counts)

    def _people(self, name: str, shown: Shown | None = None) -> int | None:
        """Return the number of people of a kind in a fleet, by default the fleet for today's demand.

        Packers are counted at each node. It is 0 if this kind is not sized, and None without a fleet.
        """
        shown = shown or self.today.best
        if shown is None:
            return None
        names = [kind.name for kind in self.designs.people]
        return shown.counts[2 + names.index(name)] if name in names else 0

    def _row(self, sized: Sized, shown: Shown) -> dict[str, Any]:
        verdict = shown.vetoed or next((finding.text for finding in shown.wrong if finding.is_lasting), "")
        return {
            "growth": sized.growth,
            "robots": shown.robots,
            "chargers": shown.chargers,
            **{name: self._people(name, shown) for name in PEOPLE},
            **number_columns(self.target.indicator, shown.verdict.mean, shown.verdict.low, shown.verdict.high),
            "verdict": verdict or WORDS[judged.standing_of(shown.verdict, self.target)],
            "annual_cost": shown.cost,
            "runs": shown.verdict.n,
        }


def _when(sized: Sized) -> str:
    return f"at {sized.growth:g} x" if sized.year is None else f"in year {sized.year}"


def plan_fleet(
    model: Source,
    target: str | Sequence[str],
    *,
    growth: float | str | None = None,
    years: int | None = None,
    strategies: Mapping[str, Any] | None = None,
    robots: Sequence[int] | str | None = None,
    chargers: Sequence[int] | str | None = None,
    packers: str | None = None,
    pickers: Sequence[int] | str | None = None,
    zone: float | str | None = None,
    guesses: Sequence[str] | None = None,
    search: Search = USUAL,
) -> Plan:
    """Find how many robots, chargers and people meet a target, today and with more demand, and the best strategy.

    Args:
        model: the warehouse, or its file. With prices for everything that is sized, the cheapest fleet is sought;
            otherwise the fewest robots, then chargers, packers and pickers. Chargers are all chargers of the hall; they
            are added and removed in the bays that have most of them.
        target: such as "on_time >= 95 %"; of several, such as ["on_time:express >= 95 %", "on_time:rest >= 98 %"], a
            fleet has to meet all.
        growth: demand relative to today's, such as 1.3 or "30%"; with `years`, such as "20%/year"; None: today only.
        years: number of years to plan for after today. A fleet that fails with less demand is assumed to fail with
            more.
        strategies: key of the model -> values to try with designs that are too small (default: `STRATEGIES`).
        robots: numbers of robots to consider, such as "6..20" (default: around the quick estimate).
        chargers: numbers of chargers to consider, likewise.
        packers: a station and the number of people at each of its nodes, such as "packing=1..4": its servers, or its
            workers if it has a work time; "packing": by the quick estimate; None: as many as the model has.
        pickers: number of people who walk to robots, such as "3..9"; "auto": by the quick estimate; None: as many as
            the model has.
        zone: indifference zone of a single target, in its unit; default: 0.01 for shares, otherwise 1 % of the target.
            At most half of the distance from the target to the best possible value: for 99.5 % it is 0.25 %.
        guesses: keys of the model that are guesses, which the page lists (default: those that its file marks with (!)).
        search: settings of runs, at most 5000 by default.

    Returns:
        The fleet for each demand, with the answer in words; see `Plan`.

    Raises:
        StudyError: a bad target or zone, demand that cannot grow, a run that failed, too few runs to search.

    Source: a search by bisection with sequential tests, all at the error rate that `search.confidence` leaves; the page
    *How many robots and chargers?* states its guarantees and assumptions.
    """
    sizes = size_fleet(
        as_model(model),
        target,
        growth=growth,
        years=years,
        strategies=strategies,
        robots=robots,
        chargers=chargers,
        packers=packers,
        pickers=pickers,
        zone=zone,
        search=search,
    )
    if guesses is None and isinstance(model, str | Path):
        guesses = marked(model)
    return worded(sizes, search, guesses)


def worded(sizes: FleetSizes, search: Search = USUAL, guesses: Sequence[str] | None = None) -> Plan:
    """Add the answer to the sizes of a fleet, and write it to the folder of the search."""
    return Plan(**vars(sizes), answer=answer_of(sizes, guesses).keep(search.out, search.command))
