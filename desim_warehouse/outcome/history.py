"""The history of a run, read from its log by the only module that interprets rows.

`History` holds tasks, states, waits, energy and rotations as named records, each read from the rows when it is first
needed. Indicators, figures, replay and exports are made from these records. `History.rows` yields the rows themselves,
by the names of their columns.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator
from functools import cached_property
from itertools import islice, zip_longest
from operator import attrgetter
from typing import Any, TypeAlias

from desim_warehouse.errors import ReportError
from desim_warehouse.layout import Layout
from desim_warehouse.layout.spec import StationSpec
from desim_warehouse.model import Model
from desim_warehouse.model.facts import charging
from desim_warehouse.model.facts.charging import by_kind, chargers_at, start_levels
from desim_warehouse.model.sections.fleet import BatterySpec, Start
from desim_warehouse.outcome.log import KINDS, NONE, PLACES, STATES, Log, LogRow
from desim_warehouse.outcome.records import (
    Assignment,
    Blocked,
    ChargeSpan,
    Deadline,
    Edge,
    OrderHistory,
    PickerSpan,
    Rotation,
    StateSpan,
    TaskHistory,
    Trip,
    Wait,
    Whereabouts,
)
from desim_warehouse.states import APART, AT_START, CHARGER, SERVED, TOO_LOW, WAITING, Phase, names
from desim_warehouse.values.calendars import Stretch
from desim_warehouse.values.streams import Streams

Curve: TypeAlias = tuple[list[float], list[float]]

_MOTION = frozenset(kind for kind, row in KINDS.items() if row.level != "tasks")
_DRIVING = names(lambda state: state.phase in {Phase.TO_GOOD, Phase.TO_STATION, Phase.TO_BAY})
_LOADING = names(lambda state: state.phase is Phase.LOADING)
_LOADED = names(lambda state: state.phase is Phase.TO_STATION)
_end_of, _due_of = attrgetter("end"), attrgetter("due")
_CURVE = 16
"""Number of linear pieces of a curved charge."""

Spans = tuple[list[int], list[float]]
"""The number of tasks done in each of several equal spans of time, and the sum of their cycle times in each."""


def _blocked(row: LogRow, end: float) -> Blocked:
    assert row.edge is not None
    return Blocked(row.edge, row.time, end, NONE if row.value is None else int(row.value))


class History:
    """The history of a run, from its start at 0 to `end`.

    Indicators count from `begin`, the end of the warm-up.
    """

    def __init__(self, log: Log, model: Model, layout: Layout, seed: int) -> None:
        self.log = log
        self.model = model
        self.layout = layout
        self.seed = seed
        self.begin: float = log.begin
        self.end: float = log.end

    def rows(self, *kinds: str) -> Iterator[LogRow]:
        """Iterate over the rows of some kinds, or over all rows if no kind is named, in order of time."""
        if not kinds:
            return map(LogRow._make, self.log.rows)
        rows = self._work if _MOTION.isdisjoint(kinds) else self.log.rows
        return map(LogRow._make, [row for row in rows if row[1] in kinds])

    @cached_property
    def _work(self) -> list[tuple[Any, ...]]:
        """The rows of tasks, states and rotations, which are few compared with the rows of moves and waits."""
        return [row for row in self.log.rows if row[1] not in _MOTION]

    # What is counted

    @property
    def history(self) -> History:
        """The history itself, as `PartHistory.history` is the history of the whole run."""
        return self

    def since(self, begin: float) -> History:
        """Return the run's history with the evaluation period beginning at `begin`; itself if it already does."""
        if begin == self.begin:
            return self
        other = History(self.log, self.model, self.layout, self.seed)
        other.begin = begin
        return other

    @property
    def counted(self) -> float:
        """The length of the evaluation period (the counted time), from the end of the warm-up to the end of the run."""
        return self.end - self.begin

    @property
    def stretches(self) -> list[Stretch]:
        """The evaluation period as one stretch; a part of the day has one stretch on each day."""
        return [(self.begin, self.end)]

    def counts(self, time: float) -> bool:
        """Whether an event at a time is counted: from the end of the warm-up, this instant included."""
        return time >= self.begin

    def within(self, start: float, end: float) -> float:
        """Return how much of an interval is counted."""
        return max(min(end, self.end) - max(start, self.begin), 0.0)

    @cached_property
    def totals(self) -> dict[str, float]:
        """The tallies of all robots together (see `Run.robots`), in the evaluation period."""
        return {key: math.fsum(robot[key] for robot in self.log.robots) for key in self.log.robots[0]}

    # Tasks

    @cached_property
    def workplaces(self) -> dict[str, StationSpec]:
        """The stations in which load units are worked on, by node."""
        specs = {node: self.model.layout.stations[item.zone] for node, item in self.layout.stations.items()}
        return {node: spec for node, spec in specs.items() if spec.work_time is not None}

    @cached_property
    def for_workers(self) -> list[TaskHistory]:
        """The tasks whose load units are worked on in a station, in order of release."""
        return [self.tasks[number] for number in sorted(self._for_workers)]

    @cached_property
    def _for_workers(self) -> Collection[int]:
        if self.log.for_workers is not None:
            return self.log.for_workers
        # Logs before 0.4.0 do not record it: all load units put down at a node with such a station count as for it.
        return {row.task for row in self.rows("delivered") if row.node in self.workplaces}

    @cached_property
    def _tasks(self) -> tuple[dict[int, TaskHistory], list[TaskHistory], list[TaskHistory]]:
        """All tasks by number, the delivered tasks in order of delivery, and the done tasks in order of completion."""
        tasks: dict[int, TaskHistory] = {}
        delivered: list[TaskHistory] = []
        done: list[TaskHistory] = []
        until_worked = self._for_workers if self.model.tasks.done_when == "worked" else ()
        loading: set[int] = set()
        for row in self.rows("released", "batched", "delivered", "working", "worked", *_LOADING, *_LOADED):
            if row.kind == "released":
                due, flow = self.log.due.get(row.task), self.log.flows.get(row.task, "")
                order = self.log.orders.get(row.task, "")
                tasks[row.task] = TaskHistory(row.task, int(row.value or 0), row.time, due, flow=flow, order=order)
            elif row.kind == "batched":
                tasks[row.task].batched = row.time
            elif row.kind in _LOADING:
                loading.add(row.robot)
            elif row.kind in _LOADED:
                if row.robot in loading:  # else the robot drives on after a stop on its way or a breakdown
                    loading.remove(row.robot)
                    tasks[row.task].loaded = row.time
            elif row.kind == "working":
                tasks[row.task].begun = row.time
            else:
                task, node = tasks[row.task], row.node or ""
                if row.kind == "worked":
                    task.worked = row.time
                else:
                    task.delivered, task.station, task.stored = row.time, node, row.edge is not None
                    delivered.append(task)
                if (row.task in until_worked) == (row.kind == "worked"):
                    task.done = row.time
                    done.append(task)
        return tasks, delivered, done

    @property
    def tasks(self) -> dict[int, TaskHistory]:
        """All tasks by number, in order of release."""
        return self._tasks[0]

    @property
    def delivered(self) -> list[TaskHistory]:
        """The tasks that were delivered, in order of delivery, the warm-up included."""
        return self._tasks[1]

    @property
    def done(self) -> list[TaskHistory]:
        """The tasks that were done (see `TaskHistory`), in order of completion, the warm-up included."""
        return self._tasks[2]

    @cached_property
    def put_down(self) -> list[TaskHistory]:
        """The tasks whose load units were put down in a station with workers, in order of delivery."""
        return [task for task in self.delivered if task.number in self._for_workers]

    @cached_property
    def counted_deliveries(self) -> list[TaskHistory]:
        """The tasks that were delivered in the evaluation period, in order of delivery."""
        return [task for task in self.delivered if self.counts(task.delivered)]

    @cached_property
    def counted_done(self) -> list[TaskHistory]:
        """The tasks that were done in the evaluation period, in order of completion."""
        return [task for task in self.done if self.counts(task.done)]

    @cached_property
    def cycle_times(self) -> list[float]:
        """The cycle times of the tasks done in the evaluation period, shortest first."""
        return sorted(task.cycle_time for task in self.counted_done)

    @cached_property
    def ended_with_its_work(self) -> bool:
        """Whether the run ended before its length was over because all its work was done."""
        if self.log.finished is None:
            never_ends, cut = self.model.tasks.never_end, self.end >= self.model.run.end
            return not never_ends and not cut and len(self.done) == len(self.tasks)
        return self.log.finished

    def falling_due(self, deadlines: Iterable[Deadline | None]) -> list[Deadline]:
        """Return the deadlines in the evaluation period, ends included, in order of time, whether met, missed or open.

        If the run ended with its work, met deadlines after its end are included.
        """
        later = self.ended_with_its_work
        counted = (deadline for deadline in deadlines if deadline is not None and self.counts(deadline.due))
        return sorted(
            (deadline for deadline in counted if deadline.due <= self.end or (later and not deadline.missed)),
            key=_due_of,
        )

    @cached_property
    def deadlines(self) -> list[Deadline]:
        """The deadlines of tasks in the evaluation period, in order of time."""
        return self.falling_due(task.deadline for task in self.tasks.values())

    @cached_property
    def work_deadlines(self) -> list[Deadline]:
        """The deadlines of work on load units in stations, in the evaluation period, in order of time."""
        return self.falling_due(task.work_deadline for task in self.for_workers)

    @cached_property
    def order_deadlines(self) -> list[Deadline]:
        """The deadlines of orders in the evaluation period, in order of time."""
        return self.falling_due(order.deadline for order in self.orders)

    @cached_property
    def orders(self) -> list[OrderHistory]:
        """The orders, in order of release."""
        tasks_of: dict[tuple[str, str], list[TaskHistory]] = {}
        for task in self.tasks.values():
            if task.order:
                tasks_of.setdefault((task.flow, task.order), []).append(task)
        return [OrderHistory(flow, order, tuple(tasks)) for (flow, order), tasks in tasks_of.items()]

    @cached_property
    def counted_orders(self) -> list[OrderHistory]:
        """The orders whose last task was done in the evaluation period."""
        return [order for order in self.orders if self.counts(order.done) and order.done <= self.end]

    @cached_property
    def assignments(self) -> list[Assignment]:
        """The assignments of tasks to robots, in order of time."""
        held: dict[int, tuple[int, float]] = {}
        assignments = []
        for row in self.rows("assigned", "delivered", "returned"):
            if row.kind == "assigned":
                held[row.task] = row.robot, row.time
            elif row.task in held:
                robot, start = held.pop(row.task)
                assignments.append(Assignment(robot, row.task, start, row.time, row.kind))
        assignments += [Assignment(robot, task, start, self.end, "open") for task, (robot, start) in held.items()]
        return sorted(assignments, key=lambda assignment: (assignment.start, assignment.robot))

    @cached_property
    def knows_batches(self) -> bool:
        """Whether the model has batches and the log records when tasks joined them, as it does from 0.4.0 on."""
        batching = self.model.policies.batching.name != "single"
        return batching and all(math.isfinite(self.tasks[assignment.task].batched) for assignment in self.assignments)

    @cached_property
    def trips(self) -> list[Trip]:
        """The trips of robots, in the order of their ends; trips whose tasks were given back are left out."""
        taken: dict[int, list[tuple[int, float]]] = defaultdict(list)
        left: dict[int, int] = defaultdict(int)
        trips = []
        for row in self.rows("assigned", "delivered", "returned"):
            if row.kind == "assigned":
                taken[row.robot].append((row.task, row.time))
                left[row.robot] += 1
            else:
                left[row.robot] -= 1
                if not left[row.robot]:
                    tasks, times = zip(*taken.pop(row.robot), strict=True)
                    if row.kind == "delivered":
                        trips.append(Trip(row.robot, tasks, times[0], row.time))
        return trips

    @cached_property
    def pickers_work(self) -> list[PickerSpan]:
        """The walks and picks of all pickers, in the order of their starts."""
        spans = []
        for row in self.rows("walking", "picking"):
            assert row.edge is not None
            assert row.until is not None
            picks, offset = row.kind == "picking", row.value or 0.0
            spans.append(PickerSpan(row.other, row.robot, row.task, row.time, row.until, picks, row.edge, offset))
        return spans

    # States

    @cached_property
    def starts(self) -> list[Start]:
        """The start of each robot: as in the model or, if the fleet begins in steady state, at its charger."""
        starts = self.model.fleet.starts(self.layout.bays)
        for row in self.rows(AT_START):
            if row.time > 0:
                break
            if row.node is not None and not starts[row.robot].on_lanes:
                starts[row.robot] = Start(row.node)
        return starts

    @cached_property
    def changes(self) -> list[list[StateSpan]]:
        """The states of each robot in order of time, including states of zero length. Robots start idle."""
        batteries = self.model.battery is not None
        levels = start_levels(self.model, Streams(self.seed))
        now: list[tuple[str, float, int, float | None, str]] = [
            (AT_START, 0.0, NONE, full if batteries else None, stand.node)
            for full, stand in zip(levels, self.starts, strict=True)
        ]
        spans: list[list[StateSpan]] = [[] for _ in now]
        for row in self.rows(*STATES):
            state, start, task, level, node = now[row.robot]
            if row.kind == AT_START and row.time == 0 and not spans[row.robot]:  # as it stands when the run begins
                now[row.robot] = row.kind, row.time, row.task, row.value, row.node or ""
                continue
            spans[row.robot].append(StateSpan(row.robot, state, start, row.time, task, level, node))
            now[row.robot] = row.kind, row.time, row.task, row.value, row.node or ""
        for robot, (state, start, task, level, node) in enumerate(now):
            spans[robot].append(StateSpan(robot, state, start, self.end, task, level, node))
        return spans

    @cached_property
    def states(self) -> list[list[StateSpan]]:
        """The states of each robot in order of time. They fill the run, and none has zero length."""
        return [[span for span in robot if span.end > span.start] for robot in self.changes]

    @cached_property
    def served(self) -> list[tuple[str, float, float]]:
        """The intervals in which robots loaded or unloaded in stations, as (node of the station, begin, end)."""
        stored = {row.task for row in self.rows("released") if row.value is not None and row.value >= 0}
        comes_and_goes = self.model.pods is not None  # no robot is served twice before it drives again
        inside: dict[int, str] = {}
        since: dict[int, float] = {}
        spans = []
        for row in self.rows("docked", "lifted", "stored", "picking", "delivered", *STATES):
            if row.kind == "docked":
                inside[row.robot] = row.node or ""
                continue
            if row.kind in {"picking", "delivered"}:
                if row.edge is not None:  # in the lane at the station's node
                    inside.pop(row.robot, None)
                    since.pop(row.robot, None)
                continue
            if row.kind in {"lifted", "stored"}:  # a pod at a storage place, without a server
                since.pop(row.robot, None)
                continue
            if row.robot in since:
                spans.append((inside[row.robot], since.pop(row.robot), row.time))
            has_left = (comes_and_goes and row.kind in _DRIVING) or row.node not in {None, inside.get(row.robot)}
            if has_left or (row.kind in _LOADING and row.task in stored):
                inside.pop(row.robot, None)  # it has left, as goods of a storage place are outside
            elif row.kind in SERVED and row.robot in inside:
                since[row.robot] = row.time
        return spans + [(inside[robot], start, self.end) for robot, start in since.items()]

    @cached_property
    def recharges(self) -> list[float]:
        """The times at which robots went out again after charging."""
        return [row.time for row in self.rows("recharged")]

    # Traffic

    def need_all(self, what: str) -> None:
        """Refuse a run whose log leaves out drives and waits, which `what` is computed from; raises ReportError."""
        if self.log.level != "all":
            raise ReportError(
                f"{what} needs log: all (now log: {self.log.level}), run with --set log=all to record drives and waits"
            )

    @cached_property
    def waits(self) -> list[Wait]:
        """All waiting episodes, in the order in which they ended. Needs `log: all`."""
        on = [start.edge for start in self.starts]
        waits = []
        for row in self.rows("drive", *PLACES, "collision", *APART):
            if row.kind == "collision":
                stands = on[row.robot] if row.edge is None else row.edge
                start = row.time - (row.value or 0.0)
                waits.append(Wait(row.robot, row.other, start, row.time, row.node, row.edge, stands))
            elif row.kind in APART:
                start, stands = row.time - (row.value or 0.0), on[row.robot]
                waits.append(Wait(row.robot, NONE, start, row.time, row.node, None, stands, row.kind, row.edge))
            else:  # a robot in a bay or station may also wait, on no edge
                on[row.robot] = row.edge
        return waits

    @property
    def collisions(self) -> list[Wait]:
        """The waiting episodes that S counts."""
        return [wait for wait in self.waits if wait.cause == WAITING.name]

    @cached_property
    def blocked(self) -> list[Blocked]:
        """The intervals in which edges were closed or had people in them, in order of their starts, up to the end."""
        spans = []
        since: dict[tuple[Edge | None, float | None], LogRow] = {}
        for row in self.rows("edge_closed", "edge_opened", "person_in", "person_out"):
            key = row.edge, row.value
            if row.kind in ("edge_closed", "person_in"):
                since[key] = row
            else:
                spans.append(_blocked(since.pop(key), row.time))
        spans += [_blocked(row, self.end) for row in since.values()]
        return sorted(spans, key=attrgetter("start"))

    @cached_property
    def stays(self) -> list[list[Whereabouts]]:
        """The whereabouts of each robot in order of time, from the start. Needs `log: moves` or `all`."""
        stays = [[Whereabouts(0.0, start.edge, start.node)] for start in self.starts]
        for row in self.rows(*PLACES):
            stays[row.robot].append(Whereabouts(row.time, row.edge, row.node or ""))
        return stays

    @cached_property
    def rotations(self) -> list[Rotation]:
        """The rings of robots that turned."""
        return [Rotation(*ring) for ring in self.log.rings]

    # Energy

    @cached_property
    def chargers(self) -> int:
        """The number of chargers that robots can use."""
        return sum(chargers_at(self.model, self.layout).values())

    @cached_property
    def chargings(self) -> list[ChargeSpan]:
        """The intervals in which robots were at a charger, robot by robot. Empty without batteries."""
        return [
            ChargeSpan(
                span.robot, span.start, span.end, span.energy or 0.0, at_end if after is None else after.energy or 0.0
            )
            for spans, at_end in zip(self.changes, self.energy_at_end, strict=False)
            for span, after in zip_longest(spans, spans[1:])
            if span.seen.phase is Phase.CHARGING
        ]

    @cached_property
    def batteries(self) -> list[BatterySpec]:
        """The battery of each robot; empty without batteries."""
        of_kinds = by_kind(self.model)
        specs = (of_kinds[kind].battery for kind in self.model.fleet.kinds_of_robots())
        return [spec for spec in specs if spec is not None]

    @cached_property
    def charged(self) -> float:
        """The energy charged into all batteries together in the evaluation period."""
        return math.fsum(
            span.after - self._level_when_counting_begins(span) for span in self.chargings if self.counts(span.end)
        )

    def _level_when_counting_begins(self, charge: ChargeSpan) -> float:
        """Return the level of a battery at the start of a charge, or of the part of it in the evaluation period."""
        return charge.before + self._charged(charge.robot, charge.before, max(self.begin - charge.start, 0.0))

    @cached_property
    def lowest_levels(self) -> list[float]:
        """The lowest level of each battery in the evaluation period, as a share of its capacity; empty without any.

        This needs no particular level of the log: levels only fall between charging stops, so that the lowest is at the
        start of a state, or at the end of the run.
        """
        lowest = list(self.energy_at_end)
        for charge in self.chargings:
            if self.counts(charge.end):
                lowest[charge.robot] = min(lowest[charge.robot], self._level_when_counting_begins(charge))
        for robot, level in enumerate(lowest):
            spans = self.changes[robot]
            counted = (span.energy for span in spans if span.energy is not None and self.counts(span.start))
            lowest[robot] = min((*counted, level))
        return [level / battery.capacity for level, battery in zip(lowest, self.batteries, strict=True)]

    @cached_property
    def charger_wait(self) -> float:
        """The total time in which robots queued for a charger, in the evaluation period.

        Robots that rest because their batteries are too low for work are not in the queue.
        """
        queued = (
            span
            for robot in self.changes
            for span in robot
            if span.seen.queue == CHARGER and span.seen.name not in TOO_LOW
        )
        return math.fsum(self.within(span.start, span.end) for span in queued)

    @cached_property
    def energy_curves(self) -> list[Curve]:
        """The times and energies of the corners of each robot's battery level, which is linear between them.

        The log has the energy at every change of state. In between it falls at the state's rate. If the rate at rest
        differs, recorded waits (`log: all`) add corners. A tapered charge is sampled.
        """
        if self.model.battery is None:
            return []
        waits: dict[int, list[Wait]] = defaultdict(list)
        if any(len(set(rates.values())) > 1 for rates in self._rates):
            for wait in self.waits:  # the waits of a robot one after the other
                waits[wait.robot].append(wait)
        curves: list[Curve] = []
        for robot, changes in enumerate(self.changes):
            points = [point for span in changes if span.end > span.start for point in self._corners(span, waits[robot])]
            points.append((self.end, self.log.energy[robot]))
            curves.append(([time for time, _ in points], [level for _, level in points]))
        return curves

    @property
    def energy_at_end(self) -> list[float]:
        """The energy left in each robot's battery at the end of the run; empty without batteries."""
        return self.log.energy

    @cached_property
    def _rates(self) -> list[dict[str, float]]:
        return [charging.rates(battery) for battery in self.batteries]

    @cached_property
    def _kinds(self) -> list[str]:
        return self.model.fleet.kinds_of_robots()

    @cached_property
    def _swapped(self) -> set[str]:
        """The kinds of robots whose batteries are swapped."""
        return {kind for kind, kind_model in by_kind(self.model).items() if kind_model.policies.charging.name == "swap"}

    def _corners(self, span: StateSpan, waits: list[Wait]) -> list[tuple[float, float]]:
        """Return times and energies in a state of a robot: at its start, and wherever the rate changes."""
        level, robot = span.energy or 0.0, span.robot
        points = [(span.start, level)]
        if span.seen.phase is Phase.CHARGING:
            if self.batteries[robot].taper is not None:
                step = (span.end - span.start) / _CURVE
                points += [
                    (span.start + n * step, level + self._charged(robot, level, n * step)) for n in range(1, _CURVE)
                ]
            return points
        driving, standing = self._rates[robot][span.state], self._rates[robot][WAITING.name]
        now = span.start
        for wait in islice(waits, bisect_right(waits, span.start, key=_end_of), None):
            if wait.start >= span.end:
                break
            start, end = max(wait.start, span.start), min(wait.end, span.end)
            if end > start:
                at_start = level - driving * (start - now)
                level, now = at_start - standing * (end - start), end
                points += [(start, at_start), (end, level)]
        return points

    def _charged(self, robot: int, level: float, time: float) -> float:
        """Return the energy that a charger gives in a time; 0 for swapped batteries, which are full only at the end."""
        if self._kinds[robot] in self._swapped:
            return 0.0
        return charging.charge_gain(self.batteries[robot], level, time)


def in_spans(tasks: Iterable[TaskHistory], begin: float, end: float, spans: int) -> Spans:
    """Return the number of tasks done in each of several equal spans of time, and the sums of their cycle times."""
    width = (end - begin) / spans
    counts, times = [0] * spans, [0.0] * spans
    for task in tasks:
        if begin <= task.done <= end:
            span = min(int((task.done - begin) / width), spans - 1)
            counts[span] += 1
            times[span] += task.cycle_time
    return counts, times
