"""The report: made of every study, needs nothing from outside, and its numbers are the table's."""

import re
import subprocess
import sys
import warnings
import zipfile
from html.parser import HTMLParser
from pathlib import Path

import nbformat
import pytest
from click.testing import CliRunner
from nbclient import NotebookClient

import desim_warehouse as dw
from desim_warehouse.answer import numbers, words
from desim_warehouse.answer.answer import Answer
from desim_warehouse.answer.page import page as page_of
from desim_warehouse.answer.parts import Folded
from desim_warehouse.cli import desim
from desim_warehouse.errors import ReportError
from desim_warehouse.folders import gallery
from desim_warehouse.outcome.account import OF_TASKS
from desim_warehouse.questions.run import drawings as svg
from desim_warehouse.questions.run import page as run_parts
from desim_warehouse.questions.run import words as run_words
from desim_warehouse.questions.run.drawings import account
from desim_warehouse.questions.run.warehouse import facts, work
from desim_warehouse.report.example import example
from desim_warehouse.report.write import report, template
from tests.lasting import LASTING
from tests.world.test_flows import RING
from tests.world.test_hours import SQUARE

ROOT = Path(__file__).parents[2]
ADDRESSES = {"src", "href", "srcset", "data", "action", "poster", "background", "xlink:href"}


class Page(HTMLParser):
    """What a page asks a browser for, its tables, its text and its pictures."""

    def __init__(self, source):
        super().__init__()
        self.tags, self.addresses, self.pictures, self.styles = [], [], [], []
        self.tables, self.text, self.inside = {}, "", ""
        self.row, self.cell, self.table = None, None, None
        self.feed(source)

    def handle_starttag(self, tag, attrs):
        facts = dict(attrs)
        self.tags.append(tag)
        self.inside = tag if tag in ("style", "script") else self.inside
        self.addresses += [value for name, value in attrs if name in ADDRESSES]
        self.styles += [facts["style"]] if "style" in facts else []
        if tag == "img":
            self.pictures.append(facts)
        if tag == "table":
            self.table = self.tables.setdefault(facts.get("id", ""), [])
        if tag == "tr":
            self.row = []
        if tag in ("td", "th"):
            self.cell = ""

    def handle_endtag(self, tag):
        if tag in ("td", "th"):
            self.row.append(self.cell)
            self.cell = None
        if tag == "tr":
            self.table.append(self.row)
        if tag == self.inside:
            self.inside = ""

    def handle_data(self, data):
        if self.inside:
            self.styles.append(data)
        else:
            self.text += data
        if self.cell is not None:
            self.cell += data


def needs_nothing_from_outside(source):
    page = Page(source)
    assert not {"script", "iframe", "object", "embed", "base"} & set(page.tags)
    assert all(address.startswith(("data:", "#")) for address in page.addresses)
    assert not any(re.search(r"url\(|@import|://", style) for style in page.styles)
    assert "default-src 'none'" in source
    return page


def shown_by(notebook):
    """What a notebook shows: its HTML, and the words of its pictures."""
    client = NotebookClient(notebook, timeout=120, kernel_name="python3")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the notebook libraries, about one another
        client.execute()
    outputs = [output.get("data", {}) | {"of": output} for cell in notebook.cells for output in cell.get("outputs", [])]
    pages = [data["text/html"] for data in outputs if "text/html" in data]
    return pages, [data["of"].metadata["image/png"]["alt"] for data in outputs if "image/png" in data]


def test_a_run_has_a_report_of_its_own(lifelong, tmp_path):
    folder = lifelong.save(tmp_path / "run")
    out = tmp_path / "pages" / "run.html"
    done = CliRunner().invoke(desim, ["report", str(folder), "-o", str(out)], catch_exceptions=False)
    assert done.output.strip() == str(out)
    page = needs_nothing_from_outside(out.read_text(encoding="utf-8"))
    shown = {row[2]: row[1] for row in page.tables["all-indicators"][1:]}
    assert shown == {key: words.value(key, value, lifelong.model) for key, value in lifelong.kpis.items()}
    lost = lifelong.lost_time
    assert [row[1] for row in page.tables["what-robots-waited-for"][1:]] == [
        numbers.duration(time, lifelong.model.units.time) for time in lost["time"][lost["share"] >= 0.001][:10]
    ]
    assert page.pictures == []  # floor and robots are drawn
    parts = lifelong.account("task").mean()
    unit = lifelong.model.units.time
    most = f"{numbers.times(unit, [parts.max()]).value(parts.max())} · {100 * parts.max() / parts.sum():.0f} %"
    assert OF_TASKS[parts.idxmax()].doing in page.text
    assert most in page.text
    waits = numbers.PERCENT.value(lifelong.kpis["share_waiting"])
    assert f"Where robots wait: {waits} of their time" in page.text


