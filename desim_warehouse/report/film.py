"""Films of a run for slides: GIF or MP4, drawn with matplotlib from the same positions as the replay page."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from desim_warehouse.errors import ReportError
from desim_warehouse.outcome.log import NONE
from desim_warehouse.report.palette import GROUND, PALETTES
from desim_warehouse.report.positions import Positions
from desim_warehouse.report.replay import window
from desim_warehouse.report.zones import robot_radii

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from desim_warehouse.run import Run

FRAMES_PER_SECOND = {".gif": 12, ".mp4": 25}
SECONDS = 20.0
"""The length of a film unless a speed is given."""
MOST_FRAMES = 3000
MOST_NUMBERS, MOST_LETTERS = 30, 60
"""The most robots and nodes with labels; more would not be legible."""


def film(
    run: Run,
    path: str | Path,
    *,
    start: float | None = None,
    end: float | None = None,
    speed: float | None = None,
    palette: str = "safe",
) -> Path:
    """Write a film of a run, or of a window of it, to a .gif or .mp4 file.

    Args:
        run: a run with `log: all`.
        path: where to; the ending says which kind.
        start: first moment shown, in the model's time unit; default: the start of the run.
        end: last moment shown; default: the end of the run.
        speed: times real time; default: so that the film lasts 20 s.
        palette: `safe` for colour-blind people, or `paper`.

    Raises:
        ReportError: for another ending, an empty window, a film too long, or an MP4 where there is no ffmpeg.
    """
    from matplotlib.figure import Figure

    path = Path(path)
    kind = _kind(path)
    if palette not in PALETTES:
        raise ReportError(f"palette: {palette!r} is not known; expected one of {', '.join(PALETTES)}")
    times = _moments(run, start, end, speed, FRAMES_PER_SECOND[kind])
    figure = Figure(figsize=(8, 6), dpi=100, layout="constrained")
    picture = FilmFrame(figure.add_subplot(), run, palette)
    writer = _writer(kind)
    try:
        with writer.saving(figure, str(path), dpi=100):
            for time in times:
                picture.show(time)
                writer.grab_frame()
    except OSError as error:
        raise ReportError(f"{path}: the film cannot be written ({error.strerror or error})") from error
    return path


def _kind(path: Path) -> str:
    """The ending of a film's name, of those that can be written here."""
    kind = path.suffix.lower()
    if kind not in FRAMES_PER_SECOND:
        raise ReportError(f"{path}: a film ends in .gif or .mp4")
    if kind == ".mp4" and shutil.which("ffmpeg") is None:
        raise ReportError(f"{path}: an MP4 needs the program ffmpeg, which is not installed; a .gif does not")
    return kind


def _moments(run: Run, start: float | None, end: float | None, speed: float | None, rate: int) -> list[float]:
    """The times of the frames, the last one included."""
    begin, finish = window(run.history, start, end)
    real = (finish - begin) * run.model.units.seconds
    if speed is not None and not (math.isfinite(speed) and speed > 0):
        raise ReportError(f"speed: {speed:g}, expected a number above 0")
    frames = max(round((SECONDS if speed is None else real / speed) * rate), 1)
    if frames > MOST_FRAMES:
        raise ReportError(
            f"the film would have {frames} frames, more than {MOST_FRAMES}: choose a shorter window or a higher speed"
        )
    return [float(time) for time in np.linspace(begin, finish, frames + 1)]


def _writer(kind: str) -> Any:
    from matplotlib.animation import FFMpegWriter, PillowWriter

    rate = FRAMES_PER_SECOND[kind]
    return PillowWriter(fps=rate) if kind == ".gif" else FFMpegWriter(fps=rate)


