"""Ask and tell, and the Gymnasium environment made from it."""

import numpy as np
import pytest

import desim_warehouse as dw
from desim_warehouse import PolicyError, StallError
from tests.world.ring import RING

MODEL = dw.load("models/multibots.yaml", {"tasks.goods": [11, 8, 39, 28, 53, 1, 69, 42, 79, 6, 3, 4]})


def answered(decision):
    for robot, task in zip(decision.robots, decision.tasks, strict=False):
        if decision.feasible(robot, task):
            decision.assign(robot, task)


def test_answers_from_outside_give_the_run_that_the_same_policy_gives():
    steps = dw.steps(MODEL, 4)
    for decision in steps:
        answered(decision)
    assert steps.run.record.rows == dw.simulate(MODEL, 4).record.rows
    assert steps.run.T == dw.simulate(MODEL, 4).T


def test_answers_may_be_told_instead():
    from desim_warehouse.policies import create

    policy = create("allocation", "nearest", {})
    steps = dw.steps(MODEL)
    for decision in steps:
        steps.tell(policy.assign(decision.situation))
    other = dw.simulate(MODEL.replace({"policies.allocation": "nearest"}))
    assert steps.run.record.rows == other.record.rows


def test_a_lifelong_run_ends_at_its_length():
    steps = dw.steps(MODEL.replace({"tasks.goods": {"saturated": 5}, "run.length": 3000}))
    times = []
    for decision in steps:
        times.append(decision.time)
        answered(decision)
    assert times == sorted(times)
    assert times[-1] < 3000
    assert steps.run.T == 3000


def test_faults_are_named():
    steps = dw.steps(MODEL)
    with pytest.raises(PolicyError, match="not over"):
        _ = steps.run
    with pytest.raises(PolicyError, match="no decision is pending"):
        steps.tell([])
    decision = next(steps)
    decision.assign(0, 99)
    with pytest.raises(PolicyError, match=r"allocation \(the answer\) at time 0: task 99 is not open"):
        next(steps)
    steps = dw.steps(MODEL)
    next(steps).assign(None, 0)
    with pytest.raises(PolicyError, match=r"\(None, 0\) is no pair \(robot number, task number\)"):
        next(steps)


def rows_after(steps):
    """The log of a run whose decisions are answered from here on."""
    for decision in steps:
        answered(decision)
    return steps.run.record.rows


@pytest.mark.parametrize(
    "refused",
    [
        [(0, 999)],
        [(0, 0), (1, 1), (0, 999)],  # two that could be carried out come first
        [(0, 0), (1, 1), (99, 2)],
        [(0, 0), (1, 1), (2, 0)],
        [(0, 0), (1, 1), "two"],
    ],
)
def test_a_refused_answer_changes_nothing_and_can_be_given_anew(refused):
    steps = dw.steps(MODEL, 4)
    decision = next(steps)
    with pytest.raises(PolicyError, match="at time 0"):
        steps.tell(refused)
    answered(decision)
    assert rows_after(steps) == dw.simulate(MODEL, 4).record.rows


def test_a_refused_assignment_is_forgotten_and_the_decision_can_be_answered_anew():
    steps = dw.steps(MODEL, 4)
    decision = next(steps)
    decision.assign(0, 99)
    with pytest.raises(PolicyError, match="task 99 is not open"):
        next(steps)
    answered(decision)
    assert rows_after(steps) == dw.simulate(MODEL, 4).record.rows


def test_numbers_of_numpy_are_numbers_of_robots_and_tasks():
    decision = next(dw.steps(MODEL))
    decision.assign(np.int64(0), decision.tasks[1])
    decision.assign(decision.robots[1], np.uint8(0))
    assert decision.answer == [(0, 1), (1, 0)]


def test_no_answers_at_all_end_in_a_stall_that_says_so():
    with pytest.raises(StallError, match=r"0 of 12 tasks are done"):
        for _ in dw.steps(MODEL):
            pass


def test_the_environment_passes_gymnasiums_own_check():
    checker = pytest.importorskip("gymnasium.utils.env_checker")
    from desim_warehouse.learn.rl import AllocationEnv

    checker.check_env(AllocationEnv(MODEL, {"tasks.goods": {"random": 8}}), skip_render_check=True)


def test_the_environment_takes_a_model_its_content_or_its_file():
    pytest.importorskip("gymnasium")
    from desim_warehouse.learn.rl import AllocationEnv

    path = "models/multibots.yaml"
    given = (path, dw.load(path), dw.load(path).content())
    models = [AllocationEnv(model, {"fleet.size": 3}).model for model in given]
    assert models == [dw.load(path, {"fleet.size": 3, "log": "tasks"})] * 3


@pytest.mark.parametrize("number", [0, -1, float("nan"), "many", None, True])
def test_the_environment_needs_slots_and_a_scale(number):
    pytest.importorskip("gymnasium")
    from desim_warehouse.learn.rl import AllocationEnv

    with pytest.raises(dw.ModelError, match=r"^slots .*: expected a whole number above 0$"):
        AllocationEnv(MODEL, slots=number)
    with pytest.raises(dw.ModelError, match=r"^scale .*: expected a number above 0$"):
        AllocationEnv(MODEL, scale=number)


@pytest.mark.parametrize("choice", ["first", "none", "random"])
def test_an_episode_ends_and_its_rewards_sum_up_to_minus_the_cost(choice):
    pytest.importorskip("gymnasium")
    from desim_warehouse.learn.rl import AllocationEnv

    env = AllocationEnv("models/multibots.yaml", {"tasks.goods": {"random": 15}, "fleet.size": 3}, slots=6)
    observation, info = env.reset(seed=5)
    env.action_space.seed(5)
    total, over = 0.0, False
    while not over:
        assert env.observation_space.contains(observation)
        action = {"first": 0, "none": 6, "random": int(env.action_space.sample(info["action_mask"]))}[choice]
        observation, reward, over, _, info = env.step(action)
        total += reward
    assert info["kpis"]["tasks"] == 15
    assert total * env.scale == pytest.approx(-info["kpis"]["cost"])


def test_rewards_count_the_warm_up_too_and_are_never_positive():
    """Cost counts time alone: a run of 300 costs 300, of which indicators leave out a warm-up of 120."""
    pytest.importorskip("gymnasium")
    from desim_warehouse.learn.rl import AllocationEnv

    changes = {"fleet.size": 1, "tasks.goods": {"saturated": 1}, "run": {"length": 300, "warm_up": 120}}
    env = AllocationEnv(dw.load(RING, {**changes, "cost": {"distance": 0, "time": 1, "collisions": 0}}), scale=1)
    env.reset(seed=1)
    rewards, over = [], False
    while not over:
        _, reward, over, _, info = env.step(0)
        rewards.append(reward)
    assert max(rewards) <= 0
    assert sum(rewards) == pytest.approx(-300)
    assert info["kpis"]["cost"] == pytest.approx(300 - 120)
