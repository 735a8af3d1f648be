"""A Gymnasium environment for learning allocation (extra `rl`): one free robot at a time chooses an open task."""

from __future__ import annotations

from typing import Any

import numpy as np

from desim_warehouse.learn.asktell import Steps

try:
    import gymnasium
    from gymnasium import spaces
except ModuleNotFoundError as error:
    raise ImportError(f"learning needs {error.name}; pip install 'desim-warehouse[rl]'") from None


from collections.abc import Mapping

from desim_warehouse.errors import ModelError, shown
from desim_warehouse.learn.asktell import Decision
from desim_warehouse.model import Source, as_model
from desim_warehouse.policies import RobotView, Task
from desim_warehouse.values.arguments import is_finite, is_whole

FEATURES = 5
FAR = 1e6


class AllocationEnv(gymnasium.Env[Any, Any]):
    """An environment in which each free robot, lowest number first, takes one of the first `slots` open tasks, or none.

    Action: the index of a task from 0 to slots - 1, or slots for no task at present. An empty slot, or a task that the
    robot may not take, counts as no task. If no free robot takes a task and all robots are free, the first feasible
    pair is assigned, so that episodes end. `info["action_mask"]` marks the actions that have an effect.

    Observation: `robot`, of shape (3,): energy (share of the capacity), free robots (share of the fleet), open tasks
    (per slot); and `tasks`, of shape (slots, 5): present (0 or 1), feasible (0 or 1), time to the good, time of the
    delivery, age; times are divided by `scale`.

    Reward: minus the increase of Cost_total (section `cost` of the model: distance, time, collisions) since the last
    decision, divided by `scale`; it is never positive. The rewards of an episode sum to minus the cost of the whole
    run, divided by `scale`. With `run.warm_up` this includes the warm-up, which `info["kpis"]["cost"]` leaves out.

    Args:
        model: a Model, its content as a mapping, or the path of a model file.
        overrides: as for `load`.
        slots: number of open tasks shown, from the front of the list.
        scale: divisor of times and costs.

    Raises:
        ModelError: no model, or `slots` or `scale` that are no numbers above 0.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - as gymnasium declares it

    def __init__(
        self,
        model: Source,
        overrides: Mapping[str, Any] | None = None,
        *,
        slots: int = 10,
        scale: float = 1000.0,
    ) -> None:
        if not is_whole(slots, 1):
            raise ModelError([f"slots {shown(slots):.60}: expected a whole number above 0"])
        if not (is_finite(scale) and scale > 0):
            raise ModelError([f"scale {shown(scale):.60}: expected a number above 0"])
        self.model = as_model(model, {**(overrides or {}), "log": "tasks"})
        self.slots = slots
        self.scale = scale
        self.action_space = spaces.Discrete(slots + 1)
        self.observation_space = spaces.Dict(
            {
                "robot": spaces.Box(-FAR, FAR, (3,), np.float32),
                "tasks": spaces.Box(-FAR, FAR, (slots, FEATURES), np.float32),
            }
        )
        self._steps: Steps | None = None
        self._decision: Decision | None = None
        self._robots: list[RobotView] = []
        self._tasks: list[Task] = []
        self._cost = 0.0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin a run; its seed is drawn from the generator seeded with `seed`, so that episodes differ."""
        super().reset(seed=seed, options=options)
        self._steps = Steps(self.model, int(self.np_random.integers(2**31)))
        self._cost = 0.0
        self._next_decision()
        return self._observation(), self._info()

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Assign the chosen task to the current robot, and continue to the next robot or decision."""
        assert self._decision is not None, "reset() comes first"
        robot = self._robots.pop(0)
        if self._mask(robot)[int(action)] and action < self.slots:
            self._decision.assign(robot, self._tasks.pop(int(action)))
        if not self._robots or not self._tasks:
            self._settle()
        reward = -self._increase() / self.scale
        return self._observation(), reward, self._decision is None, False, self._info()

    # Inside

    def _settle(self) -> None:
        """Answer the pending decision; if all robots are free and none takes a task, assign a feasible pair."""
        decision, steps = self._decision, self._steps
        assert decision is not None
        assert steps is not None
        if not decision.answer and len(decision.robots) == self.model.fleet.size:
            pairs = ((robot, task) for robot in decision.robots for task in decision.tasks)
            first = next((pair for pair in pairs if decision.feasible(*pair)), None)
            if first is not None:
                decision.assign(*first)
        self._next_decision()

    def _next_decision(self) -> None:
        assert self._steps is not None
        self._decision = next(self._steps, None)
        self._robots = [] if self._decision is None else list(self._decision.robots)
        self._tasks = [] if self._decision is None else list(self._decision.tasks)

    def _increase(self) -> float:
        assert self._steps is not None
        cost = self.model.cost.total(*self._steps.cost_so_far())
        increase, self._cost = cost - self._cost, cost
        return increase

    def _mask(self, robot: RobotView) -> Any:
        mask = np.zeros(self.slots + 1, dtype=np.int8)
        mask[self.slots] = 1
        assert self._decision is not None
        for slot, task in enumerate(self._tasks[: self.slots]):
            mask[slot] = self._decision.feasible(robot, task)
        return mask

    def _info(self) -> dict[str, Any]:
        if self._decision is None:
            assert self._steps is not None
            return {"action_mask": np.ones(self.slots + 1, dtype=np.int8), "kpis": self._steps.run.kpis}
        return {"action_mask": self._mask(self._robots[0]), "time": self._decision.time}

    def _observation(self) -> dict[str, Any]:
        robot, tasks = np.zeros(3, np.float32), np.zeros((self.slots, FEATURES), np.float32)
        if self._decision is not None:
            view, shown = self._robots[0], self._tasks[: self.slots]
            battery = view.energy / view.capacity if np.isfinite(view.capacity) else 1.0
            robot[:] = battery, len(self._robots) / self.model.fleet.size, len(self._tasks) / self.slots
            situation, rows = self._decision.situation, slice(0, len(shown))
            tasks[rows, 0] = 1
            tasks[rows, 1] = self._mask(view)[: len(shown)]
            tasks[rows, 2] = situation.approach([view], shown)[0] / self.scale
            tasks[rows, 3] = situation.delivery(view, shown) / self.scale
            tasks[rows, 4] = [(self._decision.time - task.release) / self.scale for task in shown]
        return {"robot": robot.clip(-FAR, FAR), "tasks": tasks.clip(-FAR, FAR)}
