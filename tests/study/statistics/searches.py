"""The search for the smallest of given values as `desim size` does it, on values that a test makes up."""

from desim_warehouse.study.statistics import (
    Budget,
    Judge,
    follow,
    line,
    parse_target,
    scout_steps,
    smallest_meeting_steps,
)


def smallest(sample, values, target, *, scan=False, **options):
    """The Sizing of `values` by `sample(value, replication)`; `options` are those of a judge."""
    values, goal = list(values), parse_target(target) if isinstance(target, str) else target

    def run(number, replication):
        return sample(values[number], replication)

    scout = scout_steps(line(len(values)), lambda design: design, goal, Budget(len(values)))
    doubted = () if scan or not values else follow(scout, run)
    return follow(smallest_meeting_steps(values, Judge(goal, **options), doubted, scan=scan), run)
