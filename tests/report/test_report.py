"""The report: made of every study, needs nothing from outside, and its numbers are the table's."""

from __future__ import annotations

import base64
import dataclasses
import math
import re
import subprocess
import sys
import warnings
import zipfile
from html.parser import HTMLParser
from pathlib import Path

import nbformat
import pandas as pd
import pytest
from click.testing import CliRunner
from nbclient import NotebookClient

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ReportError
from desim_warehouse.outcome.account import OF_TASKS
from desim_warehouse.report import html, run_parts, study_parts
from desim_warehouse.report.model_parts import model_facts, work
from desim_warehouse.report.page import ReportPage, example
from desim_warehouse.report.study_parts import read
from desim_warehouse.report.text import answers, numbers, run_words, words
from desim_warehouse.report.text.numbers import Scale
from desim_warehouse.report.text.sentences import conclusions
from desim_warehouse.report.write import report, template
from desim_warehouse.shipped import gallery
from desim_warehouse.study.statistics import estimate
from desim_warehouse.study.study import Study
from tests.world.test_flows import RING
from tests.world.test_hours import SQUARE

ROOT = Path(__file__).parents[2]
STUDIES = sorted((ROOT / "studies").glob("*.yaml"))
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


@pytest.fixture(scope="module")
def made(study_folder, tmp_path_factory):
    """The report of the study: the page, and its notebook beside it."""
    kept = tmp_path_factory.mktemp("kept") / "kept.ipynb"
    path = report(study_folder, notebook=kept)
    assert path == study_folder / "report.html"
    return path.read_text(encoding="utf-8"), nbformat.read(kept, as_version=4)


@pytest.fixture(scope="module")
def page(made):
    return needs_nothing_from_outside(made[0])


def test_the_results_are_those_of_the_table(page, study_folder):
    table = pd.read_parquet(study_folder / "results.parquet")
    head, *rows = page.tables["results"]
    assert head[:3] == ["Number of robots", "Goods", "runs"]
    assert head[3:5] == ["Task time (step)", "Waits for another robot"]
    assert len(rows) == 6
    for size, goods, count, time, collisions, *_ in rows:
        runs = table[(table["fleet.size"] == int(size)) & (table["tasks.goods"] == goods)]
        assert int(count) == len(runs) == 3
        known = {"deterministic": bool(runs["deterministic"].all()), "within": (0.0, math.inf)}
        assert time == Scale().cell(estimate(runs["T"].tolist(), **known))
        assert collisions == Scale().cell(estimate(runs["S"].tolist(), **known))


def test_the_conclusions_on_the_page_are_the_statistics(page, study_folder):
    lines = conclusions(read(study_folder))
    assert len(lines) >= 2
    for line in lines:
        assert line in page.text
    study = Study.open(study_folder)
    told = [row for row in study.compare("T").differences if row.differs and row.estimate.mean < 0]
    most = min(told, key=lambda row: row.estimate.mean).estimate
    assert f"by {Scale().cell(dataclasses.replace(most, mean=-most.mean))} steps" in "\n".join(lines)
    assert f"in {len(told)} of 5 designs" in "\n".join(lines)


def test_the_comparison_on_the_page_is_the_studys(page, study_folder):
    found = Study.open(study_folder).compare("T").differences
    _, *rows = page.tables["comparison-T"]
    assert [tuple(row[1:]) for row in rows] == [Scale().difference(item) for item in found]


def test_hostile_names_are_shown_as_text(page):
    name = "<script>alert(1)</script> & “quotes” مستودع $x$"
    assert page.text.count(name) >= 1
    assert any('<script>alert("1")</script>' in row for row in page.tables["results"])
    assert any("$\\frac{مستودع}$ 'x' & <b>" in row for row in page.tables["results"])
    assert "b" not in page.tags


def test_every_figure_is_a_picture_with_words(page):
    alts = [picture["alt"] for picture in page.pictures]
    assert "Layout of MultiBots" in alts
    assert "Task time by number of robots and goods" in alts
    assert sum(alt.startswith("Differences in") for alt in alts) >= 2
    assert "Account of time by flow" in alts
    for picture in page.pictures:
        data = base64.b64decode(picture["src"].removeprefix("data:image/png;base64,"))
        assert data.startswith(b"\x89PNG")


