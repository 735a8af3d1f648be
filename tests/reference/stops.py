"""Waits in traffic, one by one: here beside the stepped reference.

S differs more than T. Of the waits of both models in one experiment those of the same robot at the same time are the
same; of the others it counts how long they last.
"""

from collections import Counter, defaultdict
from itertools import chain
from typing import NamedTuple

import desim_warehouse as dw
from tests.reference import stepped

NEAR = 4
"""Steps by which waits that are the same may be apart."""
SHORT = 2
"""Steps up to which a wait is short: a robot has moved by a quarter of D in two."""
SAME = 3
"""Steps by which T of experiments may differ in which the robots do the same in both models."""


class Wait(NamedTuple):
    """One wait of a robot, in steps."""

    robot: int
    start: float
    end: float

    @property
    def is_short(self):
        return self.end - self.start <= SHORT

    def is_near(self, other):
        """Whether it may be another's in the other model."""
        return self.robot == other.robot and self.start - NEAR <= other.end and other.start <= self.end + NEAR


class Watched(stepped.Warehouse):
    """The stepped reference with its waits."""

    def __init__(self, setting):
        self.waits = defaultdict(list)
        super().__init__(setting)

    def wait_for(self, robot, other):
        if other and not robot.waits_for:
            self.waits[robot.number].append(Wait(robot.number, self.now, self.now))
        elif robot.waits_for and not other:
            self.waits[robot.number][-1] = self.waits[robot.number][-1]._replace(end=self.now)
        super().wait_for(robot, other)


def waits(run):
    """Those of a run with `log: all`."""
    rows = (row for row in run.record.rows if row[1] == "collision")
    return [Wait(row[2], row[0] - row[6], row[0]) for row in rows]


class Unmatched(NamedTuple):
    """Waits without a counterpart in the other model, here and in the reference: short ones, and longer ones."""

    here: int
    here_longer: int
    stepped: int
    stepped_longer: int


def unmatched(experiments):
    """Over experiments, given as a model and a setting each, and how many of them count: those with the same T."""
    counts, same = Counter(), 0
    for model, setting in experiments:
        run, reference = dw.simulate(model.replace({"log": "all"})), Watched(setting)
        if abs(run.T - reference.run().T) > SAME:
            continue
        same += 1
        ours, theirs = waits(run), list(chain.from_iterable(reference.waits.values()))
        for side, these, others in (("here", ours, theirs), ("stepped", theirs, ours)):
            for wait in these:
                if not any(wait.is_near(other) for other in others):
                    counts[side, wait.is_short] += 1
    sides = ((side, short) for side in ("here", "stepped") for short in (True, False))
    return same, Unmatched(*(counts[one] for one in sides))
