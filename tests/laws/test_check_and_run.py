"""The verdicts of the check and of a run on the load of a hall never contradict each other."""

import pytest

import desim_warehouse as dw
from desim_warehouse.outcome.verdicts import piles_up
from desim_warehouse.questions.run import words
from desim_warehouse.questions.run.lasting import OVERLOADS
from tests.daily import some
from tests.run.halls import loaded_hall

pytestmark = pytest.mark.usefixtures("brief_probes")

FEW, MANY = 0.9, 1.1
"""Loads below which no hall is overloaded in a few hours, and above which every hall is."""


@pytest.mark.parametrize("number", some(range(200), 40))
def test_check_and_run_agree_on_a_load(number):
    model, load = loaded_hall(number, "4 h")
    overloads = [finding.code for finding in dw.check(model).findings if finding.code in OVERLOADS]
    run = dw.simulate(model, number)
    keeps_up = any(line.startswith("The warehouse keeps up") for line in words.sentences(run))
    assert not (overloads and keeps_up)
    assert overloads or not piles_up(run.verdicts)
    if load < FEW:
        assert not overloads
    if load > MANY:
        assert overloads
        assert not keeps_up
