"""The verb `simulate`, and its result `Run`, which shows itself as tables, in words, and on a page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from desim_warehouse.run import RunData

if TYPE_CHECKING:
    import pandas as pd

    from desim_warehouse.model import Source
    from desim_warehouse.run.stop import StopSignal


class Run(RunData):
    """The outcome of a run; `print` shows a summary in sentences, as `desim run` does.

    Attributes:
        kpis: all indicators by name, in the units of the model file.
        log: a row for each event.
        tasks: a row for each task, with its times, its robot and its station.
        robots: a row for each robot.
        waits: which robot waited for which other, and where.
        model: the model that was simulated.
        seed: seed of the random streams.
    """

    @property
    def table(self) -> pd.DataFrame:
        """One row: the name of the model, the seed, and every indicator; `pd.concat` makes a table of several runs."""
        import pandas as pd

        return pd.DataFrame([{"model": self.model.name, "seed": self.seed, **self.kpis}])

    def __str__(self) -> str:
        from desim_warehouse.questions.run import words

        return words.text(self)

    def _repr_html_(self) -> str:
        """Show the first page of its report, and its indicators, in a frame."""
        from desim_warehouse.questions.run.page import in_short

        return in_short(self)._repr_html_()


def as_run(data: RunData) -> Run:
    """Return run data as the `Run` that users hold; both share their attributes."""
    run = Run.__new__(Run)
    vars(run).update(vars(data))
    return run


def simulate(model: Source, seed: int = 0, stop: StopSignal | None = None, *, until: float | None = None) -> Run:
    """Simulate a model, or its file, once; equal models and seeds give equal logs.

    `stop` ends the run from another thread. `until`, above 0, limits the clock, in the model's time unit.

    Returns:
        The run; indicators in the units of the model.

    Raises:
        ModelError: no model, or a `seed` or `until` that is not such a number.
        LayoutError: a layout on which work could stop for good.
        CheckError: another error of `check` that the model does not accept.
        PolicyError: a policy that cannot be loaded, or whose answer cannot be carried out.
        SimulationError: a run that cannot go on.
    """
    return Run.simulated(model, seed, stop, until=until)


def load_run(folder: str | Path) -> Run:
    """Load a run from its folder; if another version simulated the run, its indicators are those saved.

    Returns:
        The run, as it was saved.

    Raises:
        ReportError: no run in the folder, or a damaged one.
    """
    return Run.load(folder)