def test_a_floor_of_many_lanes_is_a_picture(lifelong, monkeypatch):
    assert "<svg" in svg.floor(lifelong)
    monkeypatch.setattr(svg, "_LANES", 20)
    assert "<img" in svg.floor(lifelong)


def test_a_run_whose_log_has_no_waits_has_no_account(model):
    assert account(dw.simulate(model.replace({"log": "tasks"}))) is None


def test_the_account_is_of_robots_where_nothing_was_asked_of_them(model):
    run = dw.simulate(model.replace({"tasks.goods": {"poisson": 1e-9}, "run.length": 100}))
    shown = account(run)
    assert shown.title == "Where the 100 steps of a robot go, mean of 6 robots"
    assert [row.text for row in shown.rows] == ["100 steps · 100 %"]


def test_the_figure_of_the_warm_up_is_of_runs_that_have_one(model):
    lifelong = model.replace({"tasks.goods": {"saturated": 12}, "run": {"length": 10_000, "warm_up": 500}})
    assert len(run_parts.warm_up_figures(dw.simulate(lifelong))) == 1
    assert run_parts.warm_up_figures(dw.simulate(lifelong.replace({"run.warm_up": 0}))) == []


def test_what_a_run_s_report_says_is_counted_as_its_indicators_are(model):
    """After a warm-up of 500, 1500 of 2000 are counted, in the sentence, the table, the places and at the stations."""

    run = dw.simulate(model.replace({"tasks.goods": {"saturated": 12}, "run": {"length": 2000, "warm_up": 500}}))
    kpis = run.kpis
    assert kpis["throughput_per_hour"] == pytest.approx(kpis["tasks"] / (1500 * run.model.units.seconds / 3600))
    sentence = f"{kpis['tasks']} loads delivered in 1,500 steps (75 s) after a warm-up of 500 steps, "
    assert f"{sentence}{numbers.measured(kpis['throughput_per_hour'])} an hour." in run_words.sentences(run)[0]
    shown = {row[2]: row[1] for row in run_parts.indicators(run).rows}
    assert shown == {key: words.value(key, value, run.model) for key, value in kpis.items()}
    assert run.edges["waits"].sum() + run.nodes["waits"].sum() == kpis["S"]
    assert len(run.history.counted_deliveries) == kpis["tasks"] < len(run.history.delivered)


def test_one_task_is_not_tasks():
    flow = {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 0, "tasks": 1}]}}
    run = dw.simulate(dw.load(RING, {"tasks.flows": {"work": flow}}))
    assert run_words.sentences(run)[0] == "1 load delivered in 1.5 min, 40 an hour."


def test_the_work_of_flows_is_what_the_demand_makes_of_it():
    ends = {"from": "dock", "to": "pack"}
    flows = {
        "steady": {**ends, "arrivals": {"poisson": 20}},
        "day": {**ends, "arrivals": {"profile": {"per_hour": [10, 30]}}},
        "lorry": {**ends, "arrivals": {"schedule": [{"at": 0, "tasks": 7}, {"at": 60, "tasks": 8}]}},
        "always": {**ends, "arrivals": {"saturated": 2}},
    }
    model = dw.load(RING, {"tasks.flows": flows, "tasks.demand": 1.5, "run.length": 3600})
    assert [line.rpartition(", ")[2] for line in work(model).split("; ")] == [
        "30 tasks an hour",
        "15 to 45 tasks an hour by a profile",
        "22 tasks by a schedule",
        "2 tasks always open",
    ]


