"""Where robots wait: a map of the floor, coloured by waiting on each edge and before each intersection."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from desim_warehouse.errors import ReportError
from desim_warehouse.report import palette
from desim_warehouse.report.plot import floor as plan
from desim_warehouse.report.plot import style as look

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from networkx import DiGraph

    from desim_warehouse.run import Run

By = Literal["blocked", "waits"]


def congestion(
    run: Run,
    *,
    by: By = "blocked",
    title: str | None = None,
    style: look.Style = "light",
    ax: Axes | None = None,
) -> Axes:
    """Waiting in the counted part of a run: edges where robots stood behind others, intersections they stood before.

    Args:
        run: the run, at any level of log.
        by: "blocked" colours by time waited, "waits" by waiting episodes. Width and size show it, too.
    """
    if by not in ("blocked", "waits"):
        raise ReportError(f"by {by!r}: expected blocked or waits")
    floor, step = run.layout, plan.step_of(run.layout)
    on_edge = edge_values(run, by)
    at_node = node_values(run, by)
    top = max([*on_edge.values(), *at_node.values(), 0.0]) or 1.0
    what = f"Time waited ({run.model.units.time})" if by == "blocked" else "Waiting episodes"
    with look.drawing(ax, style, title, plan.size_of(floor), f"{what} on each edge and at each node") as axes:
        plan.draw_goods(axes, floor, step, set())
        _edges(axes, run, on_edge, step, top)
        _nodes(axes, run, at_node, top)
        plan.frame(axes, floor, step, run.model)
        _bar(axes, what, top)
        return axes


def edge_values(run: Run, by: By) -> dict[tuple[str, str], float]:
    """Waiting on each lane, behind other robots; in both directions of a two-way one."""
    column, edges = run.edges[by], run.layout.graph.edges
    return {
        (a, b): float(column[f"{a}>{b}"] + (column[f"{b}>{a}"] if edges[a, b].get("two_way") else 0))
        for a, b in run.layout.lanes
    }


def node_values(run: Run, by: By) -> dict[str, float]:
    """Waiting before each intersection; nodes so near one another that they are crossed as one share theirs."""
    values = dict.fromkeys(run.layout.graph, 0.0)
    for key, value in run.nodes[by].items():
        for name in _members(str(key), run.layout.graph):
            values[name] = float(value)
    return values


def _members(key: str, graph: DiGraph) -> list[str]:
    """The nodes of an intersection written `A+B`, whatever characters the names have."""
    if key in graph:
        return [key]
    for name in graph:
        if key.startswith(f"{name}+"):
            rest = _members(key[len(name) + 1 :], graph)
            if rest:
                return [name, *rest]
    return []


def _edges(axes: Axes, run: Run, values: dict[tuple[str, str], float], step: float, top: float) -> None:
    from matplotlib.collections import LineCollection

    lines = [plan.ends(run.layout, edge, step) for edge in values]
    plan.arrows(axes, [plan.ends(run.layout, edge, step) for edge in run.layout.graph.edges], palette.FAINT)
    shown = LineCollection(lines, cmap=_map(), zorder=2)
    shown.set_array(list(values.values()))
    shown.set_clim(0, top)
    shown.set_linewidth([1.2 + 5.0 * value / top for value in values.values()])
    axes.add_collection(shown)


def _nodes(axes: Axes, run: Run, values: dict[str, float], top: float) -> None:
    graph = run.layout.graph
    small = 30 if len(graph) <= 60 else 4  # noqa: PLR2004 - as in the layout drawing
    axes.scatter(
        [graph.nodes[name]["x"] for name in values],
        [graph.nodes[name]["y"] for name in values],
        s=[small + 320 * value / top for value in values.values()],
        c=list(values.values()),
        cmap=_map(),
        vmin=0,
        vmax=top,
        edgecolors=palette.INK,
        linewidths=0.6,
        zorder=3,
    )
    if small == 30:  # noqa: PLR2004 - few nodes: room for names
        for name in values:
            axes.annotate(
                look.text(name if len(name) <= 6 else f"{name[:5]}…"),  # noqa: PLR2004 - short enough
                (graph.nodes[name]["x"], graph.nodes[name]["y"]),
                xytext=(8, 8),
                textcoords="offset points",
                fontsize="x-small",
                zorder=4,
            )


def _map() -> Colormap:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("waiting", palette.WAITED)


def _bar(axes: Axes, what: str, top: float) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.colorbar(ScalarMappable(Normalize(0, top), _map()), ax=axes, label=look.text(what), shrink=0.7)
