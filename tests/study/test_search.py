"""Local search with paired races, on made-up landscapes whose best design is known."""

import math
import random

import pytest

from desim_warehouse.study.designs.local_search import LocalSearch
from desim_warehouse.study.statistics.procedure import follow

BITS = 9


class Bits:
    """All designs of nine bits but those that are refused."""

    def __init__(self, refused=()):
        self.refused = set(refused)

    def first(self):
        yield (0,) * BITS

    def sample(self, random):
        design = tuple(random.randint(0, 1) for _ in range(BITS))
        return design if self.allows(design) else (0,) * BITS

    def neighbours(self, design):
        return ((*design[:bit], 1 - design[bit], *design[bit + 1 :]) for bit in range(BITS))

    def allows(self, design):
        return design not in self.refused

    def effort(self, design):
        return sum(design)


class Landscape:
    """Each bit gains or loses, pairs of bits interact; days are good or bad for all designs, and noisy for each."""

    def __init__(self, seed, noise=2.0):
        draw = random.Random(seed)
        self.alone = [draw.gauss(0, 4) for _ in range(BITS)]
        self.pairs = {(i, j): draw.gauss(0, 2) for i in range(BITS) for j in range(i)}
        self.noise = noise
        self.asked = []

    def mean(self, design):
        return sum(a * b for a, b in zip(self.alone, design, strict=True)) + sum(
            gain * design[i] * design[j] for (i, j), gain in self.pairs.items()
        )

    def value(self, design, replication):
        self.asked.append((design, replication))
        day = random.Random(f"{replication}").gauss(0, 10)
        return self.mean(design) + day + random.Random(f"{design} {replication}").gauss(0, self.noise)

    @property
    def best(self):
        return max(self.mean(tuple(number >> bit & 1 for bit in range(BITS))) for number in range(2**BITS))


def searched(landscape, space=None, runs=400, seed=0, **how):
    numbers = []

    def number(design):
        if design not in numbers:
            numbers.append(design)
        return numbers.index(design)

    steps = LocalSearch(space or Bits(), number, runs, random.Random(seed), **{"maximise": True, **how}).steps()
    return follow(steps, lambda one, replication: landscape.value(numbers[one], replication))


def test_the_best_of_512_is_found_in_nine_of_ten_searches():
    successes = 0
    for seed in range(30):
        landscape = Landscape(seed)
        successes += landscape.mean(searched(landscape, seed=seed)[0]) >= landscape.best - 0.5
        assert len(landscape.asked) == len(set(landscape.asked)) <= 400
    assert successes >= 27


def test_less_is_better_where_that_is_said():
    up, down = Landscape(3, noise=0), Landscape(3, noise=0)
    down.alone, down.pairs = [-gain for gain in up.alone], {pair: -gain for pair, gain in up.pairs.items()}
    assert up.mean(searched(up)[0]) == -down.mean(searched(down, maximise=False)[0]) == up.best


def test_designs_that_are_refused_are_not_asked_for():
    landscape = Landscape(3)
    best = searched(Landscape(3))[0]
    assert searched(landscape, Bits(refused=[best]))[0] != best
    assert best not in {design for design, _ in landscape.asked}


def test_a_design_whose_run_failed_is_not_named():
    landscape = Landscape(3)
    best = searched(Landscape(3))[0]
    value = landscape.value
    landscape.value = lambda design, replication: math.nan if design == best else value(design, replication)
    assert searched(landscape)[0] != best


def test_without_chance_a_design_is_run_once():
    landscape = Landscape(5, noise=0.0)
    assert landscape.mean(searched(landscape, exact=True)[0]) == landscape.best
    assert {replication for _, replication in landscape.asked} == {0}


@pytest.mark.parametrize("runs", [50, 63, 120])
def test_no_run_more_than_is_allowed(runs):
    landscape = Landscape(1)
    searched(landscape, runs=runs)
    assert len(landscape.asked) <= runs


def test_of_designs_that_do_equally_well_the_one_nearest_to_the_present_is_named():
    landscape = Landscape(2, noise=0)
    landscape.alone, landscape.pairs = [0.0] * (BITS - 1) + [1.0], {}
    assert searched(landscape, exact=True)[0] == (0,) * (BITS - 1) + (1,)