def test_a_run_that_logged_little_is_simulated_again_for_its_account(model, tmp_path):

    run = dw.simulate(model.replace({"log": "tasks"}))
    again = run_parts.read(run.save(tmp_path))
    assert again.record.level == "all"
    assert again.kpis == pytest.approx(run.kpis, nan_ok=True)


@pytest.mark.long
def test_the_notebook_makes_a_small_study_and_shows_its_runs_as_a_table():
    made = nbformat.read(template(), as_version=4)
    nbformat.validate(made)
    code = [cell for cell in made.cells if cell.cell_type == "code"]
    assert not any(cell.outputs or cell.execution_count for cell in code)
    assert code[0].metadata["tags"] == ["parameters"]
    assert made.cells[0].source.startswith("# ")
    pieces, pictures = shown_by(made)
    differences, means, runs, page = pieces
    assert [piece.count("<tr") - 1 for piece in (differences, runs)] == [4, 40]
    assert all(name in differences for name in ("fleet.size", "nearest", "difference_low", "difference_high"))
    assert all(name in means for name in ("fleet.size", "nearest", "<td>T</td>", "low", "high"))
    assert "iframe" in page
    assert len(pictures) == 3
    source = "\n".join(cell.source for cell in code)
    assert set(re.findall(r"import (\S+)", source)) == {"tempfile", "Path", "display", "desim_warehouse"}


@pytest.mark.long
@pytest.mark.parametrize("make", ["run", "search"])
def test_the_notebook_opens_the_folder_of_a_run_and_of_a_search(make, tmp_path):
    folder = tmp_path / "folder"
    if make == "run":
        dw.simulate(example()).save(folder)
    else:
        dw.best(
            example(),
            "throughput_per_hour",
            vary={"fleet.size": [1, 2]},
            target="on_time >= 50 %",
            search=dw.Search(runs=50, out=folder),
        )
    report(folder, notebook=tmp_path / "it.ipynb")
    made = nbformat.read(tmp_path / "it.ipynb", as_version=4)
    pieces, pictures = shown_by(made)
    assert any("throughput_per_hour" in piece for piece in pieces)
    assert pictures


@pytest.mark.parametrize("folder", [pytest.param(None, marks=pytest.mark.long), "run"])
def test_the_code_of_the_notebook_goes_through(folder, tmp_path, monkeypatch):
    """For a small study of its own, and for a run: in this process, as the start of a kernel takes seconds."""
    made, shown, names = template(), [], {}
    if folder is not None:
        dw.simulate(example().replace(LASTING)).save(tmp_path / folder)
        report(tmp_path / folder, notebook=tmp_path / "it.ipynb")
        made = tmp_path / "it.ipynb"
    monkeypatch.setattr("IPython.display.display", shown.append)
    for cell in nbformat.read(made, as_version=4).cells:
        if cell.cell_type == "code":
            exec(cell.source, names)  # noqa: S102 - our own notebook
    assert len(shown) == (3 if folder is None else 1)
    if folder is None:
        assert (len(names["table"]), len(names["runs"])) == (4, 40)
    else:
        assert "throughput_per_hour" in names["means"].index
    assert (Path(names["folder"]) / "report.html").is_file()


def test_the_wheel_has_the_templates_and_the_gallery(tmp_path):
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)],
        cwd=ROOT,
        check=True,
        capture_output=True,
    )
    (wheel,) = tmp_path.glob("*.whl")
    inside = set(zipfile.ZipFile(wheel).namelist())
    assert "desim_warehouse/notebooks/report.ipynb" in inside
    assert {f"desim_warehouse/gallery/{name}.yaml" for name in gallery()} <= inside
    assert {f"desim_warehouse/look/templates/{name}" for name in ("page.html", "figures.html", "report.css")} <= inside


def test_folders_without_anything_to_report_are_refused(tmp_path):
    with pytest.raises(ReportError, match="neither an answer, nor a study, nor a run"):
        report(tmp_path)
    (tmp_path / "study.json").write_text("{")
    with pytest.raises(ReportError, match="cannot be read"):
        report(tmp_path)


