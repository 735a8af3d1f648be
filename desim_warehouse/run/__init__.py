"""The data of one simulation run: how it is simulated, and its tables.

For `desim run`, `replay` and `report`, and for the runs of a study; users hold `questions.run.Run`.
"""

from __future__ import annotations

import gc
import math
from collections.abc import Iterable
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from desim_warehouse.errors import ModelError, ReportError, shown
from desim_warehouse.model import as_model
from desim_warehouse.outcome import account, chains, indicators, verdicts
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.log import NONE
from desim_warehouse.values.arguments import each, is_finite
from desim_warehouse.values.frames import typed

if TYPE_CHECKING:
    from collections.abc import Iterator

    import pandas as pd

    from desim_warehouse.layout import Layout
    from desim_warehouse.model import Model, Source
    from desim_warehouse.outcome.account import By
    from desim_warehouse.outcome.log import Log
    from desim_warehouse.outcome.positions import Positions
    from desim_warehouse.outcome.verdicts import Verdict
    from desim_warehouse.replay import Replay
    from desim_warehouse.run.folder import KeptRun
    from desim_warehouse.run.stop import StopSignal
    from desim_warehouse.world.robots.settled import SettledFleets


class RunData:
    """The outcome of one simulation run: indicators as plain numbers, everything else as tables.

    `questions.run.Run` is a `RunData` that shows itself in words and pages.
    """

    def __init__(self, model: Model, seed: int, log: Log, layout: Layout, *, deterministic: bool = False) -> None:
        self.model = model
        self.seed = seed
        self.record = log
        self.layout = layout
        self.deterministic = deterministic
        """Whether the run used no random stream and no policy of the user's own, so that every seed gives this run."""
        self.history = History(log, model, layout, seed)

    @classmethod
    def simulated(
        cls,
        model: Source,
        seed: int = 0,
        stop: StopSignal | None = None,
        *,
        until: float | None = None,
        fleets: SettledFleets | None = None,
    ) -> Self:
        """Simulate a model, or its file, once; see `questions.run.simulate`.

        `fleets`: where settled fleets are looked up, and kept; None: in the memory of this process.
        """
        from desim_warehouse.world import World
        from desim_warehouse.world.robots.settled import OF_THIS_PROCESS

        model = as_model(model)
        if until is not None and not (is_finite(until) and until > 0):
            raise ModelError([f"until {shown(until):.60}: expected a time above 0, such as 600"])
        with _no_collector():
            world = World(model, seed, heed=None if stop is None else stop.obey, fleets=fleets or OF_THIS_PROCESS)
            world.run(until)
        deterministic = not world.streams.used and not model.policies.own()
        return cls(model, seed, world.log, world.layout, deterministic=deterministic)

    @classmethod
    def load(cls, folder: str | Path) -> Self:
        """Read a run from the folder it was saved to; see `questions.run.load_run`."""
        from desim_warehouse.run.folder import read_run

        return read_run(Path(folder), cls._of_kept)

    @classmethod
    def _of_kept(cls, kept: KeptRun) -> Self:
        run = cls(kept.model, kept.seed, kept.log, kept.layout, deterministic=kept.deterministic)
        run.kpis = indicators.RunIndicators(run.kpis | kept.kpis)  # another version may count otherwise
        return run

    @property
    def version(self) -> str:
        """The version of desim-warehouse that simulated it."""
        return self.record.version

    @cached_property
    def kpis(self) -> indicators.RunIndicators:
        """All indicators of the run, in the units of its model file."""
        return indicators.kpis(self.history)

    @property
    def T(self) -> float:  # noqa: N802 - the paper's name
        """Task time, in the model's time unit: until all goods are delivered and the last robot is back."""
        return self._of_the_paper("T")

    @property
    def S(self) -> int:  # noqa: N802 - the paper's name
        """Number of collisions: waiting episodes, summed over all robots."""
        return int(self._of_the_paper("S"))

    @property
    def C(self) -> int:  # noqa: N802 - the paper's name
        """Number of charging stops after which a robot went out again."""
        return int(self._of_the_paper("C"))

    def _of_the_paper(self, name: str) -> float:
        """Return one indicator of the paper, computed alone unless all indicators are known."""
        return self.kpis[name] if "kpis" in vars(self) else indicators.INDICATORS[name].compute(self.history)

    @cached_property
    def verdicts(self) -> list[Verdict]:
        """The verdicts on the run, in words: it cannot keep up, drains its batteries, or is jammed."""
        return verdicts.judge_run(self.kpis, self.history)

    @cached_property
    def log(self) -> pd.DataFrame:
        """One row per event: time, kind, robot, task, node, edge, value, until, other (see `outcome.log`).

        Where storage places have names, `place` is the first name of the one at which the task's good lies.
        """
        table, called = self.record.frame(), self.layout.called
        if called:
            places = {number: called.get(task.good) for number, task in self.history.tasks.items()}
            table["place"] = table["task"].map(places)
            return typed(table, {"place": str})
        return table

    @cached_property
    def robots(self) -> pd.DataFrame:
        """One row per robot: time in each state and waiting, distance, energy, waits by cause, tasks, charges."""
        import pandas as pd

        return pd.DataFrame(self.record.robots).rename_axis("robot")

    @cached_property
    def tasks(self) -> pd.DataFrame:
        """One row per task: released, due, assigned, loaded, delivered, done, robot, flow, order, station.

        Times are in the model's time unit; NaN: not by the end of the run. `assigned` and `robot` are of the last
        assignment, as a robot with a low battery gives a task back; a robot of -1: not assigned yet. `done` is the
        delivery, or with `tasks.done_when: worked` the end of the work at its station. `station`: the node of the
        delivery. Where storage places have names, `place` is the first name of the one at which the task's good lies.
        """
        import pandas as pd

        times = ("released", "due", "assigned", "loaded", "delivered", "done")
        columns = {**dict.fromkeys(times, float), "robot": int, "flow": str, "order": str, "station": str}
        last = {assignment.task: (assignment.start, assignment.robot) for assignment in self.history.assignments}
        rows = []
        for number, task in self.history.tasks.items():
            assigned, robot = last.get(number, (None, NONE))
            row: list[Any] = [task.released, task.due, assigned, task.loaded, task.delivered, task.done]
            row += [robot, task.flow, task.order, task.station]
            rows.append([None if value in {math.inf, ""} else value for value in row])
        table = pd.DataFrame(rows, pd.Index(self.history.tasks, dtype="int64", name="task"), list(columns))
        if called := self.layout.called:
            columns["place"], table["place"] = str, [called.get(task.good) for task in self.history.tasks.values()]
        return typed(table, columns)

    @cached_property
    def edges(self) -> pd.DataFrame:
        """Congestion per edge: passages, waits behind other robots, time blocked."""
        import pandas as pd

        return pd.DataFrame(self.record.edges).set_index("edge")

    @cached_property
    def nodes(self) -> pd.DataFrame:
        """Congestion per intersection: passages, waits before it, time blocked."""
        import pandas as pd

        return pd.DataFrame(self.record.nodes).set_index("node")

    @cached_property
    def waits(self) -> pd.DataFrame:
        """Waits of robots for others: robot, other, start, end, and the node or edge; needs `log: all`.

        A robot may wait for a robot that itself waits for a third. `root` is the end of this chain for most of the
        wait, and `root_at` the node or edge where it is: a state of a robot (`loading`), a queue, a closure, a person,
        or `crossing`, `lane`, `two_way_lane`, `ring` (see `desim_warehouse.outcome.chains`). With closures or people
        also the `cause`: `waiting` for robots, `waiting_closed` or `waiting_person`.

        Raises:
            ReportError: a run without `log: all`.
        """
        import pandas as pd

        self.history.need_all("a table of waits")
        waits = self.history.waits
        roots = chains.roots(self.history) if waits else []
        columns = {"start": float, "end": float, "robot": int, "other": int, "node": str, "edge": str}
        columns |= {"root": str, "root_at": str}
        rows = [
            (wait.start, wait.end, wait.robot, wait.other, wait.node, wait.edge and ">".join(wait.edge), *root)
            for wait, root in zip(waits, roots, strict=True)
        ]
        table = pd.DataFrame(rows, columns=list(columns))
        if self.model.waits_apart:
            columns["cause"], table["cause"] = str, [wait.cause for wait in waits]
        return typed(table, columns)

    @cached_property
    def lost_time(self) -> pd.DataFrame:
        """The time lost to each root of waits, most first: root, root_at, time, share, robots; needs `log: all`.

        A row for each root (see `waits`). `time`: that all robots together waited for it in the evaluation period, in
        traffic and in queues; `share`: of the fleet's time; `robots`: how many of them. The times add up to all
        waiting.

        Raises:
            ReportError: a run without `log: all`.
        """
        import pandas as pd

        self.history.need_all("a table of lost time")
        lost = chains.lost_to(self.history)
        whole = self.history.counted * len(self.record.robots)
        rows = [(*root, time, time / whole, robots) for root, (time, robots) in lost.items()]
        columns = {"root": str, "root_at": str, "time": float, "share": float, "robots": int}
        return typed(pd.DataFrame(rows, columns=list(columns)), columns)

    def account(self, by: By = "robot") -> pd.DataFrame:
        """Return the time by cause, complete to the second: for each task, flow, station, robot, edge, node or hour.

        Each row adds up to its whole, in the model's time unit.

        - A robot: the evaluation period.
        - A task: the time from its release to its delivery, or to the end of the run if it is open then. Tasks
          delivered in the warm-up are left out.
        - A flow: the mean of its tasks. A station: the mean of the tasks delivered there.
        - An edge or a node: all the time that robots spent there.
        - An hour, counted from the end of the warm-up: its length for each robot. The last may be shorter.

        Waiting before an intersection belongs to its node, not to the edge on which the robot stands. A robot at a node
        may also be in the bay or station beside it. The columns are those of `desim_warehouse.outcome.account`.

        Raises:
            ReportError: a run without `log: all`, or another `by`.
        """
        return account.account(self.history, by)

    def save(self, folder: str | Path) -> Path:
        """Write run.json, kpis.json, log.parquet and the tables robots, edges and nodes (CSV) to a folder."""
        from desim_warehouse.run.folder import KeptRun, save_run

        kept = KeptRun(self.model, self.seed, self.record, self.layout, self.deterministic, self.kpis)
        return save_run(kept, {"robots": self.robots, "edges": self.edges, "nodes": self.nodes}, Path(folder))

    @cached_property
    def rotations(self) -> pd.DataFrame:
        """Gridlock rotations: time, the robots of the ring, and the edges they were on (None: in a bay)."""
        import pandas as pd

        return typed(pd.DataFrame(self.record.rings, columns=["time", "robots", "edges"]), {"time": float})

    def positions(self, times: Iterable[float]) -> pd.DataFrame:
        """Return robots' positions at given times, one row each: time, robot, x, y, heading, node; needs `log: all`.

        Args:
            times: in the model's time unit, in any order; before and after the run robots stand.

        Returns:
            x and y in the units of the layout, the heading in radians from x towards y, and the node that was reached
            last. A robot in a slot of a bay or station is drawn beside its node.

        Raises:
            ReportError: a run without `log: all`, or a time that is not a finite number.
        """
        import numpy as np
        import pandas as pd

        listed = each(times)
        if strange := [time for time in listed if not is_finite(time)]:
            raise ReportError(f"positions at time {shown(strange[0]):.60}: expected a finite number")
        tracks, asked = self._positions, np.array(listed, dtype=float)
        robots = len(tracks.legs.first) - 1
        edge, along = np.empty((len(asked), robots), np.int64), np.empty((len(asked), robots))
        for robot in range(robots):
            edge[:, robot], along[:, robot] = tracks.of(robot, asked)
        points = tracks.edges.points(edge.ravel(), along.ravel())
        columns: dict[str, Any] = {
            "time": np.repeat(asked, robots),
            "robot": np.tile(np.arange(robots), len(asked)),
            "x": points[:, 0],
            "y": points[:, 1],
            "heading": tracks.edges.headings(edge.ravel()),
            "node": tracks.last_nodes(edge.ravel(), along.ravel()),
        }
        return pd.DataFrame(columns)

    @cached_property
    def _positions(self) -> Positions:
        from desim_warehouse.outcome.positions import Positions

        return Positions(self.history)

    def replay(
        self,
        path: str | Path | None = None,
        *,
        start: float | None = None,
        end: float | None = None,
        palette: str = "safe",
        beside: RunData | None = None,
    ) -> Replay:
        """Return a page that plays the run, or a window of it, in a browser; needs `log: all`.

        In Jupyter the page shows itself.

        With `beside`, another run is shown next to it on the same clock.
        """
        from desim_warehouse.replay import replay

        other = None if beside is None else beside.history
        return replay(self.history, path, start=start, end=end, palette=palette, beside=other)

    def floor(self, seconds: float = 600.0) -> dict[str, Any]:
        """Return the first minutes after the warm-up as the data that the replay page plays; needs `log: all`."""
        from desim_warehouse.replay import part

        return part(self.history, seconds)

    def __repr__(self) -> str:
        """Return the three numbers of the paper."""
        return f"{type(self).__name__}({self.model.name}, seed={self.seed}: T={self.T:g}, S={self.S}, C={self.C})"


@contextmanager
def _no_collector() -> Iterator[None]:
    """Pause Python's cycle collector: a run makes few cycles, but millions of log rows that it would scan."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
