"""Ask and tell: runs that stop at every allocation decision, which the caller makes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Self, SupportsIndex

from desim_warehouse.errors import PolicyError
from desim_warehouse.model import Source, as_model
from desim_warehouse.policies import RobotView, Situation, Task
from desim_warehouse.questions.run import Run


class Decision:
    """A pending allocation decision: free `robots` and open `tasks`; answer it with `assign` or `Steps.tell`."""

    def __init__(self, situation: Situation) -> None:
        self.situation = situation
        self.time = situation.time
        self.robots: Sequence[RobotView] = situation.robots
        self.tasks: Sequence[Task] = tuple(situation.tasks)
        self.answer: list[tuple[SupportsIndex, SupportsIndex]] = []

    def feasible(self, robot: RobotView, task: Task) -> bool:
        """Whether the charging policy allows the robot to take the task, and the station has a free slot."""
        return self.situation.feasible(robot, task)

    def assign(self, robot: RobotView | SupportsIndex, task: Task | SupportsIndex) -> None:
        """Assign a task to a robot, by views or numbers; robots and tasks that are not assigned stay free and open."""
        self.answer.append(
            (
                robot.number if isinstance(robot, RobotView) else robot,
                task.number if isinstance(task, Task) else task,
            )
        )

    def __repr__(self) -> str:
        return f"Decision(time={self.time:g}, {len(self.robots)} free robots, {len(self.tasks)} open tasks)"


class Steps:
    """An iterator over the decisions of a run: `for decision in steps(model, seed): decision.assign(robot, task)`.

    After the last decision, `run` is the outcome. The model's allocation policy is not used; everything else happens
    as in the model. A robot that has unloaded and gets no task goes to a bay.

    Raises:
        PolicyError: an answer that cannot be carried out; the decision stays pending.
        StallError: work is left, and no event is scheduled.
    """

    def __init__(self, model: Source, seed: int = 0) -> None:
        from desim_warehouse.world import World

        self._model = as_model(model)
        self._seed = seed
        self._world = World(self._model, seed, ask=True)
        self._world.begin()
        self._pending: Decision | None = None
        self._run: Run | None = None

    def __iter__(self) -> Iterator[Decision]:
        return self

    def __next__(self) -> Decision:
        if self._pending is not None:
            answer, self._pending.answer = self._pending.answer, []  # a refused answer can be given anew
            self.tell(answer)
        if self._run is not None or not self._world.go_on():
            self._run = self._run or self._outcome()
            raise StopIteration
        self._pending = Decision(self._world.dispatcher.situation())
        return self._pending

    def tell(self, pairs: Iterable[tuple[SupportsIndex, SupportsIndex]]) -> Self:
        """Answer the pending decision with pairs (robot number, task number).

        Raises PolicyError if no decision is pending, or if the answer cannot be carried out. Nothing of such an answer
        is carried out, and the decision stays pending; a fault of another policy of the model ends the run.
        """
        if self._pending is None:
            raise PolicyError("steps: no decision is pending; next() gives the next one")
        self._world.dispatcher.decide(pairs)
        self._pending = None
        return self

    @property
    def run(self) -> Run:
        """The outcome, after the last decision; raises PolicyError before."""
        if self._run is None:
            raise PolicyError("steps: the run is not over; answer its decisions until there are none")
        return self._run

    def cost_so_far(self) -> tuple[float, float, int]:
        """Return the distance driven by all robots, the time, and the number of collisions so far, in model units."""
        now = self._world.env.now
        robots = self._world.robots
        return (
            math.fsum(robot.body.distance(now) for robot in robots),
            now,
            sum(robot.body.rear_ends_by(now) + robot.body.crossings for robot in robots),
        )

    def _outcome(self) -> Run:
        from desim_warehouse.questions.run import Run

        return Run(self._model, self._seed, self._world.log, self._world.layout)


def steps(model: Source, seed: int = 0) -> Steps:
    """Begin a run whose allocation decisions are made by the caller; equal decisions give equal logs.

    Returns:
        An iterator over the decisions; after the last decision its `run` is the outcome.

    Raises:
        LayoutError: a layout on which work could stop for good.
        CheckError: any other error that `check` finds and the model does not accept.
    """
    return Steps(model, seed)
