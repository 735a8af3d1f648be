"""Orders from a file, in the words of the model: times from the start of the run, places of its floor.

It is read in chunks, so a million orders take no more memory than some thousand, and checked row by row. Rows in no
order are sorted by their release, in memory. What is wrong is summed up by kind.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby, pairwise
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING

from desim_warehouse.errors import ModelError
from desim_warehouse.layout import Layout
from desim_warehouse.model.sections.flows import STORAGE, FlowSpec, OrdersArrivals, OrdersFile
from desim_warehouse.model.sections.order_file import Problems, check_there, chunks, options, raw, table_of
from desim_warehouse.model.sections.order_rows import Chunk, OrderLine, Reading, first_day
from desim_warehouse.values.fields import LIMITS

if TYPE_CHECKING:
    from numpy.random import Generator


@dataclass(frozen=True)
class Summary:
    """What a file holds: tasks, rows, the last release, and the nodes and stations it names.

    `due` and `urgent`: rows with a due time, and with a priority; `orders`: how many different ones; `in_order`:
    whether every row is released no earlier than those before; `trips`: whether quantities were taken for tasks;
    `fetched`, `stored`: rows from a storage place to a node or station, and the other way. `raw`: in what it is another
    file than `desim orders` writes, and `options`: those with which that reads it in the same way.
    """

    tasks: int
    rows: int
    last: float
    names: frozenset[str] = frozenset()
    due: int = 0
    urgent: int = 0
    orders: int = 0
    in_order: bool = True
    trips: bool = True
    fetched: int = 0
    stored: int = 0
    raw: tuple[str, ...] = ()
    options: tuple[str, ...] = ()


def read(spec: OrdersFile, how: Reading) -> Iterator[OrderLine]:
    """The rows in the order of their release.

    Raises:
        ModelError: with all kinds of problems of the file.
    """
    if summary(spec, how).in_order:
        yield from (line for lines in _checked(spec, how, Problems(spec.file)) for line in lines)
    else:
        lines = [line for lines in _checked(spec, how, Problems(spec.file)) for line in lines]
        yield from sorted(lines, key=attrgetter("release"))


def summary(spec: OrdersFile, how: Reading) -> Summary:
    """Read the whole file once.

    Raises:
        ModelError: where it cannot be read, or with all kinds of its problems, up to 20.
    """
    stat = check_there(Path(spec.file))
    return _summary(spec, how, (stat.st_mtime_ns, stat.st_size))


@lru_cache(maxsize=8)
def _summary(spec: OrdersFile, how: Reading, _: tuple[int, int]) -> Summary:
    tasks, rows, last, in_order = 0, 0, 0.0, True
    names: set[str | int | None] = set()
    due, urgent, orders = 0, 0, set[str]()
    ways: Counter[tuple[bool | None, bool | None]] = Counter()
    found, most = Problems(spec.file), LIMITS["tasks"][0]
    for lines in _checked(spec, how, found):
        rows += len(lines)
        tasks += sum(line.quantity for line in lines)
        times = [last, *(line.release for line in lines)]
        in_order = in_order and all(earlier <= later for earlier, later in pairwise(times))
        last = max(times)
        due += sum(line.due is not None for line in lines)
        urgent += sum(bool(line.priority) for line in lines)
        orders.update(map(attrgetter("order"), lines))
        ways.update((_in_storage(line.source), _in_storage(line.target)) for line in lines)
        names.update(map(attrgetter("source"), lines), map(attrgetter("target"), lines))
        names.update(place for via in set(map(attrgetter("via"), lines)) for place in via or ())
        if rows > most:
            raise ModelError([f"{spec.file}: too many rows, expected at most {most:,} tasks"])
    problems = found.told()
    if not rows and not problems:
        problems = [f"{spec.file}: no rows, expected at least one order"]
    if tasks > most and not problems:
        problems = [f"{spec.file}: too many tasks (got {tasks:,}), expected at most {most:,}"]
    if problems:
        raise ModelError(problems)
    named = frozenset(name for name in names if isinstance(name, str) and name != STORAGE)
    trips, fetched, stored = spec.quantity == "tasks", ways[True, False], ways[False, True]
    table = table_of(spec)
    other, said = (*raw(spec, table), *found.forms), tuple(options(spec, table))
    return Summary(tasks, rows, last, named, due, urgent, len(orders), in_order, trips, fetched, stored, other, said)


def _in_storage(end: str | int | None) -> bool | None:
    """Whether the end of a row is a storage place, or any of them; None where the row does not say."""
    return None if end is None else not isinstance(end, str) or end == STORAGE


def files_of(flows: Mapping[str, FlowSpec]) -> list[OrdersFile]:
    """The files of orders that flows name; one that is no longer there is left out."""
    named = [flow.when.orders for flow in flows.values() if isinstance(flow.when, OrdersArrivals)]
    return [spec for spec in named if Path(spec.file).exists()]


def nodes_named(files: Iterable[OrdersFile], how: Reading, layout: Layout) -> tuple[str, ...]:
    """The nodes that files of orders name."""
    names = (name for spec in files for name in sorted(summary(spec, how).names))
    return tuple(dict.fromkeys(node for name in names for node in layout.nodes_of(name)))


def problems_of(files: Iterable[OrdersFile], how: Reading) -> list[str]:
    """What is wrong with files of orders, by row and column."""
    found: list[str] = []
    for spec in files:
        try:
            summary(spec, how)
        except ModelError as error:
            found += error.problems
    return found


def resampled(
    lines: Iterator[OrderLine], width: float, demand: float, stream: Callable[[int], Generator]
) -> Iterator[OrderLine]:
    """Orders drawn anew, stretch by stretch of this width: as many as there are on average, `demand` times.

    In each stretch their number is Poisson, each is one of those in it, and its release anywhere in it. An order keeps
    its rows, and the time until it is due. `stream` gives the generator of the n-th stretch.

    Source: the block bootstrap (Kuensch 1989) for a process whose rate changes with the time of day.
    """
    for number, block in groupby(lines, key=lambda line: int(line.release // width)):
        of: dict[str, list[OrderLine]] = {}
        for line in block:
            of.setdefault(line.order, []).append(line)
        orders = list(of.values())
        generator = stream(number)
        count = int(generator.poisson(demand * len(orders)))
        drawn = generator.choice(len(orders), count).tolist()
        times = sorted((generator.uniform(0, width, count) + number * width).tolist())
        for copy, (which, time) in enumerate(zip(drawn, times, strict=True)):
            for line in orders[which]:
                due = None if line.due is None else line.due - line.release + time
                yield line._replace(release=time, due=due, order=f"{line.order}.{number}.{copy}")


def _checked(spec: OrdersFile, how: Reading, found: Problems) -> Iterator[list[OrderLine]]:
    """The rows that could be read, chunk by chunk; what is wrong with others is `found`."""
    table = table_of(spec)
    midnight = first_day(spec, table, how)
    for frame in chunks(spec, table):
        yield Chunk(frame, spec, table, how, midnight, found).lines()
