"""An exact account of time: every second of every robot and task has one cause, and the parts add up to the whole.

For the tables of a run (`Run.account`), the figures of its page, and the suspects of `desim why`.

Each second of a robot belongs to its state or, while it waits in traffic, to the reason of its wait. Both are cut at
the same instants, so that nothing is counted twice or left out. A new state, or a new wait that is not a collision,
becomes a part without any change here (see `states`); a new reason for collisions needs a line in `_TRAFFIC` and in
`pieces`. Waits need `log: all`.

If the root of a robot's chain of waits (`chains`) is a closed lane or a person, its wait is booked on this root. All
other waits in traffic are counted where the robot stands.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import Counter, defaultdict
from collections.abc import Callable, Hashable, Iterable, Iterator
from itertools import islice
from operator import attrgetter
from typing import TYPE_CHECKING, Literal, NamedTuple, get_args
from weakref import WeakKeyDictionary

from desim_warehouse.errors import ReportError
from desim_warehouse.outcome.chains import TRAFFIC, Chains
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.pieces import Piece
from desim_warehouse.outcome.records import TaskHistory
from desim_warehouse.states import APART, SHOWN, WAITING, Phase, absent, names

if TYPE_CHECKING:
    import pandas as pd

By = Literal["task", "flow", "station", "robot", "edge", "node", "hour"]
"""The rows of an account."""
OF_WORK = ("task", "flow", "station")
"""Accounts of the time of tasks; all others are accounts of the time of robots."""
Table = tuple["list[int] | list[str]", "Iterable[tuple[Hashable, str, float]]"]
"""The rows of an account, and the row, part and length of each stretch of time."""
ALL = "all tasks"
"""The row of tasks that belong to no flow."""
_known: WeakKeyDictionary[History, list[list[Piece]]] = WeakKeyDictionary()


class Share(NamedTuple):
    """A part of an account: the name of its column, its label, and its colour in figures."""

    name: str
    doing: str
    colour: str


_TRAFFIC = (
    Share("behind_robot", "waiting behind a robot", WAITING.colour),
    Share("before_intersection", "waiting before an intersection", "#7F7F7F"),
    *(Share(state.name, state.doing, state.colour) for state in APART.values()),
)
OF_ROBOTS = {
    part.name: part
    for part in (
        *(Share(state.name, state.doing, state.colour) for state in SHOWN.values()),
        *_TRAFFIC,
    )
}
"""The parts of a robot's time, in the order of columns; accounts by edge, node and hour have these columns too."""
_UNASSIGNED = Share("waiting_for_robot", "waiting for a robot", "#AB9ABF")
_TO_POD = Share("waiting_for_pod", "waiting for a pod", "#8FA6C9")
_TO_LINES = Share("waiting_for_lines", "waiting while other lines are picked", "#CFC86B")
_TO_BATCH = Share("waiting_for_batch", "waiting for a batch", "#C7B7D6")
_AT_WORK = {
    part.name: part
    for part in (
        Share("waiting_for_worker", "waiting for a worker", "#C9A66B"),
        Share("worked_on", "being worked on", "#A6761D"),
    )
}
OF_TASKS = {
    **{part.name: part for part in (_TO_BATCH, _UNASSIGNED, _TO_POD)},
    **OF_ROBOTS,
    _TO_LINES.name: _TO_LINES,
    **_AT_WORK,
}
"""The parts of a task's time, in order: waiting for a batch, waiting for a robot (also in a robot's queue), the
activities of that robot, and the work on the load unit if the task is done only after it. With pods a task is a line,
which waits until a robot goes for a pod with its item, and for other lines of that pod to be picked."""
BATCHED, UNTAKEN = _TO_BATCH.name, (_TO_BATCH.name, _UNASSIGNED.name, _TO_POD.name)
"""The part in which a task waits for a batch, and all parts before a robot takes it."""
_PICKED = names(lambda state: state.phase is Phase.UNLOADING)


def account(history: History, by: By = "robot") -> pd.DataFrame:
    """Divide the time of every task, flow, station, robot, edge, node or hour into its parts (see `Run.account`).

    Raises:
        ReportError: another `by`, or a run without `log: all`.
    """
    import pandas as pd

    if by not in get_args(By):
        raise ReportError(f"account by {by!r}: expected one of {', '.join(get_args(By))}")
    history.need_all("an account of time")
    index, stretches = _rows(history, by)
    spent: defaultdict[tuple[Hashable, str], list[float]] = defaultdict(list)
    for row, part, length in stretches:
        spent[row, part].append(length)
    no = absent(history.model)
    if not history.workplaces or history.model.tasks.done_when == "delivered":
        no |= _AT_WORK.keys()
    if not history.knows_batches:
        no |= {_TO_BATCH.name}
    no |= {_TO_POD.name, _TO_LINES.name} if history.model.pods is None else {_UNASSIGNED.name}
    columns = (part for part in (OF_TASKS if by in OF_WORK else OF_ROBOTS) if part not in no)
    table = {part: [math.fsum(spent.get((row, part), ())) for row in index] for part in columns}
    return pd.DataFrame(table, index=pd.Index(index, name=by), dtype=float)


def _rows(history: History, by: By) -> Table:
    """Return the rows of an account, and the stretches of time that belong to each."""
    tables: dict[By, Callable[[History], Table]] = {
        "task": _by_task,
        "flow": _by_flow,
        "station": _by_station,
        "robot": _by_robot,
        "edge": _by_edge,
        "node": _by_node,
        "hour": _by_hour,
    }
    return tables[by](history)


def share_of_tasks(history: History, *parts: str) -> float:
    """Return the share of some parts in the time of all tasks together; 0 without tasks."""
    spent = account(history, "task").sum()
    whole = float(spent.sum())
    return math.fsum(float(spent.get(part, 0.0)) for part in parts) / whole if whole else 0.0


