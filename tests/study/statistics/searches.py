"""Searches as `desim size` and `desim best` do them, on values that a test makes up."""

from dataclasses import dataclass, replace

from desim_warehouse.outcome.targets import parse_target
from desim_warehouse.study.statistics.cheapest import cheapest_meeting_steps, scout_steps
from desim_warehouse.study.statistics.judge import Budget, Judge
from desim_warehouse.study.statistics.limits import COMMON_DAYS
from desim_warehouse.study.statistics.procedure import follow
from desim_warehouse.study.statistics.selection import kn_steps


def up_to(cap):
    """The days of a `Judge` with another cap."""
    return lambda _: COMMON_DAYS.up_to(cap)


@dataclass(frozen=True)
class Sizing:
    """A search with one count, in the values of a test: the answer, all verdicts, and the one on its neighbour."""

    smallest: object
    below: object
    decisions: tuple
    falls: tuple
    vetoed: tuple
    runs: int


def line(number):
    """Designs with one count."""
    return [(position,) for position in range(number)]


def sizing_steps(values, judge, doubted=(), *, scan=False):
    """The steps of a search with one count, which end in a `Sizing`."""
    cheapest = yield from cheapest_meeting_steps(line(len(values)), lambda design: design, judge, doubted, scan=scan)
    decisions = {number: replace(verdict, value=values[number]) for number, verdict in cheapest.verdicts.items()}
    last = len(values) - 1 if cheapest.design is None else cheapest.design - 1
    return Sizing(
        None if cheapest.design is None else values[cheapest.design],
        decisions.get(last),
        tuple(decisions.values()),
        tuple((values[pair.base], values[pair.number]) for pair in cheapest.larger if pair.worse),
        tuple((values[number], why) for number, why in cheapest.vetoed.items()),
        cheapest.runs,
    )


def smallest(sample, values, target, *, scan=False, cap=COMMON_DAYS.cap, **options):
    """The Sizing of `values` by `sample(value, replication)`; `options` are those of a judge."""
    values, goal = list(values), parse_target(target) if isinstance(target, str) else target

    def run(number, replication):
        return sample(values[number], replication)

    scout = scout_steps(line(len(values)), lambda design: design, goal, Budget(len(values)))
    doubted = () if scan or not values else follow(scout, run)
    return follow(sizing_steps(values, Judge(goal, days=up_to(cap), **options), doubted, scan=scan), run)


def kn(sample, k, delta, confidence=0.95, n0=10, **options):
    """The best of `k` designs by `sample(design, replication)`."""
    return follow(kn_steps(k, delta, confidence, n0, **options), sample)