def test_a_folder_with_files_missing_or_damaged_is_one_message(study_folder, tmp_path):
    (tmp_path / "study.json").write_bytes((study_folder / "study.json").read_bytes())
    with pytest.raises(ReportError, match=r"results\.parquet"):
        report(tmp_path)
    other = tmp_path / "plan"
    other.mkdir()
    (other / "plan.json").write_text('{"today": null, "grown": null}')
    with pytest.raises(ReportError, match="damaged"):
        report(other)
    run = tmp_path / "file"
    run.write_text("x")
    with pytest.raises(ReportError, match="cannot be made"):
        report(study_folder, run / "page.html")


def test_a_section_in_which_there_is_nothing_is_left_out():
    tables = Folded(title="Empty", head=("x",)), Folded(title="Full", rows=(("x",),)), Folded(title="None")
    answer = Answer(kind="t", name="t", question="t?", answer=("t.",), tables=tables, runs=0, confidence=None)
    page = page_of(answer, {"Empty": [], "Nowhere": []})
    assert re.findall("<summary>(.*)</summary>", page) == ["Full", "See it again"]


def test_the_facts_of_a_model_say_who_keeps_which_hours_and_what_goes_wrong():
    over = {
        "calendars": {
            "day": {"open": ["06:00-14:00"], "breaks": ["09:00-09:15"], "days": ["mon", "tue"]},
            "wash": {"every": 3600, "lasts": 360, "first": 60},
            "once": {"between": [[0, 60], [90, 120]]},
        },
        "fleet.hours": "day",
        "layout.stations.desk.hours": "wash",
        "layout.stations.desk.at_close": "pause",
        "tasks.goods": {"poisson": 20, "hours": "once"},
        "traffic.closures": {"gate": {"members": [["A", "B"]], "hours": "wash"}},
        "run.length": 36_000,
        "run.start": "06:00",
    }
    values = [value for _, value in facts(dw.load(SQUARE, over))]
    for value in (
        "robots: day, 06:00-14:00 without 09:00-09:15 on mon, tue",
        "station desk: wash, 360 of every 3600 s, from 60 on; what has begun pauses",
        "tasks: once, 0 to 60, 90 to 120 s",
        "the lanes of gate are closed for 10 % of the time",
        "10 h, begun at 06:00",
    ):
        assert value in values
    assert not {"Hours", "What goes wrong"} & {name for name, _ in facts(dw.load(SQUARE))}


def test_the_facts_of_a_model_name_its_pickers_lifts_and_wide_aisles():
    """Two pickers on a floor with wide aisles, at work in the morning, and a mezzanine with two lifts."""
    picked = {
        "name": "shop",
        "calendars": {"morning": {"open": ["08:00-12:00"]}},
        "layout": {
            "blocks": {
                "columns": 2,
                "rows": 1,
                "block_width": 2,
                "block_depth": 4,
                "goods_size": 1.2,
                "aisle_width": 4.2,
                "directions": "ring",
            },
            "aisles": "wide",
            "bays": {"home": {"at": ["A"]}},
            "stations": {"desk": {"at": ["C"]}},
        },
        "fleet": {"size": 1, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1}},
        "tasks": {"goods": {"poisson": 20}, "load_time": 10, "unload_time": 5, "unload_at": ["desk"]},
        "pickers": {"count": 2, "speed": 1, "zones": 2, "hours": "morning"},
        "run": {"length": "1 h", "start": "08:00"},
    }
    rows = facts(dw.load(picked))
    assert dict(rows)["Floor"].endswith(", all aisles wide")
    assert ("Pickers", "2, speed 1 m per s, 2 zones") in rows
    assert ("Hours", "pickers: morning, 08:00-12:00") in rows
    assert "Lift" not in dict(rows)
    lifts = [value for name, value in facts(dw.load(ROOT / "models" / "gallery" / "mezzanine.yaml")) if name == "Lift"]
    assert lifts == ["goods: 2 cabins, 8 s per floor, doors 3 s"]


def test_the_first_page_of_a_run_has_large_numbers(tmp_path, lifelong):
    tiles = run_words.numbers_of(lifelong)
    assert tiles[0].what == "loads an hour"
    page = report(lifelong, tmp_path / "run.html").read_text(encoding="utf-8").partition("<details")[0]
    assert all(f"<dt>{tile.what}</dt><dd>{tile.value}" in page for tile in tiles)
    assert run_words.waited(lifelong)[0] in Page(page).text.replace("\u00a0", " ")