class FilmFrame:
    """The warehouse at one time on matplotlib axes; `show` moves it to another."""

    def __init__(self, axes: Axes, run: Run, palette: str = "safe") -> None:
        self.axes = axes
        self.run = run
        self.colours = GROUND["light"] | PALETTES[palette]["light"]
        self.positions = Positions(run.history)
        self.history = run.history
        self.radii = np.array(robot_radii(run.model))
        self.state_times = [np.array([span.start for span in changes]) for changes in self.history.changes]
        self._draw_floor()
        if self.history.blocked:
            from matplotlib.collections import LineCollection

            self.shut = LineCollection([], linewidths=5, alpha=0.5)
            self.axes.add_collection(self.shut)
        self._add_robots()

    def show(self, time: float) -> None:
        """Move robots and goods to where they are at a time."""
        points = self.positions.points(time)
        headings = self.positions.headings(time)
        self.robots.set_offsets(points)
        self.robots.set_facecolor([self.colours[mood] for mood in self.moods(time)])
        waiting = self.waiting(time)
        self.robots.set_edgecolor([self.colours["wait"] if wait else self.colours["outline"] for wait in waiting])
        self.robots.set_linewidth([2.5 if wait else 0.8 for wait in waiting])
        noses = np.stack([np.cos(headings), np.sin(headings)], axis=1) * self.radii[:, None]
        self.heads.set_segments(list(np.stack([points + 0.6 * noses, points + 1.5 * noses], axis=1)))
        for number, (x, y) in zip(self.numbers, points, strict=False):
            number.set_position((x, y))
        self.goods.set_facecolor(self._goods(time))
        self._show_directions(self.positions.at(time)[0])
        self._show_blocked(time)
        done = sum(1 for task in self.history.counted_deliveries if task.delivered <= time)
        counted = sum(1 for wait in self.history.collisions if self.history.counts(wait.end) and wait.end <= time)
        unit = self.run.model.units
        self.caption.set_text(f"{time:.0f} {unit.time} ({time * unit.seconds:.0f} s)   S {counted}   delivered {done}")

    def _show_blocked(self, time: float) -> None:
        """Edges that are closed, or have people in them, as thick lines."""
        if not self.history.blocked:
            return
        now = [one for one in self.history.blocked if one.start <= time < one.end]
        self.shut.set_segments([[self.run.layout.position(one.edge, at) for at in self._ends(one.edge)] for one in now])
        self.shut.set_color([self.colours["shut" if one.visit == NONE else "person"] for one in now])

    def _ends(self, edge: tuple[str, str]) -> tuple[float, float]:
        return 0.0, self.run.layout.length(edge)

    def moods(self, time: float) -> list[str]:
        """The colour of every robot at a time."""
        moods: list[str] = []
        for changes, times in zip(self.history.changes, self.state_times, strict=True):
            span = changes[max(int(np.searchsorted(times, time, side="right")) - 1, 0)]
            moods.append(span.seen.role)
        return moods

    def waiting(self, time: float) -> list[bool]:
        """Whether each robot waits at a time."""
        result = [False] * len(self.radii)
        for wait in self.history.waits:
            if wait.start <= time < wait.end:
                result[wait.robot] = True
        return result

    def _goods(self, time: float) -> list[str]:
        colours = [self.colours["none"]] * len(self.run.layout.storage)
        for task in self.history.tasks.values():
            if task.good >= 0 and task.released <= time < task.loaded:
                colours[task.good] = self.colours["good"]
        return colours

    def _draw_floor(self) -> None:
        from matplotlib.collections import LineCollection, PatchCollection
        from matplotlib.patches import Rectangle

        axes, run, edges = self.axes, self.run, self.positions.edges
        axes.set_aspect("equal")
        axes.set_axis_off()
        numbers = np.arange(edges.real)
        for some, style in ((edges.twin < 0, "solid"), (edges.twin > numbers, "dashed")):
            lines = np.stack([edges.start[: edges.real][some], edges.end[: edges.real][some]], axis=1)
            axes.add_collection(
                LineCollection(list(lines), colors=self.colours["aisle"], linewidths=0.8, linestyles=style, zorder=1)
            )
        self.used = LineCollection([], colors=self.colours["border"], linewidths=1.5, zorder=1)
        axes.add_collection(self.used)
        one_way = numbers[edges.twin < 0]
        middle, way = (edges.start + edges.end)[one_way] / 2, (edges.end - edges.start)[one_way]
        angles = np.degrees(np.arctan2(way[:, 1], way[:, 0]))
        for (x, y), angle in zip(middle, angles, strict=True):
            axes.plot(x, y, marker=(3, 0, -angle - 90), color=self.colours["border"], markersize=5, zorder=1)
        size = run.layout.goods_size or 1.3 * float(self.radii.max())
        squares = [
            Rectangle((place.x - 0.47 * size, place.y - 0.47 * size), 0.94 * size, 0.94 * size)
            for place in run.layout.storage
        ]
        self.goods = PatchCollection(squares, zorder=0)
        axes.add_collection(self.goods)
        if run.layout.graph.number_of_nodes() <= MOST_LETTERS:
            for name, data in run.layout.graph.nodes(data=True):
                axes.annotate(name, (data["x"], data["y"]), (6, 6), textcoords="offset points", size=8)
        self._frame(size)

    def _show_directions(self, on: NDArray[np.int64]) -> None:
        """Two-way lanes in use are solid, with an arrow in their present direction: that of the robots on them."""
        edges = self.positions.edges
        used = np.unique(on[on < edges.real])
        used = used[edges.twin[used] >= 0]
        start, way = edges.start[used], edges.end[used] - edges.start[used]
        long = np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-9)[:, None]
        middle, along = start + way / 2, way / long * float(self.radii.max())
        aside = along[:, ::-1] * (-0.7, 0.7)
        heads = [np.stack([middle - along + side, middle + along], axis=1) for side in (aside, -aside)]
        self.used.set_segments([*np.stack([start, start + way], axis=1), *heads[0], *heads[1]])

    def _frame(self, size: float) -> None:
        edges, storage = self.positions.edges, self.run.layout.storage
        goods = np.array([(place.x, place.y) for place in storage]).reshape(-1, 2)
        points = np.concatenate([edges.start, edges.end, goods - size / 2, goods + size / 2])
        air = 2 * float(self.radii.max())
        (left, top), (right, bottom) = points.min(axis=0) - air, points.max(axis=0) + air
        self.axes.set_xlim(left, right)
        self.axes.set_ylim(bottom, top)
        self.caption = self.axes.set_title(self.run.model.name, fontsize=10, parse_math=False)

    def _add_robots(self) -> None:
        from matplotlib.collections import EllipseCollection, LineCollection

        size = 2 * self.radii
        self.robots = EllipseCollection(
            size, size, np.zeros(len(size)), units="xy", offsets=np.zeros((len(size), 2)),
            transOffset=self.axes.transData, zorder=3,
        )  # fmt: skip
        self.heads = LineCollection([], colors=self.colours["outline"], linewidths=1.5, zorder=4)
        self.axes.add_collection(self.robots)
        self.axes.add_collection(self.heads)
        shown = len(size) if len(size) <= MOST_NUMBERS else 0
        style: dict[str, Any] = {"ha": "center", "va": "center_baseline", "color": "white", "size": 7, "zorder": 5}
        self.numbers = [self.axes.text(0, 0, str(robot), **style) for robot in range(shown)]
