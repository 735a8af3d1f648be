"""A model knows before a run whether its runs use random numbers.

A deterministic model draws no random number, and its runs are equal for three seeds. A model whose run drew no number
is deterministic, unless chance would have come too late for the run (people who enter one of several aisles).
"""

import pytest

import desim_warehouse as dw
from tests.laws.features import EVERYTHING, warehouse

DAILY = 5
NUMBERS = [range(DAILY), *(pytest.param(range(n, n + 25), marks=pytest.mark.long) for n in range(DAILY, 1000, 25))]
FEATURES = ("", "wider", "breakdowns", "closures", EVERYTHING)


@pytest.mark.parametrize("numbers", NUMBERS)
@pytest.mark.parametrize("features", FEATURES)
def test_chance_is_known_before_a_run(features, numbers):
    wrong = []
    for number in numbers:
        made = dw.load(warehouse(number, features))
        first = dw.simulate(made, 0)
        if made.is_deterministic:
            rows = [dw.simulate(made, seed).record.rows for seed in (1, 2)]
            wrong += [number] if not first.deterministic or any(first.record.rows != other for other in rows) else []
        elif first.deterministic and not made.people:
            wrong.append(number)
    assert wrong == []


def test_models_of_both_kinds_are_drawn():
    deterministic = [dw.load(warehouse(number)).is_deterministic for number in range(40)]
    assert 5 <= sum(deterministic) <= 35
