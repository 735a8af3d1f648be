"""Films of a run: robots where the log has them, and clear refusals."""

from __future__ import annotations

import shutil
import subprocess
from typing import TYPE_CHECKING

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

import desim_warehouse as dw
from desim_warehouse.errors import ReportError
from desim_warehouse.report.film import FilmFrame, film
from desim_warehouse.report.palette import PALETTES
from desim_warehouse.report.positions import Positions
from tests.report.replay.floors import busy, busy_run, paper_run, people_run, spurs_run

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize("run", [paper_run(), busy_run()], ids=["paper", "busy"])
def test_a_picture_has_robots_goods_and_waiting_where_the_log_has_them(run: dw.Run) -> None:
    picture, where = FilmFrame(Figure().add_subplot(), run), Positions(run.history)
    colours = PALETTES["safe"]["light"]
    for row in [row for row in run.record.rows if row[1] == "collision" and row[6] > 1][:5]:
        time = row[0] - row[6] / 2
        picture.show(time)
        assert np.asarray(picture.robots.get_offsets()) == pytest.approx(where.points(time))
        assert picture.waiting(time)[row[2]]
        assert to_hex(picture.robots.get_edgecolor()[row[2]]) == colours["wait"]
    loads = [row for row in run.record.rows if row[1] == "loaded"]
    time, _, robot, task, *_ = loads[3]
    good = run.history.tasks[task].good
    for moment, mood, colour in ((time - 0.1, "empty", colours["good"]), (time, "loaded", colours["none"])):
        picture.show(moment)
        assert picture.moods(moment)[robot] == mood
        assert to_hex(picture.goods.get_facecolor()[good]) == colour


def test_a_two_way_lane_has_an_arrow_in_its_present_direction() -> None:
    run = spurs_run()
    picture, where = FilmFrame(Figure().add_subplot(), run), Positions(run.history)
    edges, graph = list(run.layout.graph.edges), run.layout.graph
    counts = set()
    for time in np.linspace(20, run.record.end, 40):
        picture.show(float(time))
        on = {edges[edge] for edge in where.at(float(time))[0] if edge < len(edges)}
        used = [edge for edge in edges if edge in on and graph.edges[edge]["two_way"]]
        drawn = picture.used.get_segments()
        assert len(drawn) == 3 * len(used)  # a line and the two sides of an arrow head
        for (source, target), line, head in zip(used, drawn, drawn[len(used) :], strict=False):
            start, end = (np.array([graph.nodes[node]["x"], graph.nodes[node]["y"]]) for node in (source, target))
            assert line == pytest.approx(np.stack([start, end]))
            assert np.dot(head[1] - head[0], end - start) > 0  # it points ahead
        counts.add(len(used))
    assert len(counts) > 1


def test_closed_edges_and_those_with_people_are_thick_lines_while_they_are() -> None:
    run = people_run()
    picture = FilmFrame(Figure().add_subplot(), run)
    colours = PALETTES["safe"]["light"]
    for time in np.linspace(0, run.record.end, 20):
        picture.show(float(time))
        now = [one for one in run.history.blocked if one.start <= time < one.end]
        drawn = zip(picture.shut.get_segments(), picture.shut.get_color(), strict=True)
        for one, (line, colour) in zip(now, drawn, strict=True):
            ends = [run.layout.position(one.edge, at) for at in (0.0, run.layout.length(one.edge))]
            assert line == pytest.approx(np.array(ends))
            assert to_hex(colour) == colours["shut" if one.visit < 0 else "person"]
    picture.show(run.record.end)
    assert f"S {run.S} " in picture.caption.get_text()


def test_the_caption_counts_as_the_run_does() -> None:
    run = busy_run()
    picture = FilmFrame(Figure().add_subplot(), run)
    picture.show(run.record.end)
    assert f"S {run.S} " in picture.caption.get_text()
    assert picture.caption.get_text().endswith(f"delivered {run.kpis['tasks']}")
    assert len(run.history.delivered) > run.kpis["tasks"]


def test_a_gif_has_the_frames_that_its_speed_asks_for(tmp_path: Path) -> None:
    from PIL import Image

    path = film(paper_run(), tmp_path / "film.gif", start=300, end=340, speed=2.0)
    with Image.open(path) as picture:
        assert picture.n_frames == 2 * 12 // 2 + 1  # 40 steps are 2 s, played in one


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_an_mp4_can_be_played(tmp_path: Path) -> None:
    path = film(paper_run(), tmp_path / "film.mp4", start=300, end=340, speed=2.0)
    said = subprocess.run(["ffmpeg", "-i", path, "-f", "null", "-"], capture_output=True, text=True, check=True)
    assert "Video: h264" in said.stderr


def test_an_mp4_without_ffmpeg_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ReportError, match="needs the program ffmpeg"):
        film(paper_run(), tmp_path / "film.mp4")


@pytest.mark.parametrize(
    ("name", "options", "fault"),
    [
        ("film.avi", {}, r"ends in \.gif or \.mp4"),
        ("film.gif", {"speed": 0.0}, "expected a number above 0"),
        ("film.gif", {"speed": 0.001}, "more than 3000"),
        ("film.gif", {"palette": "grey"}, "'grey' is not known"),
        ("film.gif", {"start": 10.0, "end": 10.0}, "shows nothing"),
        ("nowhere/film.gif", {"start": 0, "end": 10.0, "speed": 1.0}, "cannot be written"),
    ],
)
def test_what_cannot_be_filmed_is_refused(tmp_path: Path, name: str, options: dict[str, float], fault: str) -> None:
    with pytest.raises(ReportError, match=fault):
        film(paper_run(), tmp_path / name, **options)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_names_with_signs_of_formulas_are_text(tmp_path: Path) -> None:
    run = dw.simulate(dw.load(busy(name="$\\alpha <b>", run={"length": 20.0})))
    assert film(run, tmp_path / "film.gif", speed=20.0).stat().st_size > 0
