"""Searches as `desim size` and `desim best` do them, on values that a test makes up."""

from desim_warehouse.outcome.targets import parse_target
from desim_warehouse.study.statistics.cheapest import line, scout_steps, smallest_meeting_steps
from desim_warehouse.study.statistics.judge import Budget, Judge
from desim_warehouse.study.statistics.limits import COMMON_DAYS
from desim_warehouse.study.statistics.procedure import follow
from desim_warehouse.study.statistics.selection import kn_steps


def up_to(cap):
    """The days of a `Judge` with another cap."""
    return lambda _: COMMON_DAYS.up_to(cap)


def smallest(sample, values, target, *, scan=False, cap=COMMON_DAYS.cap, **options):
    """The Sizing of `values` by `sample(value, replication)`; `options` are those of a judge."""
    values, goal = list(values), parse_target(target) if isinstance(target, str) else target

    def run(number, replication):
        return sample(values[number], replication)

    scout = scout_steps(line(len(values)), lambda design: design, goal, Budget(len(values)))
    doubted = () if scan or not values else follow(scout, run)
    return follow(smallest_meeting_steps(values, Judge(goal, days=up_to(cap), **options), doubted, scan=scan), run)


def kn(sample, k, delta, confidence=0.95, n0=10, **options):
    """The best of `k` designs by `sample(design, replication)`."""
    return follow(kn_steps(k, delta, confidence, n0, **options), sample)
