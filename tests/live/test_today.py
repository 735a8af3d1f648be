"""The page of `desim what-if` marks today's value where it was tried, and nothing where it was not."""

import sys

import pytest

import desim_warehouse as dw
from desim_warehouse.live.offers import ALLOCATION, offers
from desim_warehouse.policies import catalogue
from desim_warehouse.policies.allocation import InOrder
from desim_warehouse.report.example import example
from tests.lasting import LASTING
from tests.live.test_frozen import held

pytestmark = pytest.mark.usefixtures("brief_probes")


@pytest.mark.parametrize(
    ("factors", "today"),
    [
        ({"fleet.size": [1, 4]}, {"fleet.size": None}),
        ({"fleet.size": [1, 3, 4]}, {"fleet.size": 3}),
        ({"fleet.size": [4, 3]}, {"fleet.size": 3}),
        ({"fleet.robot.speed": ["1 m/s", "2 m/s"]}, {"fleet.robot.speed": None}),
        ({"policies.allocation": ["hungarian", "nearest"]}, {"policies.allocation": "nearest"}),
    ],
)
def test_today_is_the_value_of_the_model_or_none(factors, today):
    base = example().replace({"fleet.size": 3, "policies.allocation": "nearest", **LASTING})
    study = dw.Study(base, factors, replications=1).run()
    knobs = held(dw.what_if_page(study.results).html)["about"]["knobs"]
    assert {one["key"]: None if one["today"] is None else one["values"][one["today"]] for one in knobs} == today


class LastChance(InOrder):
    def __init__(self, slack: float):
        self.slack = slack


def test_a_strategy_that_needs_a_parameter_is_not_offered(monkeypatch):
    monkeypatch.setitem(sys.modules, "desim_warehouse.policies.of_a_test", sys.modules[__name__])
    monkeypatch.setitem(catalogue.OURS["allocation"], "last-chance", "of_a_test:LastChance")
    assert catalogue.problems("allocation", "last-chance", {})
    names = offers(example())[ALLOCATION].values
    assert "last-chance" not in names
    assert {"nearest", "hungarian"} <= set(names)
