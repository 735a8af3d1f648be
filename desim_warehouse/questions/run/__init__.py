"""What did this run do? `simulate` a model, and the run shows itself: as tables, in words, on a page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from desim_warehouse.run import RunData

if TYPE_CHECKING:
    from desim_warehouse.model import Source
    from desim_warehouse.run.stop import StopSignal


class Run(RunData):
    """The outcome of a run: indicators as plain numbers, everything else as tables; in Jupyter it shows its page."""

    def _repr_html_(self) -> str:
        """Show the first page of its report, and its indicators, in a frame."""
        from desim_warehouse.questions.run.page import in_short

        return in_short(self)._repr_html_()


def simulate(model: Source, seed: int = 0, stop: StopSignal | None = None, *, until: float | None = None) -> Run:
    """Simulate a model, or its file, once; the same model and seed give the same log.

    `stop` ends it from another thread. The clock stops at `until`, in the model's time unit, if the run lasts so long.

    Raises LayoutError for layouts on which work could stop for good, CheckError for what else `check` calls an error
    and the model does not accept, SimulationError and PolicyError for what goes wrong during the run.
    """
    return Run.simulated(model, seed, stop, until=until)


def load_run(folder: str | Path) -> Run:
    """A run from the folder it was saved to, with the indicators that were saved if another version simulated it.

    Raises ReportError where there is none, or it is damaged.
    """
    return Run.load(folder)
