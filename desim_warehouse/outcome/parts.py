"""Parts of a run, for indicators such as `on_time@11:30-13:00`: the tasks of one flow, or of one part of the day."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import cached_property
from operator import itemgetter

from desim_warehouse.model.facts.day_parts import parts_of_the_day
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.records import Deadline, TaskHistory
from desim_warehouse.values.calendars import Stretch


class PartHistory:
    """A part of the tasks of a run, with the properties of `History`, and a part of its time (`stretches`)."""

    def __init__(
        self, history: History, belongs: Callable[[TaskHistory], bool], stretches: Sequence[Stretch] | None = None
    ) -> None:
        """Select tasks by `belongs`; `stretches` are disjoint and in order, by default the evaluation period."""
        self.history = history
        self.stretches = history.stretches if stretches is None else stretches
        self._belongs = belongs
        self.hours = history.counted / history.model.units.hour

    @cached_property
    def tasks(self) -> dict[int, TaskHistory]:
        """The tasks of this part by number."""
        return {number: task for number, task in self.history.tasks.items() if self._belongs(task)}

    @cached_property
    def done(self) -> list[TaskHistory]:
        """The tasks of this part that were done."""
        return list(filter(self._belongs, self.history.done))

    @cached_property
    def counted_deliveries(self) -> list[TaskHistory]:
        """The tasks of this part delivered in the evaluation period."""
        return [task for task in self.history.delivered if self._belongs(task) and self.history.counts(task.delivered)]

    @cached_property
    def cycle_times(self) -> list[float]:
        """The cycle times of the tasks of this part done in the evaluation period, shortest first."""
        return sorted(task.cycle_time for task in self.done if self.history.counts(task.done))

    @cached_property
    def deadlines(self) -> list[Deadline]:
        """The deadlines of the tasks of this part in the evaluation period, in order of time."""
        return self.history.falling_due(task.deadline for task in self.tasks.values())

    @cached_property
    def put_down(self) -> list[TaskHistory]:
        """The tasks of this part whose load units were put down at stations with workers."""
        return list(filter(self._belongs, self.history.put_down))

    @cached_property
    def work_deadlines(self) -> list[Deadline]:
        """The deadlines of the work on load units of this part in the evaluation period, in order of time."""
        return self.history.falling_due(task.work_deadline for task in self.history.for_workers if self._belongs(task))


def of_flow(history: History, flow: str) -> PartHistory:
    """Return the tasks of one flow as a part of the run."""
    return PartHistory(history, lambda task: task.flow == flow)


def by_day_part(history: History) -> dict[str, PartHistory]:
    """Return each part of the day (`parts_of_the_day`) in which tasks arrive, by name, with these tasks."""
    named = parts_of_the_day(history.model)
    if not named:
        return {}
    stretches = sorted((*stretch, name) for name, spans in named.items() for stretch in spans)
    part_of: dict[int, str] = {}
    for number, task in history.tasks.items():
        place = bisect_right(stretches, task.released, key=itemgetter(0)) - 1
        if place >= 0 and task.released < stretches[place][1]:
            part_of[number] = stretches[place][2]

    def part(name: str) -> PartHistory:
        return PartHistory(history, lambda task: part_of.get(task.number) == name, named[name])

    asked_for = set(part_of.values())
    return {name: part(name) for name in named if name in asked_for}