def test_versions_seed_and_digest_are_there(page, study_folder):
    method = dict(page.tables["method"])
    study = Study.open(study_folder)
    assert method["Study seed"] == "5"
    assert study.plan.base.digest() in method["Model"]
    assert {"desim-warehouse", "python", "simpy"} <= method.keys()


def shown_by(notebook):
    """What a notebook shows: its HTML, and the words of its pictures."""
    client = NotebookClient(notebook, timeout=120, kernel_name="python3")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the notebook libraries, about one another
        client.execute()
    outputs = [output.get("data", {}) | {"of": output} for cell in notebook.cells for output in cell.get("outputs", [])]
    pages = [data["text/html"] for data in outputs if "text/html" in data]
    return pages, [data["of"].metadata["image/png"]["alt"] for data in outputs if "image/png" in data]


def test_the_notebook_has_the_folder_and_shows_what_the_page_shows(made, study_folder):
    source, notebook = made
    assert notebook.cells[0].source.splitlines()[0] == f"folder = {str(study_folder.resolve())!r}"
    assert not any(cell.get("outputs") for cell in notebook.cells)
    pieces, pictures = shown_by(notebook)
    page = Page(source)
    assert [picture["alt"] for picture in page.pictures] == pictures
    places = [source.index(piece) for piece in pieces]
    assert places == sorted(places)
    assert sum(len(Page(piece).tables) for piece in pieces) == len(page.tables)
    headings = [cell.source.lstrip("# ") for cell in notebook.cells if cell.cell_type == "markdown"]
    on_page = re.findall(r"<h[12]>(.*)</h[12]>", source)[1:]
    assert on_page == [heading for heading in headings if heading in on_page]
    assert {"Appendix", "Findings", "Design of the study"} <= set(on_page)


def small(path):
    """A study of a few runs: at most two levels of each factor, two replications, no long runs."""
    plan = Study.read(path).plan
    baseline = plan.baseline or {}
    factors = []
    for factor in plan.factors:
        kept = [level for level in factor.levels if level.label == baseline.get(factor.key)]
        kept += [level for level in factor.levels if level not in kept][: 2 - len(kept)]
        factors.append(dataclasses.replace(factor, levels=tuple(kept)))
    rule = dataclasses.replace(plan.rule, size=min(plan.rule.size, 4))
    base = plan.base
    if base.run.length is not None:
        short = min(base.run.length, 3600 / base.units.seconds)
        base = base.replace({"run.length": short, "run.warm_up": min(base.run.warm_up, short / 4)})
    return Study.of(dataclasses.replace(plan, base=base, factors=tuple(factors), rule=rule, replications=2))


DAILY = {"charging", "paper"}
EACH = [pytest.param(path, id=path.stem, marks=[] if path.stem in DAILY else [pytest.mark.long]) for path in STUDIES]


@pytest.mark.parametrize("path", EACH)
def test_every_study_has_a_report(path, tmp_path):
    study = small(path).run(out=tmp_path)
    page = needs_nothing_from_outside(report(tmp_path).read_text(encoding="utf-8"))
    assert len(page.tables["results"]) == 1 + len({str(point) for point in study.points})
    assert len(page.pictures) >= 3


def test_a_run_has_a_report_of_its_own(lifelong, tmp_path):
    folder = lifelong.save(tmp_path / "run")
    out = tmp_path / "pages" / "run.html"
    done = CliRunner().invoke(desim, ["report", str(folder), "-o", str(out)], catch_exceptions=False)
    assert done.output.strip() == str(out)
    page = needs_nothing_from_outside(out.read_text(encoding="utf-8"))
    shown = {row[2]: row[1] for row in page.tables["indicators"][1:]}
    assert shown == {key: words.value(key, value, lifelong.model) for key, value in lifelong.kpis.items()}
    lost = lifelong.lost_time
    assert [row[1] for row in page.tables["lost"][1:]] == [
        numbers.duration(time, lifelong.model.units.time) for time in lost["time"][:10]
    ]
    assert [picture["alt"].split()[0] for picture in page.pictures] == [
        "Robots", "Tasks", "Account", "Share", "States", "Energy", "Layout", "Warm-up",
    ]  # fmt: skip
    parts = lifelong.account("task").sum()
    share = numbers.percent(parts.max() / parts.sum(), 0)
    assert f"The largest part of a task's time is {OF_TASKS[parts.idxmax()].doing}: " in page.text
    assert (
        f" steps, {share} %, on average over {numbers.number(len(lifelong.account('task')))} tasks; each" in page.text
    )