# Robots


def booked(history: History) -> list[list[Piece]]:
    """Divide the time of each robot as `pieces` does, but book waits whose root is a closure or person on this root."""
    if history not in _known:
        chains = Chains(history)
        _known[history] = [[part for piece in robot for part in _blamed(piece, chains)] for robot in chains.fleet]
    return _known[history]


def _blamed(piece: Piece, chains: Chains) -> Iterator[Piece]:
    """Cut a piece where the root of a wait in traffic changes."""
    if piece.part not in TRAFFIC:
        yield piece
        return
    for lost in sorted(chains.follow(piece), key=attrgetter("start")):
        part = lost.root.cause if lost.root.cause in APART else piece.part
        yield piece._replace(start=lost.start, end=lost.end, part=part)


def _counted(history: History) -> Iterator[Piece]:
    """Iterate over the pieces of all robots from the end of the warm-up."""
    return (piece for robot in booked(history) for piece in robot if history.counts(piece.start))


def _by(rows: list[int] | list[str], row: Callable[[Piece], Hashable], history: History) -> Table:
    return rows, ((row(piece), piece.part, piece.length) for piece in _counted(history))


def _by_robot(history: History) -> Table:
    return _by(list(range(len(history.states))), lambda piece: piece.robot, history)


def _by_edge(history: History) -> Table:
    return _by([">".join(edge) for edge in history.layout.graph.edges], lambda piece: piece.edge, history)


def _by_node(history: History) -> Table:
    return _by(list(history.layout.graph), lambda piece: piece.node, history)


def _by_hour(history: History) -> Table:
    """Divide the account into hours, counted from the end of the warm-up."""
    hour = history.model.units.hour
    bounds = [history.begin + n * hour for n in range(max(math.ceil(history.counted / hour), 1))]
    ends = [*bounds[1:], math.inf]

    def split() -> Iterator[tuple[int, str, float]]:
        for piece in _counted(history):
            start, n = piece.start, bisect_right(bounds, piece.start) - 1
            while start < piece.end:
                end = min(piece.end, ends[n])
                yield n, piece.part, end - start
                start, n = end, n + 1

    return list(range(len(bounds))), split()


# Tasks


def counted_tasks(history: History) -> dict[int, TaskHistory]:
    """Return the tasks that `account` has rows for, by number: all but those done before the evaluation period."""
    return {number: task for number, task in history.tasks.items() if history.counts(task.done)}


def _by_task(history: History) -> Table:
    tasks = counted_tasks(history)
    return list(tasks), _parts_of_tasks(history, tasks)


def _by_flow(history: History) -> Table:
    return _means(history, list(history.model.tasks.flows) or [ALL], lambda task: task.flow or ALL)


def _by_station(history: History) -> Table:
    stations = history.layout.stations
    names = {node: f"{item.zone} at {node}" for node, item in stations.items()}
    return _means(history, list(names.values()), lambda task: "" if task.stored else names.get(task.station, ""))


def _means(history: History, rows: list[str], row: Callable[[TaskHistory], str]) -> Table:
    """Divide the time of the mean task of each row; rows without tasks, and tasks without a row, are omitted."""
    tasks = counted_tasks(history)
    row_of = {number: row(task) for number, task in tasks.items()}
    count = Counter(row_of.values())
    stretches = (
        (row_of[number], part, length / count[row_of[number]])
        for number, part, length in _parts_of_tasks(history, tasks)
    )
    return [name for name in rows if count[name]], stretches


def _parts_of_tasks(history: History, tasks: dict[int, TaskHistory]) -> Iterator[tuple[int, str, float]]:
    """Iterate over the parts of each task: the time before a robot has it, its robot's activities, and work on it."""
    fleet = booked(history)
    starts = [[piece.start for piece in robot] for robot in fleet]
    free = {number: task.released for number, task in tasks.items()}
    turns = {} if history.model.pods is None else _turns(history)
    untaken = _UNASSIGNED.name if history.model.pods is None else _TO_POD.name
    if history.knows_batches:
        for number, task in tasks.items():
            free[number] = min(task.batched, history.end)
            yield number, _TO_BATCH.name, free[number] - task.released
    for assignment in history.assignments:
        number = assignment.task
        if number not in tasks:
            continue
        yield number, untaken, assignment.start - free[number]
        free[number] = assignment.end
        robot = fleet[assignment.robot]
        first = max(bisect_right(starts[assignment.robot], assignment.start) - 1, 0)
        for piece in islice(robot, first, None):
            if piece.start >= assignment.end:
                break
            start, end = max(piece.start, assignment.start), min(piece.end, assignment.end)
            if piece.part in _PICKED and start < (turn := min(turns.get(number, start), end)):
                yield number, _TO_LINES.name, turn - start
                start = turn
            yield number, piece.part, end - start
    for number, task in tasks.items():
        yield number, untaken, min(task.delivered, history.end) - free[number]
        if task.delivered < task.done:
            begun = min(task.begun, history.end)
            yield number, "waiting_for_worker", begun - task.delivered
            yield number, "worked_on", min(task.done, history.end) - begun


def _turns(history: History) -> dict[int, float]:
    """Return the earliest time at which each line could be picked: when the robot's previous line was delivered."""
    last, turns = [0.0] * len(history.states), {}
    for row in history.rows("delivered"):
        turns[row.task], last[row.robot] = last[row.robot], row.time
    for assignment in sorted(history.assignments, key=lambda assignment: (assignment.start, assignment.task)):
        if assignment.ended == "open":  # when the run ends, the robot's first open line is being picked, others wait
            turns[assignment.task], last[assignment.robot] = last[assignment.robot], math.inf
    return turns
