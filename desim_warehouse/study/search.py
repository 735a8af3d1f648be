"""Settings of a question that chooses its own runs, such as `desim plan`: how runs are done, and how many."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from desim_warehouse.errors import StudyError, path_of, reason, shown
from desim_warehouse.folders import ANSWER, JOURNAL, LOCK, RESULTS, STUDY, refuse_theirs
from desim_warehouse.study.execution import worker_count
from desim_warehouse.study.statistics.checks import check_confidence
from desim_warehouse.study.statistics.limits import MOST_REPLICATIONS, MOST_RUNS
from desim_warehouse.values.arguments import is_finite, is_whole
from desim_warehouse.values.streams import whole_seed

if TYPE_CHECKING:
    from desim_warehouse.study.execution.crew import Crew


@dataclass(frozen=True, kw_only=True)
class Search:
    """Settings for the runs of `plan`, `best`, `size`, `why` and other questions: number, stopping, storage.

        how = dw.Search(workers=2, out="reports/out/plan")
        dw.plan("models/my_own_day.yaml", "on_time >= 95 %", search=how)

    Args:
        first: replications of a design before the first decision about it; None: 5 or 10, by the question.
        cap: maximum number of replications of a design; None: 80 to 1000, by the question.
        runs: maximum number of runs in all; None: 250 to 5000, by the question.
        confidence: confidence level at which all statements of the answer hold.
        seed: seed of all runs.
        timeout: time limit for each run, in seconds; None: no limit.
        workers: number of processes on this machine, at most 256, or `auto`: one for each processor.
        cluster: address of a Dask scheduler such as tcp://10.0.0.1:8786, or `local`.
        out: the study folder. Runs stored there by any study are reused, and the answer is written there.
        cache: without `out`, store runs in the user's cache (in the folder DESIM_CACHE), and reuse runs stored there.
        progress: show progress on standard error.
        command: as it was typed, for readers of the answer; empty: the question was asked in Python.
        crew: processes shared by several studies; see `together`. None: each study starts its own processes.

    Raises:
        StudyError: a number that no search can have, a cap below `first`, or a folder that is not ours.
        ModelError: an invalid seed.
    """

    first: int | None = None
    cap: int | None = None
    runs: int | None = None
    confidence: float = 0.95
    seed: int = 0
    timeout: float | None = None
    workers: int | str = 1
    cluster: str | None = None
    out: str | Path | None = None
    cache: bool = True
    progress: bool = False
    command: str = ""
    crew: Crew | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Refuse settings that no search can have."""
        counts = (("first", 2, MOST_REPLICATIONS), ("cap", 2, MOST_REPLICATIONS), ("runs", 0, MOST_RUNS))
        for name, least, most in counts:
            count = getattr(self, name)
            if count is not None and not is_whole(count, least, most):
                raise StudyError(f"{name} {shown(count):.60}: expected a whole number from {least} to {most:,}")
        if self.first is not None and self.cap is not None and self.first > self.cap:
            raise StudyError(f"first {self.first}, cap {self.cap}: expected first <= cap")
        if self.timeout is not None and not (is_finite(self.timeout) and self.timeout > 0):
            raise StudyError(f"timeout {shown(self.timeout):.60}: expected seconds above 0, or None for no limit")
        check_confidence(self.confidence)
        whole_seed(self.seed)
        worker_count(self.workers)
        if self.out is not None:
            self._check_folder(Path(self.out))

    def _check_folder(self, folder: Path) -> None:
        """Refuse a folder with files of somebody else that the study or its answer would overwrite."""
        try:
            refuse_theirs(folder, (JOURNAL, RESULTS, STUDY, ANSWER, LOCK))
        except OSError as error:
            raise StudyError(f"{path_of(folder)}: cannot be used as a study folder ({reason(error)})") from error

    def looks(self, first: int, cap: int) -> tuple[int, int]:
        """Return the replications at the first look (interim analysis) at a design, and the most of them.

        The arguments are their defaults.
        """
        return self.first or first, self.cap or cap

    @contextmanager
    def together(self) -> Iterator[Search]:
        """Share one crew among all studies of a question: processes start once, and a design settles once."""
        with self.simulating() as crew:
            yield replace(self, crew=crew)

    @contextmanager
    def simulating(self) -> Iterator[Crew]:
        """Yield the crew that simulates, which ends with the block unless others share it."""
        if self.crew is not None:
            yield self.crew
            return
        from desim_warehouse.study.execution.crew import Crew

        with closing(Crew(self.workers, self.cluster, cache=self.cache)) as crew:
            yield crew

    def under(self, name: str) -> Search:
        """Return the search of one of several studies of a question: with `out`, in a folder of its own inside that."""
        return self if self.out is None else replace(self, out=Path(self.out) / name.replace(" ", "-"))


USUAL = Search()
"""In this process, kept in the user's cache."""
