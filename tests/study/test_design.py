"""Factors and the designs made of them."""

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import ModelError
from desim_warehouse.study.design import Point, points
from desim_warehouse.study.factors import Factor, Level, label
from desim_warehouse.study.file import StudyFile
from desim_warehouse.study.plan import models, run_seed


def factor(key, spec):
    (made,) = StudyFile(model="m.yaml", factors={key: spec}).varied()
    return made


def labels(key, spec):
    return [level.label for level in factor(key, spec).levels]


@pytest.mark.parametrize(
    ("spec", "expected"),
    [
        ([2, 3.5, 5], [2, 3.5, 5]),
        ("1..6", [1, 2, 3, 4, 5, 6]),
        ("1..12..4", [1, 5, 9]),
        ("0.1..0.5..0.1", [0.1, 0.2, 0.3, 0.4, 0.5]),
        (["1..3", 6], [1, 2, 3, 6]),
        ({"range": [1, 3]}, [1, 2, 3]),
        ({"range": [0.5, 2, 0.5]}, [0.5, 1.0, 1.5, 2.0]),
        ({"linspace": [5, 20, 4]}, [5, 10, 15, 20]),
        ({"linspace": [0, 1, 5]}, [0, 0.25, 0.5, 0.75, 1]),
        (7, [7]),
    ],
)
def test_values_can_be_given_in_many_forms(spec, expected):
    assert labels("battery.capacity", spec) == expected


def test_whole_numbers_stay_whole():
    assert [type(label) for label in labels("fleet.size", {"linspace": [1, 5, 3]})] == [int, int, int]


def test_policies_are_called_by_name_and_parameters():
    spec = ["threshold", {"name": "opportunity", "minimum": 0.3}]
    assert labels("policies.charging", spec) == ["threshold", "opportunity(minimum=0.3)"]


def test_lists_are_shown_as_text_and_names_as_they_are():
    assert labels("tasks.goods", [[11, 8]]) == ["[11, 8]"]
    assert labels("tasks.goods", {"named": {"few": [11, 8]}}) == ["few"]


@pytest.mark.parametrize(
    ("value", "row"),
    [
        (3, "fleet.size=3"),
        (["M", "N"], "fleet.size=[M, N]"),
        ({"poisson": 200}, "fleet.size=poisson 200"),
        ({"saturated": 12, "due_within": 500}, "fleet.size=saturated 12, due_within 500"),
        ({"rows": ["east", "west"], "on": {"a": None}}, "fleet.size=rows [east, west], on {a: null}"),
        ("[odd", "fleet.size=[odd"),
        ({"name": "reach-aware", "margin": 0.2}, "fleet.size=reach-aware(margin=0.2)"),
    ],
)
def test_rows_are_named_without_json(value, row):
    (made,) = points([Factor("fleet.size", (Level(label(value), {"fleet.size": value}, ()),))], "grid")
    assert str(made) == row


def test_in_a_grid_the_last_factor_changes_fastest():
    made = points([factor("fleet.size", "1..2"), factor("battery.threshold", [2, 3])], "grid")
    assert [tuple(point.labels.values()) for point in made] == [(1, 2), (1, 3), (2, 2), (2, 3)]


def test_paired_lists_go_together():
    made = points([factor("fleet.size", "1..2"), factor("battery.threshold", [2, 3])], "paired")
    assert [point.overrides for point in made] == [
        {"fleet.size": 1, "battery.threshold": 2},
        {"fleet.size": 2, "battery.threshold": 3},
    ]


def test_paired_lists_may_have_a_value_twice():
    made = StudyFile(model="m.yaml", factors={"fleet.size": [3, 3], "battery.threshold": [2, 4]}, design="paired")
    assert [point.labels["fleet.size"] for point in points(made.varied(), made.design)] == [3, 3]


def test_cases_change_several_keys_under_a_name_of_their_own():
    cases = {"small": {"fleet.size": 2, "battery.capacity": 8}, "as it is": {}}
    made = points([factor("plan", {"cases": cases})], "grid")
    assert made[0].labels == {"plan": "small"}
    assert made[0].overrides == {"fleet.size": 2, "battery.capacity": 8}
    assert made[1].overrides == {}


def test_run_seeds_differ_between_replications_and_studies_and_are_exact_floats():
    seeds = [run_seed(study, replication) for study in range(30) for replication in range(100)]
    assert len(set(seeds)) == len(seeds)
    assert all(int(float(seed)) == seed for seed in seeds)
    assert run_seed(0, 0) == 276170154685457  # golden: another value makes all stored runs useless


def test_a_problem_elsewhere_in_a_changed_model_is_one_of_its_design():
    """Robots have hours by a calendar that is taken away. A design that a search adds is in no study file."""
    base = dw.load("models/tutorial.yaml", {"calendars.shift": {"every": 1000, "lasts": 800}, "fleet.hours": "shift"})
    without = {"hours": {"cases": {"none": {"calendars": {}}}}}
    with pytest.raises(ModelError, match=r"^study: design hours=none: .*fleet\.hours: no such calendar"):
        dw.Study(base, without)
    plan = dw.Study(base, {"fleet.size": [1]}).plan
    with pytest.raises(ModelError, match=r"^design hours=none: .*fleet\.hours: no such calendar"):
        models(plan, [Point(1, {"hours": "none"}, {"calendars": {}}, {})])
