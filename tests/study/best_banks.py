"""Made-up warehouses whose best design is known exactly, and searches among them.

Days are good or bad for all designs, and noisy for each. `python -m tests.study.best_banks 200` prints, for three kinds
of them, how far what a search chooses is from the best that there is, beside choosing at random and successive halving.
"""

import itertools
import math
import random
import statistics
import sys
from functools import cache

from desim_warehouse.study.designs.best_of_many import first_meeting_steps
from desim_warehouse.study.designs.local_search import Goal, LocalSearch
from desim_warehouse.study.statistics.judge import Budget, Judge
from desim_warehouse.study.statistics.limits import COMMON_DAYS
from desim_warehouse.study.statistics.procedure import follow
from desim_warehouse.study.target import read_target

TARGET = read_target("on_time >= 95 %")
SHARED, OWN = 0.03, 0.02
"""Standard deviations of what a day needs: of the day, and of one design on it."""


class MadeUpBank:
    """Designs that are tuples; `truth` has the mean of each and what it reaches of the target, `run` those of a day."""

    maximise, goal = True, None

    def __init__(self, seed):
        self.name = f"{type(self).__name__} {seed}"
        self.draw = random.Random(self.name)

    def noise(self, day, design=""):
        return random.Random(f"{self.name} {day} {design}").gauss(0, 1)

    def first(self):
        yield self.every()[0]

    def sample(self, draw):
        return draw.choice(self.every())

    def allows(self, design):
        return design in self.known

    @property
    def known(self):
        return frozenset(self.every())

    def effort(self, design):
        return sum(one != other for one, other in zip(design, self.every()[0], strict=True))

    def meets(self, design):
        return self.goal is None or self.goal.met_by(self.truth(design)[1])

    def gap(self, design):
        """How much worse a design is than the best that meets the target, as a share of the best."""
        best = (max if self.maximise else min)(self.truth(one)[0] for one in self.every() if self.meets(one))
        return abs(self.truth(design)[0] - best) / best


