"""`desim plan` with several targets: a fleet has to meet all of them."""

import json

import pytest

import desim_warehouse as dw
from desim_warehouse.questions.plan import plan_fleet
from desim_warehouse.questions.plan.options import plan_options
from tests.docs import pages
from tests.study.test_fewer_robots import FLOW, RING, SEARCH, ring  # noqa: F401  a fixture

pytestmark = pytest.mark.usefixtures("brief_probes")

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


def test_size_is_the_plan_of_one_key_with_several_targets_too(ring, both):  # noqa: F811
    sized = dw.size(dw.Study(ring, {"fleet.size": [1, 2, 3, 4]}), [IN_TIME, SHORT], search=SEARCH)
    assert sized.smallest == both.today.best.robots
    assert sized.today.best.verdict.each == both.today.best.verdict.each
    assert sized.answer.answer[0] == f"{sized.smallest} robots are the smallest fleet shown to be enough."
    assert sized.answer.answer[1:3] == both.answer.answer[1:3]
    assert sized.answer.question == (
        "What is the smallest number of robots that gives at least 30 % on time and mean cycle time at most 1.5 min?"
    )


def test_a_key_that_is_no_fleet_is_sized_in_its_own_words(ring):  # noqa: F811
    """Two robots drive 80 for an order: at 0.2 a second that alone is 400 s, at 1 a second 80."""
    speeds = dw.Study(ring.replace({"fleet.size": 2}), {"fleet.robot.speed": [0.2, 0.3, 1.0]})
    slow, fast = (dw.size(speeds, f"cycle_time_mean <= {most}", scan=True, search=SEARCH) for most in (10, 120))
    assert (slow.smallest, slow.feasible) == (None, False)
    assert slow.answer.answer[0].startswith("No value is enough. Speed 1: mean cycle time ")
    assert fast.smallest == 1.0
    assert fast.answer.answer[0].startswith("Speed 1 is the smallest value shown to be enough: mean cycle time ")
    assert [option.name for option in fast.answer.options] == ["speed 0.2", "speed 0.3", "speed 1"]
    assert [option.set["fleet.robot.speed"] for option in fast.answer.options] == [0.2, 0.3, 1.0]
    assert "never does worse" not in fast.answer.promise
    assert fast.answer.figure.at == 120


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
    status, _, err = pages.run_desim(f"desim plan {model} {twice} --uncertain tasks.load_time=2..9 --quiet")[:3]
    assert (status, err.splitlines()[-1]) == (2, "Error: --option and --uncertain: with one --target alone")
    status, _, err = pages.run_desim(f"desim what-if {model} {twice} --vary fleet.size=1,2 --quiet")[:3]
    assert (status, err.splitlines()[-1]) == (2, "Error: --target: typed twice, expected once")
