"""The look of figures: two styles, colours that colour-blind readers tell apart, and axes made without pyplot.

For all functions of `plot`, and for the figures of `desim fit`, `warm-up` and `paper`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from desim_warehouse.errors import ReportError, reason
from desim_warehouse.folders import make_folder
from desim_warehouse.look.palette import COLOURS, FAINT, INK
from desim_warehouse.model import Model

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure


Style = Literal["light", "print"]

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
DASHES = ("-", "--", "-.", ":", (0, (5, 1)), (0, (3, 1, 1, 1)), (0, (1, 1)), (0, (7, 2)))
HATCHES = ("", "///", "...", "\\\\\\", "xxx", "---", "+++", "ooo")

_COMMON: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": FAINT,
    "axes.facecolor": "white",
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.facecolor": "white",
    "legend.frameon": False,
    "xtick.color": INK,
    "ytick.color": INK,
    "hatch.linewidth": 0.6,
    "text.usetex": False,
    "svg.fonttype": "none",
}
_STYLES: dict[str, dict[str, Any]] = {
    "light": {
        **_COMMON,
        "font.size": 10,
        "axes.titlesize": 11,
        "legend.fontsize": 9,
        "axes.grid": True,
        "grid.color": "#E6E6E6",
        "grid.linewidth": 0.8,
        "lines.linewidth": 1.8,
        "lines.markersize": 6,
    },
    "print": {
        **_COMMON,
        "font.size": 8,
        "axes.titlesize": 9,
        "legend.fontsize": 7.5,
        "axes.grid": False,
        "axes.edgecolor": INK,
        "axes.linewidth": 0.6,
        "lines.linewidth": 1.2,
        "lines.markersize": 4.5,
        "savefig.dpi": 300,
    },
}
_ACROSS = 3
"""Panels in a row."""
_SHRINK = 0.68
"""Size of a print figure beside a light one: half a page's width."""


def _settings(style: Style) -> dict[str, Any]:
    if style not in _STYLES:
        raise ReportError(f"style {style!r}: expected one of {', '.join(_STYLES)}")
    return _STYLES[style]


@cache
def _axes_class() -> type[Axes]:
    """Return the class of axes that Jupyter shows as a picture, although pyplot does not know them."""
    from matplotlib.axes import Axes as Plain

    class Picture(Plain):
        """Axes with a figure of their own, which Jupyter shows as a picture."""

        def _repr_png_(self) -> tuple[bytes, dict[str, Any]]:
            """Return the whole figure, in twice the density of a screen, with an alternative text."""
            from io import BytesIO

            from matplotlib.transforms import Bbox

            figure = self.get_figure(root=True)
            assert figure is not None
            file = BytesIO()
            figure.draw_without_rendering()
            sheet = Bbox.from_bounds(0, 0, *figure.get_size_inches())
            whole = Bbox.union([sheet, figure.get_tightbbox().padded(0.03)])  # words beside a floor may leave the sheet
            figure.savefig(file, format="png", dpi=180, bbox_inches=whole)
            width, height = whole.size
            return file.getvalue(), {
                "width": round(90 * width),
                "height": round(90 * height),
                "alt": figure.get_label() or "figure",
            }

    return Picture


@contextmanager
def drawing(
    ax: Axes | None, style: Style, title: str | None, size: tuple[float, float], alt: str = ""
) -> Iterator[Axes]:
    """Give axes to draw on, the caller's or new ones in a figure of `size` inches; settings are put back afterwards.

    `alt` is the alternative text; Jupyter and the report pass it on.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    settings: Any = _settings(style)
    with mpl.rc_context(settings):
        if ax is None:
            shrink = _SHRINK if style == "print" else 1.0
            figure = Figure(figsize=(size[0] * shrink, size[1] * shrink), layout="constrained")
            ax = figure.add_subplot(axes_class=_axes_class())
            figure.set_label(alt)
        yield ax
        if title:
            ax.set_title(text(title), loc="left")


@contextmanager
def panels(count: int, style: Style, size: tuple[float, float], alt: str) -> Iterator[list[Axes]]:
    """Give a number of axes side by side, three in a row, in one new figure; `size`: of each, in inches."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    across = min(count, _ACROSS)
    down = -(-count // across)
    settings: Any = _settings(style)
    with mpl.rc_context(settings):
        shrink = _SHRINK if style == "print" else 1.0
        figure = Figure(figsize=(across * size[0] * shrink, down * size[1] * shrink), layout="constrained")
        figure.set_label(alt)
        yield [figure.add_subplot(down, across, place + 1, axes_class=_axes_class()) for place in range(count)]


def text(words: object) -> str:
    """Return a name that matplotlib shows as it is: dollar signs would begin mathematics."""
    return str(words).replace("$", r"\$")


def cycle(index: int) -> dict[str, Any]:
    """Return colour, marker and dash of the n-th line: three ways to tell it from the others."""
    return {
        "color": COLOURS[index % len(COLOURS)],
        "marker": MARKERS[index % len(MARKERS)],
        "linestyle": DASHES[index % len(DASHES)],
    }


def legend(ax: Axes, entries: int, name: str | None = None, **options: Any) -> None:
    """Draw a legend beside the plot; none for a single entry without a name."""
    if entries > 1 or name:
        ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, title=name and text(name), **options)


def in_percent(axis: Axis) -> None:
    """Label an axis of shares in per cent, as `25 %`; no marks beyond 100 %."""
    axis.set_major_formatter(lambda value, _: f"{100 * value:.4g} %" if value < 1 + 1e-9 else "")


def floor_axes(axes: Axes, model: Model, xs: tuple[float, float], ys: tuple[float, float]) -> None:
    """Set the limits of a floor in x and y, downwards as in the model file, both to one scale, in its length unit."""
    axes.set_xlim(*xs)
    axes.set_ylim(ys[1], ys[0])
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set_xlabel(text(f"x ({model.units.length})"))
    axes.set_ylabel(text(f"y ({model.units.length})"))


def save(drawn: Figure | None, folder: Path, name: str) -> None:
    """Write a figure to a folder as PNG and SVG; raises ReportError where that is not possible."""
    assert drawn is not None
    try:
        make_folder(folder)
        for ending in ("png", "svg"):
            drawn.savefig(folder / f"{name}.{ending}", dpi=150)
    except OSError as error:
        raise ReportError(f"{folder}: the figure cannot be written there ({reason(error)})") from error
