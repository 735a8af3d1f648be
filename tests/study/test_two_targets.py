"""`desim plan` with several targets: a fleet has to meet all of them."""

import json

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.plan import plan_fleet
from desim_warehouse.questions.plan_options import plan_options
from tests.docs import pages
from tests.study.test_fewer_robots import FLOW, RING, SEARCH, ring  # noqa: F401  a fixture

HOW = {"robots": "1..4", "strategies": {}, "search": SEARCH}
IN_TIME, SHORT = "on_time >= 30 %", "cycle_time_mean <= 90"


@pytest.fixture(scope="module")
def both(ring):  # noqa: F811
    return plan_fleet(ring, [IN_TIME, SHORT], **HOW)


def test_the_fleet_for_both_is_the_larger_of_those_for_each(ring, both):  # noqa: F811
    """One robot has 56 % on time in 156 s on the mean, two have 97 % in 78 s, as so has any number more."""
    alone = [plan_fleet(ring, target, **HOW).today.best.robots for target in (IN_TIME, SHORT)]
    assert both.today.best.robots == max(alone)
    assert alone[0] < alone[1]  # so that the second one counts
    assert [one.verdict for one in both.today.best.verdict.each] == ["meets", "meets"]


def test_the_answer_has_a_line_for_each_target_and_the_table_a_column(both):
    first, *lines = both.answer.answer
    robots = both.today.best.robots
    assert first == f"{robots} robots are the smallest fleet shown to be enough today (30 an hour)."
    assert lines[0].startswith(f"{robots} robots, at least 30 % on time: ")
    assert lines[1].startswith(f"{robots} robots, mean cycle time at most 1.5 min: ")
    assert all(line.endswith(", met.") for line in lines[:2])
    assert all(len(option.numbers) == 2 for option in both.answer.options)
    assert "at least 30 % on time and mean cycle time at most 1.5 min" in both.answer.question
    assert "by 1 % and 0.9 s or more" in both.answer.promise
    facts = json.loads(both.answer.model_dump_json())
    assert [one["indicator"] for one in facts["targets"]] == ["on_time", "cycle_time_mean"]


def test_targets_that_no_fleet_meets_together(ring):  # noqa: F811
    sizes = plan_fleet(ring, [SHORT, "share_idle <= 30 %"], **HOW)
    assert not sizes.feasible
    assert sizes.answer.answer[0].startswith(
        "Today (30 an hour): no fleet is shown to be enough for all targets. This is what "
    )
    assert sizes.answer.answer[-1].endswith("not met.")


@pytest.mark.parametrize(
    ("targets", "how", "message"),
    [
        ([IN_TIME, "on_time >= 90 %"], {}, "a second bound on on_time, expected the stricter one alone"),
        ([IN_TIME, SHORT], {"zone": "2 %"}, "--zone 2 %: for one target alone"),
        ([], {}, "target: none"),
        ([IN_TIME, 5], {}, "target 5: expected words such as"),
    ],
)
def test_what_cannot_be_asked_is_refused(ring, targets, how, message):  # noqa: F811
    with pytest.raises(dw.StudyError, match=message):
        plan_fleet(ring, targets, **HOW, **how)


def test_what_takes_one_target_refuses_several(ring, tmp_path):  # noqa: F811
    with pytest.raises(dw.StudyError, match="expected words such as"):
        plan_options({"A": ring, "B": ring}, [IN_TIME, SHORT])
    model = tmp_path / "ring.yaml"
    model.write_text(json.dumps(RING | {"tasks": RING["tasks"] | {"flows": {"out": FLOW}}, "run": {"length": 1800}}))
    twice = f'--target "{IN_TIME}" --target "{SHORT}"'
    status, _, said = pages.run_desim(f"desim plan {model} {twice} --uncertain tasks.load_time=2..9 --quiet")[:3]
    assert (status, said.splitlines()[-1]) == (2, "Error: --option and --uncertain: with one --target alone")
    status, _, said = pages.run_desim(f"desim what-if {model} {twice} --vary fleet.size=1,2 --quiet")[:3]
    assert (status, said.splitlines()[-1]) == (2, "Error: --target: typed twice, expected once")