def test_a_report_says_when_the_log_has_no_waits_to_account_for(model):

    run = dw.simulate(model.replace({"log": "tasks"}))
    assert run_parts.account_figures(run) == []
    assert "needs a run with log: all" in run_parts.account(run)


def test_the_account_is_of_robots_where_nothing_was_asked_of_them(model):

    run = dw.simulate(model.replace({"tasks.goods": {"poisson": 1e-9}, "run.length": 100}))
    said = "The largest part of a robot's time is idle: 100 steps of 100 steps, 100 %, on average over 6 robots."
    assert said in Page(run_parts.account(run)).text


def test_what_a_run_s_report_says_is_counted_as_its_indicators_are(model):
    """After a warm-up of 500, 1500 of 2000 are counted, in the sentence, the table, the places and at the stations."""

    run = dw.simulate(model.replace({"tasks.goods": {"saturated": 12}, "run": {"length": 2000, "warm_up": 500}}))
    kpis = run.kpis
    assert kpis["throughput_per_hour"] == pytest.approx(kpis["tasks"] / (1500 * run.model.units.seconds / 3600))
    sentence = f"{kpis['tasks']} tasks delivered in 1,500 steps (75 s) after a warm-up of 500 steps, "
    assert f"{sentence}{numbers.measured(kpis['throughput_per_hour'])} an hour." in run_parts.short(run)
    shown = {row[2]: row[1] for row in Page(run_parts.indicators(run)).tables["indicators"][1:]}
    assert shown == {key: words.value(key, value, run.model) for key, value in kpis.items()}
    assert run.edges["waits"].sum() + run.nodes["waits"].sum() == kpis["S"]
    assert len(run.history.counted_deliveries) == kpis["tasks"] < len(run.history.delivered)


def test_the_first_page_has_question_answer_figure_and_cost_and_the_replay_is_beside_it(tmp_path):
    prices = {"hours": 4000, "robot": 9000, "charger": 800}
    base = example().replace({"prices": prices})
    study = Study(base, {"fleet.size": [1, 3, 4]}, replications=8, target="on_time >= 70 %").run(out=tmp_path / "study")
    path = report(tmp_path / "study", tmp_path / "boss.html", replay=True)
    source = path.read_text(encoding="utf-8")
    first, _, rest = source.partition("<h2")
    page = Page(first)
    assert "What gives at least 70 % on time: 1 to 4 robots?" in page.text
    lines, design = answers.answer(study.results)
    assert design == "fleet.size=3"
    assert lines[0].startswith("At least 70 % on time is reached most cheaply with 3 robots: ")
    found = study.results.estimate(study.results.runs(design), "annual_cost")
    assert found.mean == 3 * 9000 + 800
    assert lines[-1].startswith("A year with 3 robots costs 27,800, a task ")
    for line in lines:
        assert line in page.text
    assert [picture["alt"] for picture in page.pictures] == ["Done on time by number of robots"]
    assert 'href="boss-replay.html"' in first
    assert "desimReplay" in (tmp_path / "boss-replay.html").read_text(encoding="utf-8")
    assert rest.index("Where the time goes") < rest.index("Findings") < rest.index("Appendix")
    assert "Met: 3 robots; 4 robots." in Page(source).text
    _, *rows = Page(source).tables["results"]
    shown = {row[0]: row[Page(source).tables["results"][0].index("at least 70 % on time")] for row in rows}
    assert shown == {"1": "not met", "3": "met", "4": "met"}
    assert "Which factor matters" not in source  # there is one


