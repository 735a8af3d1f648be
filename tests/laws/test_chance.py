"""What a model says of chance before a run is what its runs do.

A model said to be without chance draws nothing, and runs the same with three seeds; one whose run drew nothing is said
to be without chance, unless chance came too late to be seen (people who come into one of several aisles).
"""

import pytest

import desim_warehouse as dw
from tests.laws.breakdowns import with_breakdowns
from tests.laws.closures import with_closures
from tests.laws.random_models import model
from tests.laws.test_everything import with_everything
from tests.laws.test_random_models import chunks
from tests.laws.wider import wider

LONG = 1000


def closed(number):
    return with_closures(model(number), number, dw.load(model(number)).fleet.contact)


MAKERS = {
    "plain": model,
    "wider": lambda number: wider(model(number), number),
    "breakdowns": lambda number: with_breakdowns(model(number), number),
    "closures": closed,
    "everything": lambda number: with_everything(model(number), number),
}


@pytest.mark.parametrize("numbers", [range(25), *chunks(25, LONG, pytest.mark.long)])
@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_chance_is_known_before_a_run(make, numbers):
    wrong = []
    for number in numbers:
        made = dw.load(make(number))
        first = dw.simulate(made, 0)
        if made.is_deterministic:
            rows = [dw.simulate(made, seed).record.rows for seed in (1, 2)]
            wrong += [number] if not first.deterministic or any(first.record.rows != other for other in rows) else []
        elif first.deterministic and not made.people:
            wrong.append(number)
    assert wrong == []


def test_models_of_both_kinds_are_drawn():
    said = [dw.load(model(number)).is_deterministic for number in range(40)]
    assert 5 <= sum(said) <= 35