class FleetBank(MadeUpBank):
    """4 to 12 robots, 1 to 4 chargers, 4 allocations and 2 charging policies; a year's cost, 95 % on time."""

    maximise, goal, counts = False, TARGET, (9, 4, 4, 2)

    def __init__(self, seed):
        super().__init__(seed)
        draw = self.draw
        self.need = draw.uniform(5.2, 8.5)
        self.allocation = [1.0, draw.uniform(0.9, 1.12), draw.uniform(0.9, 1.12), draw.uniform(0.8, 1.0)]
        self.charging = [1.0, draw.uniform(0.93, 1.07)]
        self.chargers = draw.uniform(0.22, 0.42)
        self.truth = cache(self.truth)

    @cache  # noqa: B019 - a handful of banks
    def every(self):
        return list(itertools.product(*map(range, self.counts)))

    def slack(self, design):
        robots, chargers = 4 + design[0], 1 + design[1]
        charged = min(1.0, 0.55 + 0.45 * chargers / (self.chargers * robots))
        return robots * self.allocation[design[2]] * self.charging[design[3]] * charged / self.need - 1

    def values(self, design, slack):
        on_time = 1 / (1 + math.exp(-slack / 0.05))
        return 6000 * (4 + design[0]) + 2500 * (1 + design[1]) + 4000 * (1 - on_time), on_time

    def truth(self, design):
        """The mean over all days, by the trapezoidal rule over their normal distribution."""
        slack, both = self.slack(design), math.hypot(SHARED, OWN)
        steps = [-4 + 0.2 * step for step in range(41)]
        weights = [math.exp(-z * z / 2) for z in steps]
        values = [self.values(design, slack + both * z) for z in steps]
        return tuple(sum(w * one[i] for w, one in zip(weights, values, strict=True)) / sum(weights) for i in (0, 1))

    def run(self, design, day):
        off = SHARED * self.noise(day) + OWN * self.noise(day, design)
        return self.values(design, self.slack(design) + off)

    def neighbours(self, design):
        for rank, count in enumerate(self.counts):
            leap = max(2, count // 4)
            near = [design[rank] + by for by in (-1, 1, -leap, leap)] if rank < 2 else range(count)
            for value in near:
                if value != design[rank]:
                    yield (*design[:rank], value, *design[rank + 1 :])


class AisleBank(MadeUpBank):
    """Nine aisles that lead one way or the other, a fifth of all combinations refused; tasks an hour."""

    def __init__(self, seed):
        super().__init__(seed)
        self.alone = [self.draw.gauss(0, 12) for _ in range(9)]
        self.pairs = {(i, j): self.draw.gauss(0, 7) for i in range(9) for j in range(i)}
        self.refused = {one for one in itertools.product((0, 1), repeat=9) if any(one) and self.draw.random() < 0.2}

    @cache  # noqa: B019
    def every(self):
        return [one for one in itertools.product((0, 1), repeat=9) if one not in self.refused]

    def truth(self, design):
        gain = sum(a * b for a, b in zip(self.alone, design, strict=True))
        return 750 + gain + sum(gain for (i, j), gain in self.pairs.items() if design[i] and design[j]), None

    def run(self, design, day):
        return self.truth(design)[0] + 20 * self.noise(day) + 9 * self.noise(day, design), None

    def neighbours(self, design):
        return ((*design[:bit], 1 - design[bit], *design[bit + 1 :]) for bit in range(9))


class NodeBank(MadeUpBank):
    """3 of 20 nodes, from which the goods are some way off; tasks an hour."""

    def __init__(self, seed):
        super().__init__(seed)
        draw = self.draw
        self.at = [(node % 5 + draw.uniform(-0.2, 0.2), node // 5 + draw.uniform(-0.2, 0.2)) for node in range(20)]
        self.goods = [(draw.uniform(0, 4), draw.uniform(0, 3), draw.uniform(0.3, 1)) for _ in range(6)]
        self.own = [draw.gauss(0, 2) for _ in range(20)]
        self.truth = cache(self.truth)

    @cache  # noqa: B019
    def every(self):
        return list(itertools.combinations(range(20), 3))

    def truth(self, design):
        way = sum(w * min(math.dist(self.at[node], (x, y)) for node in design) for x, y, w in self.goods)
        return 280 - 6 * way + sum(self.own[node] for node in design), None

    def run(self, design, day):
        return self.truth(design)[0] + 6 * self.noise(day) + 4 * self.noise(day, design), None

    def neighbours(self, design):
        for node in design:
            free = sorted(set(range(20)) - {*design}, key=lambda one: math.dist(self.at[one], self.at[node]))
            yield from (tuple(sorted({*design} - {node} | {other})) for other in free[:6])


def searched(bank, runs, seed=0):
    """The candidates of a search, the best first."""
    designs, reached = [], {}

    def number(design):
        if design not in designs:
            designs.append(design)
        return designs.index(design)

    def run(design, day):
        value, reached[design, day] = bank.run(designs[design], f"search {seed} {day}")
        return value

    goal = None if bank.goal is None else Goal(bank.goal, lambda design, day: reached[design, day])
    random_ = random.Random(seed)
    return follow(LocalSearch(bank, number, runs, random_, maximise=bank.maximise, goal=goal).steps(), run)


def at_random(bank, runs, seed=0, each=3):
    """Designs drawn at random, three days each, the best first."""
    draw, days = random.Random(seed), [f"search {seed} {day}" for day in range(each)]
    drawn = dict.fromkeys(bank.sample(draw) for _ in range(runs // each))
    return ranked(bank, {design: [bank.run(design, day) for day in days] for design in drawn})


def halved(bank, runs, seed=0):
    """Designs drawn at random, of which the better half has twice the days until few are left."""
    draw, left, days = random.Random(seed), runs, 1
    alive = list(dict.fromkeys(bank.sample(draw) for _ in range(runs // 4)))
    outcomes = {design: [] for design in alive}
    while alive and left >= sum(days - len(outcomes[design]) for design in alive):
        for design in alive:
            left -= days - len(outcomes[design])
            outcomes[design] += [bank.run(design, f"search {seed} {day}") for day in range(len(outcomes[design]), days)]
        most = [one for one in ranked(bank, outcomes) if one in alive]
        alive, days = most[: max(2, len(most) // 2)], 2 * days
    return [one for one in ranked(bank, outcomes) if one in alive]


def ranked(bank, outcomes):
    """Designs by their means: those first that meet the target by them."""
    sign = 1 if bank.maximise else -1

    def score(design):
        values, reached = zip(*outcomes[design], strict=True)
        beyond = 0.0 if bank.goal is None else min(0.0, statistics.fmean(reached) - bank.goal.value)
        return beyond, sign * statistics.fmean(values)

    return sorted(outcomes, key=score, reverse=True)


def chosen(bank, candidates, runs, seed=0):
    """What the last word says on fresh days: the design, and whether it is shown to meet the target."""
    if bank.goal is None:
        return candidates[0], True
    judge = Judge(
        bank.goal, first=10, days=lambda _: COMMON_DAYS.up_to(2 * runs // 5), within=(0.0, 1.0), budget=Budget(runs)
    )
    last = follow(
        first_meeting_steps(len(candidates), judge),
        lambda one, day: bank.run(candidates[one], f"fresh {seed} {day}")[1],
    )
    return candidates[last or 0], last is not None


METHODS = {"search": searched, "random": at_random, "successive halving": halved}


def main(count):
    """Print how far each method is from the truth, with 400 runs to search and 100 to judge, or 500 to search."""
    for kind in (FleetBank, AisleBank, NodeBank):
        for name, method in METHODS.items():
            gaps, missed, unproved, exact = [], 0, 0, 0
            for seed in range(count):
                bank = kind(seed)
                candidates = method(bank, 400 if name == "search" else 500, seed)
                design, shown = chosen(bank, candidates[:4], 100, seed) if name == "search" else (candidates[0], True)
                missed += shown and not bank.meets(design)
                unproved += not shown
                gaps += [bank.gap(design)] if bank.meets(design) else []
                exact += bank.meets(design) and bank.gap(design) < 1e-9
            gap = 100 * statistics.fmean(gaps)
            line = f"gap {gap:.2f} %, the best {100 * exact / count:.0f} %, missed {missed}, not shown {unproved}"
            sys.stdout.write(f"{kind.__name__:11} {name:19} {line}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main(int(sys.argv[1]))