def test_an_answer_for_each_demand_names_a_fleet_for_it():
    factors = {"tasks.demand": [1, 2.2], "fleet.size": [1, 3, 4]}
    study = Study(example(), factors, replications=8, target="on_time >= 60 %").run()
    lines, design = answers.answer(study.results)
    assert lines[0].startswith("Demand 1: at least 60 % on time is reached first with 3 robots: ")
    assert lines[1].startswith("Demand 2.2: at least 60 % on time is reached with 4 robots: ")
    assert design == "tasks.demand=2.2, fleet.size=4"
    verdicts = [one.verdict for one in study.results.judged.values()]
    assert [verdicts.count(name) for name in ("meets", "fails", "undecided")] == [3, 2, 1]
    assert lines[2] == (
        "Of 6 designs 3 meet the target, 1 does not, 1 cannot keep up, 1 needs more runs. "
        "About 426 runs of it would probably tell."
    )
    said = [words.met_or_when(study.results, design) for design in study.results.designs]
    assert said == ["not met", "met", "met", "cannot keep up", "needs more runs, about 426", "met"]


def test_a_verdict_rests_on_the_interval_that_is_shown():
    """Two designs are judged at once, each by a bound of 97.5 %: the end of the interval of 95 % beside it."""
    study = Study(example(), {"fleet.size": [1, 4]}, replications=4, target="on_time >= 60 %")
    found = study.run().results
    for design, one in found.judged.items():
        shown = found.estimate(found.runs(design), "on_time").interval
        assert (one.low, one.high) == pytest.approx(shown)


def test_a_study_of_one_design_says_what_it_achieves():
    flow = {"from": "dock", "to": "pack", "arrivals": {"poisson": 20}, "due_within": 100}
    model = dw.load(RING, {"tasks.flows": {"work": flow}, "run.length": 7200})
    study = dw.Study(model, {}, replications=3, indicators=["throughput_per_hour", "T"])
    found = study.run(workers=1).results
    assert answers.question(found) == "What does the model as it is achieve in throughput and task time?"
    lines, design = answers.answer(found)
    assert re.fullmatch(r"Throughput: \S+ tasks/h \(\S+ to \S+\)\.", lines[0])
    assert lines[1].startswith("Task time: 2.0 h (")
    assert design == found.baseline
    assert study_parts.result_figures(found) == study_parts.first_figure(found) == []
    assert "One design was run." in study_parts.conclusions(found)._repr_html_()
    aimed = dw.Study(model, {}, replications=3, target="on_time >= 1 %").run(workers=1).results
    assert answers.question(aimed) == "Does the model as it is give at least 1 % on time?"
    assert re.fullmatch(r"At least 1 % on time is reached with the model as it is: .+\.", answers.answer(aimed)[0][0])


def test_questions_and_answers_are_sentences():
    flow = {"from": "dock", "to": "pack", "arrivals": {"poisson": 20}, "due_within": 60}
    model = dw.load(RING, {"tasks.flows": {"work": flow}, "run.length": 3600})
    one = dw.Study(model, {"traffic.node_time": [0, 1]}, indicators=["tasks"]).run(workers=1).results
    assert answers.question(one) == "What does node time (0, 1) change in tasks delivered?"
    two = dw.Study(model, {"fleet.size": [1, 2]}, indicators=["tasks"]).run(workers=1).results
    assert answers.question(two) == "What do 1 to 2 robots change in tasks delivered?"
    none = dw.Study(model, {"fleet.size": [1, 2]}, replications=3, target="on_time >= 90 %").run(workers=1).results
    assert answers.answer(none)[0][0].startswith("No design was shown to give at least 90 % on time; ")


def test_one_task_is_not_tasks():
    flow = {"from": "dock", "to": "pack", "arrivals": {"schedule": [{"at": 0, "tasks": 1}]}}
    run = dw.simulate(dw.load(RING, {"tasks.flows": {"work": flow}}))
    assert run_words.sentences(run)[0] == "1 task delivered in 1.5 min, 40 an hour."


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


def test_failed_runs_are_listed(study_folder, tmp_path):
    for file in ("study.json", "results.parquet"):
        (tmp_path / file).write_bytes((study_folder / file).read_bytes())
    table = pd.read_parquet(tmp_path / "results.parquet")
    table.loc[0, "error"] = "ran <flat>"
    table.loc[0, ["T", "S", "throughput_per_hour", "waiting"]] = float("nan")
    table.to_parquet(tmp_path / "results.parquet")
    from desim_warehouse.report import study_parts

    shown = Page(study_parts.method(read(tmp_path)))
    assert "1 run failed and is left out everywhere above" in shown.text
    assert shown.tables["failures"][1][-1] == "ran <flat>"


