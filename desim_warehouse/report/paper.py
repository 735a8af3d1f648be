"""Reproduction of the paper's 30 cells, for `desim paper`: T, S and C beside the values of paper and program."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.parts import Folded
from desim_warehouse.errors import ReportError, reason
from desim_warehouse.folders import ANSWER, make_folder, refuse_theirs
from desim_warehouse.look.palette import COLOURS
from desim_warehouse.plot.style import save
from desim_warehouse.questions.study import Study
from desim_warehouse.run.spreadsheet import as_csv

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURES = {"T": (6, "Task time (s)"), "S": (7, "Collisions"), "C": (8, "Chargings")}
"""Number of the paper's figure, and label of its axis, by indicator."""
MARKERS = ("o", "s", "^", "D", "v")


@dataclass(frozen=True)
class Reproduction:
    """The 30 cells of the paper as simulated, beside values from the paper's figures and from its authors' program.

    `table`: a row for each cell, with the columns robots, group, T (time units), T_seconds, S and C. Columns that end
    in `_figure` were read from the paper's figures; those that end in `_program` come from the authors' program.
    `T_difference` is a share of the program's T; `S_difference` and `C_difference` are counts.
    """

    table: pd.DataFrame
    name: str

    def verdict(self) -> list[str]:
        """Return the comparison in sentences."""
        table = self.table
        off = table["T_difference"].abs()
        same_s, same_c = table["S"] == table["S_program"], table["C"] == table["C_program"]
        close = (off <= 0.01).sum()  # noqa: PLR2004 - 1 %
        times = f"median {100 * off.median():.2f} %, largest {100 * off.max():.2f} %"
        counts = f"the program {table['S_program'].sum()}, the paper's figure {table['S_figure'].sum()}"
        apart = f"largest difference {table['S_difference'].abs().max()}"
        return [
            f"T: {close} of {len(table)} cells within 1 % of the program, {times}",
            f"S: {table['S'].sum()} collisions in all, {counts}; equal in {same_s.sum()} cells, {apart}",
            f"C: equal in {same_c.sum()} of {len(table)} cells",
        ]

    @property
    def answer(self) -> Answer:
        """The comparison as an answer, with all cells, which `save` stores in the folder."""
        cells = self.table.round(4)
        return Answer(
            kind="paper",
            name=self.name,
            question="Are T, S and C of the paper reproduced?",
            answer=tuple(f"{line}." for line in self.verdict()),
            tables=(Folded(title="All cells", head=tuple(cells), rows=_rows(cells)),),
            notes=("Figures 6, 7 and 8 are in its folder.",),
            runs=len(cells),
            confidence=None,
        )

    def save(self, folder: str | Path) -> Path:
        """Write the answer, the table (CSV and Parquet) and the figures (PNG and SVG) to a folder, and return it.

        Raises:
            ReportError: the folder cannot be written, or holds other files.
        """
        folder = Path(folder)
        try:
            self._write(folder)
        except OSError as error:
            raise ReportError(f"{folder}: cannot be written ({reason(error)})") from error
        return folder

    def _write(self, folder: Path) -> None:
        figures = [f"figure_{number}.{kind}" for number, _ in FIGURES.values() for kind in ("png", "svg")]
        make_folder(folder)
        refuse_theirs(folder, (ANSWER, "paper.csv", "paper.parquet", *figures))
        self.answer.save(folder)
        (folder / "paper.csv").write_text(as_csv(self.table, float_format="%.6g"), encoding="utf-8")
        self.table.to_parquet(folder / "paper.parquet", index=False)
        for indicator, (number, _) in FIGURES.items():
            save(self.figure(indicator), folder, f"figure_{number}")

    def figure(self, indicator: str) -> Figure:
        """Draw a figure of the paper: an indicator by number of robots, as lines for goods groups and bars of means."""
        from matplotlib.figure import Figure

        number, axis = FIGURES[indicator]
        column = "T_seconds" if indicator == "T" else indicator
        paper = "T_seconds_figure" if indicator == "T" else f"{indicator}_figure"
        drawn = Figure(figsize=(9.6, 3.8), layout="constrained")
        lines, bars = drawn.subplots(1, 2)
        self._lines(lines, column)
        self._bars(bars, column, paper)
        for axes in (lines, bars):
            axes.set_xlabel("Number of robots")
            axes.set_ylabel(axis)
            axes.set_ylim(bottom=0)
            axes.spines[["top", "right"]].set_visible(False)
            axes.grid(axis="y", color="#dddddd", linewidth=0.6)
            axes.set_axisbelow(True)
        drawn.suptitle(f"{axis}, as in Fig. {number} of the paper")
        return drawn

    def _lines(self, axes: Axes, column: str) -> None:
        for (group, cells), colour, marker in zip(self.table.groupby("group"), COLOURS, MARKERS, strict=False):
            axes.plot(cells["robots"], cells[column], color=colour, marker=marker, markersize=5, label=f"group {group}")
        axes.legend(frameon=False, fontsize=8)
        axes.set_title("each goods group", fontsize=10)

    def _bars(self, axes: Axes, column: str, paper: str) -> None:
        means = self.table.groupby("robots")[[column, paper]].mean()
        axes.bar(means.index - 0.2, means[column], 0.38, color=COLOURS[0], label="here")
        axes.bar(means.index + 0.2, means[paper], 0.38, color=COLOURS[5], label="paper")
        axes.legend(frameon=False, fontsize=8)
        axes.set_title("mean of the groups", fontsize=10)


def _rows(cells: pd.DataFrame) -> tuple[tuple[str, ...], ...]:
    return tuple(tuple(f"{value:,.10g}" for value in row) for row in cells.itertuples(index=False))


def reproduce(study: str | Path = "studies/paper.yaml") -> Reproduction:
    """Run the paper's experiment, and compare its results with the values in the file paper.csv beside the study.

    Raises:
        ReportError: no such study or reference values, or a run fails.
    """
    import pandas as pd

    path = Path(study)
    if not path.exists():
        raise ReportError(f"{path}: no such study; expected studies/paper.yaml of desim-warehouse")
    try:
        reference = pd.read_csv(path.with_suffix(".csv"), comment="#")
    except (OSError, ValueError) as error:
        raise ReportError(
            f"{path.with_suffix('.csv')}: the paper's figures cannot be read ({reason(error)})"
        ) from error
    whole = Study.read(path).run()
    runs = whole.table.rename(columns={"fleet.size": "robots"})
    failed = runs["error"].dropna()
    if len(failed):
        raise ReportError(f"{path}: {len(failed)} runs failed, the first with: {failed.iloc[0]}")
    runs["group"] = runs["tasks.goods"].str.removeprefix("group ").astype(int)
    table = runs[["robots", "group", "T", "S", "C"]].merge(reference, on=["robots", "group"], validate="1:1")
    table["T_seconds"] = table["T"] * whole.plan.base.units.seconds
    table["T_difference"] = table["T"] / table["T_steps_program"] - 1
    table["S_difference"] = table["S"] - table["S_program"]
    table["C_difference"] = table["C"] - table["C_program"]
    return Reproduction(table, whole.plan.name)
