"""How many robots, chargers and packers it takes: `plan_fleet`, whose answer is put into words by `plan_words`."""

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
from desim_warehouse.model.guesses import guesses as marked
from desim_warehouse.questions import judged, plan_words
from desim_warehouse.study.fleet import FleetSizes, size_fleet
from desim_warehouse.study.fleet.sizes import Shown, Sized
from desim_warehouse.study.search import USUAL, Search

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, repr=False)
class Plan(Answered, FleetSizes):
    """How many robots, chargers and packers meet a target, for each demand: what `plan` found.

    Attributes:
        answer: in words; printing the plan prints it.
        demands: the answer for today, then for each demand that grew; `best` is its fleet, None: none is enough.
        model: the warehouse.
        target: what a fleet has to meet.
        strategy: the better strategy that the fleets are for; None: that of the model.
        runs: simulated for it in all.
    """

    @property
    def robots(self) -> int | None:
        """Robots of the fleet for today's demand; None: no fleet was shown to be enough."""
        return None if self.today.best is None else self.today.best.robots

    @property
    def chargers(self) -> int | None:
        """Chargers beside them; 0 where chargers are not sized."""
        return None if self.today.best is None else self.today.best.chargers

    @property
    def packers(self) -> int | None:
        """Packers at each node of the station that is sized; 0: none is."""
        return None if self.today.best is None else self.today.best.packers

    @property
    def cost(self) -> float | None:
        """What is counted of the fleet a year, in the currency of the model; None without prices, or a fleet."""
        return None if self.today.best is None else self.today.best.cost

    @property
    def overrides(self) -> dict[str, Any]:
        """What makes the model into that with the fleet: `plan.model.replace(plan.overrides)`; empty without one."""
        best = self.today.best
        return {} if best is None else {**self.today.overrides, **best.overrides}

    @property
    def table(self) -> pd.DataFrame:
        """A row for each fleet that shows the answer, those for today's demand first.

        Columns: growth (demand in times today's), robots, chargers, packers, the indicator of the target with `_low`
        and `_high` (of the verdict, in the model's units), verdict, annual_cost, runs.
        """
        import pandas as pd

        rows = []
        for sized in self.demands:
            fleets = {one.counts: one for one in (*sized.below, *([sized.best] if sized.best else []))}
            rows += [self._row(sized, fleets[counts]) for counts in sorted(fleets)]
        return pd.DataFrame(rows)

    def in_short(self) -> str:
        """Name the fleet for each demand."""
        later = [f"{_fleet(sized, short=True)} {_when(sized)}" for sized in self.demands[1:]]
        return "; ".join([_fleet(self.today), *later])

    def _row(self, sized: Sized, one: Shown) -> dict[str, Any]:
        verdict = one.vetoed or next((said.text for said in one.wrong if said.is_lasting), "")
        return {
            "growth": sized.growth,
            "robots": one.robots,
            "chargers": one.chargers,
            "packers": one.packers,
            **number_columns(self.target.indicator, one.verdict.mean, one.verdict.low, one.verdict.high),
            "verdict": verdict or WORDS[judged.standing_of(one.verdict, self.target)],
            "annual_cost": one.cost,
            "runs": one.verdict.n,
        }


def _fleet(sized: Sized, *, short: bool = False) -> str:
    """Name the fleet for a demand: `9 robots + 1 charger`, in short `9 + 1`."""
    best = sized.best
    if best is None:
        return "not decided" if sized.undecided or sized.open else "no fleet is enough"
    names = ("robot", "charger", "packer")
    counts = [(count, name) for count, name in zip(best.counts, names, strict=False) if count]
    return " + ".join(str(count) if short else number_of(count, name) for count, name in counts)


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
    zone: float | str | None = None,
    guesses: Sequence[str] | None = None,
    search: Search = USUAL,
) -> Plan:
    """Find how many robots, chargers and packers meet a target, today and with more demand, and with which strategy.

    Args:
        model: the warehouse, or its file. With prices of robots or chargers the cheapest are sought, else fewest
            robots, then chargers, then packers. Its bays with most chargers are those whose chargers are sized.
        target: such as "on_time >= 95 %"; of several, as in ["on_time:express >= 95 %", "on_time:rest >= 98 %"], a
            fleet has to meet all.
        growth: demand in times today's, such as 1.3 or "30%"; with years "20%/year"; None: today's only.
        years: that are planned after today's. What fails with less demand is taken to fail with more.
        strategies: key of the model -> its values, to be tried with designs too small (default: `STRATEGIES`).
        robots: fleet sizes that could be bought, such as "6..20" (default: around what the quick estimate needs).
        chargers: likewise.
        packers: a station and who may work there, at each of its nodes, such as "packing=1..4": its servers, or its
            workers where it has a work time; "packing": by the quick estimate; None: as many as the model has.
        zone: indifference zone in the unit of the one target; default: 0.01 for shares, else 1 % of the target. At most
            half of what is possible beyond the target: for 99.5 % it is 0.25 %.
        guesses: keys of the model that are guesses, which the page lists (default: those that its file marks with (!)).
        search: how runs are done, at most 5000 by default.

    Returns:
        The fleet for each demand, with the answer in words; see `Plan`.

    Raises:
        StudyError: a bad target or zone, demand that cannot grow, a run that failed, too few runs to search.

    Source: a search by bisection with sequential tests, all at the error that `search.confidence` leaves; what it
    promises and assumes is on the page *How many robots and chargers?*.
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
        zone=zone,
        search=search,
    )
    if guesses is None and isinstance(model, str | Path):
        guesses = marked(model)
    return worded(sizes, search, guesses)


def worded(sizes: FleetSizes, search: Search = USUAL, guesses: Sequence[str] | None = None) -> Plan:
    """Add the answer to the sizes of a fleet, and write it to the folder of the search."""
    return Plan(**vars(sizes), answer=plan_words.answer(sizes, guesses).keep(search.out, search.command))
