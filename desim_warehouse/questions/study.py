"""What do the designs of a study do, and which of them meets the target? Studies whose results answer in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

from desim_warehouse.answer.answer import Answer
from desim_warehouse.study.results import ResultsData
from desim_warehouse.study.study import StudyEngine


@dataclass(frozen=True, eq=False)
class Results(ResultsData):
    """The finished runs of a study, their statistics, and the answer that they give.

    `rows` are in the order of the design, then of replications. A design is named by its text, such as "fleet.size=3".
    Points that are equal are one design. `versions` are those that the runs were made with.
    """

    @property
    def answer(self) -> Answer:
        """The answer of the study: the terminal prints it, and pages show it."""
        return self.answer_in(())

    def answer_in(self, indicators: Sequence[str]) -> Answer:
        """Compose the answer of the study in these indicators, the usual ones where there are none."""
        from desim_warehouse.questions import study_words  # most studies are never asked

        return study_words.answer(self, indicators)

    def _repr_html_(self) -> str:
        """Show the page of the answer in a frame."""
        return self.answer._repr_html_()


class Study(StudyEngine):
    """Many runs of one model, changed factor by factor: `run()` it, then look at `table` and `summary()`.

        study = dw.Study("models/multibots.yaml", {"fleet.size": range(1, 7)}, replications=20)
        study.run(workers=2, out="reports/out/fleet")
        study.summary(["T", "S"])

    `Study.open` has the runs of a folder again, in another program or after an interruption.
    """

    _results_type = Results

    @property
    def results(self) -> Results:
        """The finished runs, and what follows from them. They do not change when the study runs on.

        Raises:
            StudyError: where the study has not been run.
        """
        return cast("Results", super().results)
