"""The work of robots: shares of time, one row of states for each robot, and batteries over time.

For `plot.utilisation`, `gantt` and `battery`, in notebooks.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from desim_warehouse.answer import words
from desim_warehouse.errors import ReportError, shown
from desim_warehouse.look import palette
from desim_warehouse.model import Model
from desim_warehouse.model.facts import charging
from desim_warehouse.plot import style as look
from desim_warehouse.run import RunData
from desim_warehouse.study.table import averaged_over, cells
from desim_warehouse.values.arguments import each, is_finite, is_whole

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


_LABELLED = 24
"""The most robots or designs that have a name each on the axis."""
_BESIDE_LEGEND = 30
"""Letters of all these names for which there is room beside a legend."""
_APART = 60
"""The most bars with white between them; of more nothing else would be seen."""


def utilisation(
    source: RunData | pd.DataFrame,
    factor: str | None = None,
    *,
    model: Model | None = None,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Draw the share of time in each state, stacked to 1: for each robot of a Run, or each level of a factor.

    Time waiting in traffic is counted apart from the state in which the robot waits.

    Raises:
        ReportError: a table without a factor, or without the `share_*` indicators.
    """
    if isinstance(source, RunData):
        labels, shares, across, over = *_of_run(source), "Robot", ""
    elif factor is None:
        raise ReportError("utilisation of a study table: expected a factor")
    else:
        labels, shares = _of_table(source, factor)
        across = words.factor_label(factor, model.units if model else None)
        over = words.averaged(averaged_over(source, [factor]))
    with look.drawing(ax, style, title, (6.4, 3.8), f"Share of time in each state by {across}") as axes:
        bottom, apart = [0.0] * len(labels), len(labels) <= _APART
        for place, (state, heights) in enumerate(shares.items()):
            axes.bar(
                range(len(labels)),
                heights,
                0.8 if apart else 1.0,
                bottom=bottom,
                label=words.STATE_WORDS[state],
                color=palette.STATE_COLOURS[state],
                hatch=look.HATCHES[place % len(look.HATCHES)] if style == "print" else "",
                edgecolor="white",
                linewidth=0.5 if apart else 0.0,
            )
            bottom = [low + height for low, height in zip(bottom, heights, strict=True)]
        numbered(axes, labels, max(_BESIDE_LEGEND // max(map(len, labels), default=1), 7))
        axes.set_ylim(0, 1)
        axes.grid(visible=False, axis="x")
        axes.set_xlabel(look.text(across + over))
        axes.set_ylabel("Share of time")
        look.in_percent(axes.yaxis)
        look.legend(axes, len(shares), reverse=True)
        return axes


def _of_run(run: RunData) -> tuple[list[str], dict[str, list[float]]]:
    length = run.record.end - run.record.begin
    table = run.robots
    shares = {state: [float(v) / length for v in table[state]] for state in palette.STATE_COLOURS if state in table}
    return [str(number) for number in table.index], shares


def _of_table(table: pd.DataFrame, factor: str) -> tuple[list[str], dict[str, list[float]]]:
    shares = {state: f"share_{state}" for state in palette.STATE_COLOURS if f"share_{state}" in table}
    if not shares:
        raise ReportError("utilisation of a study table: expected the indicators share_idle, share_empty, ...")
    ran = (
        table[list(shares.values())].notna().any(axis="columns")
    )  # a design in which no robot can be in a state has no share of it
    table = table.assign(**{column: table[column].mask(ran & table[column].isna(), 0.0) for column in shares.values()})
    by_state = {state: cells(table, [factor], share) for state, share in shares.items()}
    labels = [", ".join(map(words.level, cell.levels)) for cell in next(iter(by_state.values()))]
    return labels, {state: [cell.estimate.mean for cell in by_level] for state, by_level in by_state.items()}


def numbered(axes: Axes, labels: Sequence[str], most: int = _LABELLED) -> None:
    """Write labels along an axis of bars, only every n-th where there are many."""
    step = -(-len(labels) // most)
    axes.set_xticks(range(0, len(labels), step), [look.text(label) for label in labels[::step]])
    axes.set_xlim(-0.6, max(len(labels), 1) - 0.4)
    if max((len(label) for label in labels), default=0) > 12:  # noqa: PLR2004 - letters that fit side by side
        axes.tick_params(axis="x", labelrotation=25)


def part_shown(
    run: RunData, start: float | None, end: float | None, robots: Sequence[int] | None
) -> tuple[float, float, list[int]]:
    """Return the window and the robots that a figure over time shows.

    Raises:
        ReportError: an empty window, or a robot that is not there.
    """
    begin, until = 0.0 if start is None else start, run.record.end if end is None else end
    if not (is_finite(begin) and is_finite(until) and begin < until):
        raise ReportError(f"window from {shown(begin):.60} to {shown(until):.60}: expected it to have a length")
    size = run.model.fleet.size
    numbers = each(range(size) if robots is None else robots)
    strange = [number for number in numbers if not is_whole(number, 0, size - 1)]
    if strange:
        raise ReportError(f"robot {shown(strange[0]):.60}: there are robots 0 to {size - 1}")
    return begin, until, numbers


def gantt(
    run: RunData,
    *,
    start: float | None = None,
    end: float | None = None,
    robots: Sequence[int] | None = None,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Draw one row for each robot: its states over time, and in black when it waited in traffic (needs `log: all`).

    Args:
        run: the run.
        start: of the window shown, in the model's time unit; default: the start of the run.
        end: of the window; default: the end of the run.
        robots: by number; default: all.

    Raises:
        ReportError: an empty window, or a robot that is not there.
    """
    begin, until, shown = part_shown(run, start, end, robots)
    fleet = run.history.states
    size = (7.2, min(1.4 + 0.26 * len(shown), 12.0))
    about = "States of the robots over time"
    if run.record.level != "all":
        about += " (waits in traffic are not recorded)"
    with look.drawing(ax, style, title, size, about) as axes:
        for row, number in enumerate(shown):
            parts = [s for s in fleet[number] if s.end > begin and s.start < until]
            axes.broken_barh(
                [(s.start, s.end - s.start) for s in parts],
                (row - 0.4, 0.8),
                facecolors=[palette.STATE_COLOURS[s.state] for s in parts],
                linewidth=0,
            )
        _waits(axes, run, shown, begin, until)
        _rows(axes, shown)
        axes.set_xlim(begin, until)
        axes.set_xlabel(look.text(f"Time ({run.model.units.time})"))
        axes.set_ylabel("Robot")
        _key(axes, run)
        return axes


def _waits(axes: Axes, run: RunData, shown: list[int], begin: float, until: float) -> None:
    """Draw bars in the middle of a row while a robot waits: black for other robots."""
    rows = {number: row for row, number in enumerate(shown)}
    spans: dict[tuple[int, str], list[tuple[float, float]]] = {}
    for wait in run.history.waits:
        if wait.robot in rows and wait.end > begin and wait.start < until:
            spans.setdefault((rows[wait.robot], wait.cause), []).append((wait.start, wait.end - wait.start))
    for (row, cause), parts in sorted(spans.items()):
        axes.broken_barh(parts, (row - 0.15, 0.3), facecolors=palette.STATE_COLOURS[cause])


def _rows(axes: Axes, shown: list[int]) -> None:
    step = -(-len(shown) // _LABELLED)
    axes.set_yticks(range(0, len(shown), step), [str(number) for number in shown[::step]])
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")


def _key(axes: Axes, run: RunData) -> None:
    from matplotlib.patches import Patch

    handles = [
        Patch(facecolor=colour, label=words.STATE_WORDS[state])
        for state, colour in palette.STATE_COLOURS.items()
        if state in run.robots
    ]
    look.legend(axes, len(handles), handles=handles)


_NAMED = 8
"""More robots than this are drawn alike, in thin lines."""


def battery(
    run: RunData,
    *,
    start: float | None = None,
    end: float | None = None,
    robots: Sequence[int] | None = None,
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Draw the energy in each robot's battery over time, with the level at which it is sent to charge.

    Args:
        run: the run; corners are exact at every change of state.
        start: of the window shown, in the model's time unit; default: the start of the run.
        end: of the window; default: the end of the run.
        robots: by number; default: all. Up to eight have a colour and a name each.

    Raises:
        ReportError: a model without batteries, an empty window, or a robot that is not there.
    """
    if run.model.battery is None:
        raise ReportError("battery: the robots of this model have none")
    begin, until, shown = part_shown(run, start, end, robots)
    curves = run.history.energy_curves
    specs = [run.history.batteries[number] for number in shown] or run.history.batteries
    few = len(shown) <= _NAMED
    with look.drawing(ax, style, title, (6.4, 3.6), "Energy of the robots over time") as axes:
        for index, number in enumerate(shown):
            times, levels = curves[number]
            if few:
                shape = look.cycle(index) | {"marker": ""}
                axes.plot(times, levels, label=f"robot {number}", linewidth=1.4, **shape)
            else:
                axes.plot(times, levels, color=palette.COLOURS[0], alpha=0.25, linewidth=0.8)
        kinds = (charging.levels(alone) for alone in charging.by_kind(run.model).values())
        sent = dict.fromkeys(limits.critical or limits.good for limits in kinds if limits is not None)
        for number, level in enumerate(filter(None, sent)):
            label = "" if number else "sent to charge"
            axes.axhline(level, color=palette.INK, linestyle="--", linewidth=1, label=label)
        lowest = min(min(curves[number][1]) for number in shown) if shown else 0.0
        axes.set_ylim(min(0.0, lowest) * 1.05, max(spec.capacity for spec in specs) * 1.03)
        axes.set_xlim(begin, until)
        axes.set_xlabel(look.text(f"Time ({run.model.units.time})"))
        axes.set_ylabel("Energy (unit of the capacity)")
        look.legend(axes, len(shown) + 1 if few else 2)
        return axes