def test_the_notebook_of_an_answer_shows_it_and_a_run_of_its_design():
    made = nbformat.read(template("answer"), as_version=4)
    nbformat.validate(made)
    pieces, pictures = shown_by(made)
    assert "What holds it up?" in pieces[0]
    assert {"Account", "Robots"} == {words.split()[0] for words in pictures}


@pytest.mark.parametrize("kind", ["study", "run"])
def test_notebooks_run_as_shipped_on_something_small(kind):
    made = nbformat.read(template(kind), as_version=4)
    nbformat.validate(made)
    code = [cell for cell in made.cells if cell.cell_type == "code"]
    assert not any(cell.outputs or cell.execution_count for cell in code)
    assert code[0].metadata["tags"] == ["parameters"]
    assert code[0].source.startswith("folder = None")
    pieces, pictures = shown_by(made)
    assert "an example" in pieces[0]
    assert any("The largest part of a task's time is " in Page(piece).text for piece in pieces)
    assert {"Account", "Layout"} <= {words.split()[0] for words in pictures}


def test_the_wheel_has_the_templates_and_the_gallery(tmp_path):
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)],
        cwd=ROOT,
        check=True,
        capture_output=True,
    )
    (wheel,) = tmp_path.glob("*.whl")
    inside = set(zipfile.ZipFile(wheel).namelist())
    assert {f"desim_warehouse/notebooks/{kind}.ipynb" for kind in ("study", "run", "answer")} <= inside
    assert {f"desim_warehouse/gallery/{name}.yaml" for name in gallery()} <= inside
    assert {
        f"desim_warehouse/report/templates/{name}"
        for name in ("parts.html", "page.html", "report.html", "answer.html", "figures.html", "report.css")
    } <= inside


def test_folders_without_anything_to_report_are_refused(tmp_path):
    with pytest.raises(ReportError, match="neither an answer, nor a study, nor a run"):
        report(tmp_path)
    (tmp_path / "study.json").write_text("{")
    with pytest.raises(ReportError, match="cannot be read"):
        read(tmp_path)


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
    page = ReportPage("t", [html.heading("t")], {"Empty": [None], "Full": [html.code("x")]}, {"None": []}).html()
    assert re.findall("<h2>(.*)</h2>", page) == ["Full"]


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
    page = model_facts(dw.load(SQUARE, over))._repr_html_()
    for fact in (
        "robots: day, 06:00-14:00 without 09:00-09:15 on mon, tue",
        "station desk: wash, 360 of every 3600 s, from 60 on; what has begun pauses",
        "tasks: once, 0 to 60, 90 to 120 s",
        "traffic.closures.gate is closed for 10 % of the time",
        "10 h, begun at 06:00",
    ):
        assert fact in page
    assert not {"Hours", "What goes wrong"} & set(re.findall(r">([\w ]+)<", model_facts(dw.load(SQUARE))._repr_html_()))


def test_the_first_page_has_large_numbers_with_their_intervals(tmp_path, lifelong):
    prices = {"hours": 4000, "robot": 9000, "charger": 800, "currency": "EUR"}
    study = Study(
        example().replace({"prices": prices}), {"fleet.size": [3, 4]}, replications=8, target="on_time >= 50 %"
    )
    study.run(out=tmp_path / "study")
    first = report(tmp_path / "study").read_text(encoding="utf-8").partition("<h2")[0]
    lines, design = answers.answer(study.results)
    found = study.results.estimate(study.results.runs(design), "on_time")
    value, ends = numbers.PERCENT.estimate(found).rstrip(")").split(" (")
    assert f"<dt>done on time</dt><dd>{value}<small>{ends}" in first
    assert "<dd>27,800 EUR" in first
    assert lines[-1].startswith("A year with 3 robots costs 27,800 EUR, a task ")
    said = run_words.numbers_of(lifelong)
    assert next(what for _, what, _ in said) == "tasks an hour"
    page = report(lifelong, tmp_path / "run.html").read_text(encoding="utf-8").partition("<h2")[0]
    assert all(f"<dt>{what}</dt><dd>{value}" in page for value, what, _ in said)
    assert run_words.waited(lifelong)[0] in Page(page).text
