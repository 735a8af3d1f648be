"""The what-if page holds what `desim what-if` and `desim compare` print, for every design and every two of them."""

from __future__ import annotations

import itertools
import json
import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ReportError
from desim_warehouse.report import plot
from desim_warehouse.report.explore import MOST_DESIGNS
from desim_warehouse.report.text import numbers, words
from desim_warehouse.report.text.judged import within
from desim_warehouse.study.results import Results

MULTIBOTS = "models/multibots.yaml"
GOODS = {"tasks.goods": {"random": 4}}


def call(line):
    result = CliRunner().invoke(desim, shlex.split(line)[1:], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def held(page):
    """What a page holds."""
    return json.loads(re.search(r'<script type="application/json" id="study">(.*?)</script>', page, re.DOTALL)[1])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Six designs, three replications each, and their page."""
    folder = tmp_path_factory.mktemp("study")
    call(
        f"desim what-if {MULTIBOTS} --vary fleet.size=3,1,2 --vary policies.allocation=in-order,nearest "
        f"--replications 3 --set 'tasks.goods={{random: 4}}' --seed 4 --out {folder} --quiet --page {folder}/page.html"
    )
    return folder


@pytest.fixture(scope="module")
def content(folder):
    return held((folder / "page.html").read_text(encoding="utf-8"))


def scale_in(study, name):
    return words.scale_of(name, study.base, study.estimates(name).values())


def test_every_design_has_its_levels_and_its_line_of_the_table(folder, content):
    study = Results.load(folder)
    assert [factor["levels"] for factor in content["factors"]] == [["1", "2", "3"], ["in-order", "nearest"]]
    assert [factor["numbers"] for factor in content["factors"]] == [[1, 2, 3], None]
    assert [one["name"] for one in content["indicators"]] == study.usual()
    for rank, point in enumerate(study.points):
        size, policy = content["designs"][rank]["levels"]
        assert (size + 1, ["in-order", "nearest"][policy]) == tuple(point.labels.values())
        for name in study.usual():
            found, scale = study.estimates(name)[point.number], scale_in(study, name)
            drawn = [scale.by * value for value in (found.mean, *found.interval)]
            assert (
                content["means"][name][rank][3]
                == within(name, scale, (found.mean, *(found.interval or (None, None)))).text
            )
            assert content["means"][name][rank][:3] == pytest.approx(drawn, rel=1e-5)
            values = scale.by * study.values(str(point), name)
            assert content["values"][name][rank] == pytest.approx(values, rel=1e-5)


def test_every_two_designs_differ_as_compare_prints(folder, content):
    study = Results.load(folder)
    for a, baseline in enumerate(study.points):
        for name in study.usual():
            found = study.compare(name, baseline.labels)
            rows = {one.design: one for one in found.differences}
            for point, shown in zip(study.points, content["differences"][name][a], strict=True):
                one = rows.get(str(point))
                assert (shown and tuple(shown[:5])) == (one and scale_in(study, name).difference(one))
                assert (shown or [])[5:] == ([one.runs_to_tell] if one and one.runs_to_tell else [])
            assert content["statements"][content["promises"][name][a]] == found.statement
    assert content["differences"]["T"][0][0] is None


def test_the_baseline_comes_first_beside_the_other_end_of_the_first_factor(content):
    a, b = (content["designs"][rank]["levels"] for rank in content["start"])
    assert (a, b) == ([2, 0], [0, 0])  # three robots, the first value given, and one


def test_it_says_what_was_run_and_the_command_makes_it_again(folder, content, tmp_path):
    facts = dict(content["facts"])
    assert facts["Number of robots"] == "1, 2, 3"
    assert facts["Replications"] == "3"
    assert facts["Runs"] == "18"
    assert facts["Run length"] == "until all work is done"
    assert facts["Seed of the study"] == "4"
    assert facts["Seeds of the runs"].count(",") == 2
    assert f"desim-warehouse {dw.__version__}" in facts["Versions"]
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", facts["Page made"])
    assert facts["Model"] == f"MultiBots, SHA-256 {Results.load(folder).base.digest()}"
    first, again = folder / "page.html", tmp_path / "again.html"
    assert "--out" not in content["command"]
    assert call(content["command"].replace(str(first), str(again)) + " --quiet")
    pages = [path.read_text(encoding="utf-8").replace(str(path), "PAGE") for path in (first, again)]
    assert pages[0] == pages[1]


def test_factors_are_called_what_people_call_them_with_their_unit(tmp_path):
    """On the page, in the report and on axes; the terminal has the key that one types, and its unit."""
    changes = {"fleet.robot.breakdowns": {"every": 900, "repair": 20}, "tasks.goods": [11, 8]}
    study = dw.Study(MULTIBOTS, {"fleet.robot.breakdowns.every": [300, 900], "fleet.size": [1, 2]}, changes=changes)
    factors = held(study.run(out=tmp_path).page().html)["factors"]
    assert [factor["head"] for factor in factors] == ["Time between breakdowns (step)", "Number of robots"]
    assert [factor["label"] for factor in factors] == ["Time between breakdowns (step)", "Number of robots, fleet.size"]
    assert (
        plot.by_factor(study.table, factors[0]["key"], "T", model=study.plan.base)
        .get_xlabel()
        .startswith("Time between breakdowns (step)")
    )
    shown = CliRunner().invoke(desim, ["study", str(tmp_path)]).output
    assert "between" in shown


def test_it_asks_for_nothing_from_outside(folder):
    page = (folder / "page.html").read_text(encoding="utf-8")
    shown = page.replace("http://www.w3.org/2000/svg", "")  # a name, never fetched
    assert not re.search(r"https?://", shown)
    assert set(re.findall(r'(?:src|href)="([^"]*)"', shown)) == {"data:,"}
    assert "default-src 'none'" in page


def test_names_made_to_break_pages_stay_names(study_folder):
    page = Results.load(study_folder).page().html
    assert page.count("<script") == 2  # the data and the program
    assert "alert(1)" not in page.replace("\\u003cscript\\u003ealert(1)", "").replace("&lt;script&gt;alert(1)", "")
    assert held(page)["name"].startswith("<script>alert(1)</script>")


def test_verdicts_stand_at_their_designs():
    overload = {"tasks.goods": {"poisson": 400}, "run.length": 20000, "run.warm_up": 2000}
    study = dw.Study(MULTIBOTS, {"fleet.size": [1, 6]}, changes=overload, replications=2).run()
    content = held(study.page().html)
    one, six = content["designs"]
    assert "backlog" in one["marks"]
    assert one["wrong"][0].startswith("Cannot keep up: the backlog grows by ")
    assert not six["wrong"]
    assert content["wrong"][0].endswith("(1 robot).")
    assert dict(content["facts"])["Run length"] == "20,000 steps"
    assert dict(content["facts"])["Warm-up"] == "2,000 steps, not counted"


def test_designs_whose_runs_fail_have_no_numbers_and_say_why():
    study = dw.Study(
        MULTIBOTS, {"battery.capacity": [3, 10], "fleet.size": [1, 2]}, changes={**GOODS, "battery.threshold": 2}
    )
    study.run()
    content = held(study.page().html)
    failing = [rank for rank, design in enumerate(content["designs"]) if design["failed"]]
    assert [content["designs"][rank]["levels"][0] for rank in failing] == [0, 0]
    assert all("BATTERY_TOO_SMALL" in content["designs"][rank]["error"] for rank in failing)
    for a, b in itertools.product(range(4), repeat=2):
        known = a != b and a not in failing and b not in failing
        assert (content["differences"]["T"][a][b] is not None) == known
    assert dict(content["facts"])["Runs"] == "4, 2 of them failed and are left out"


def test_a_warm_up_found_for_each_design_stands_beside_it():
    lifelong = {"tasks.goods": {"saturated": 12}, "run.length": 20000}
    study = dw.Study(MULTIBOTS, {"fleet.size": [1, 3]}, changes=lifelong, warm_up="auto", replications=2).run()
    content = held(study.page().html)
    assert [design["counted_from"] for design in content["designs"]] == [
        numbers.number(at) for at in study.plan.warm_up
    ]
    low, high = sorted(study.plan.warm_up)
    found = f"{low:,.0f} steps to {high:,.0f} steps, found for each design"
    assert dict(content["facts"])["Warm-up"].startswith(found)


def test_a_factor_with_one_value_has_no_slider():
    study = dw.Study(MULTIBOTS, {"battery.threshold": [2], "fleet.size": [1, 2]}).run()
    content = held(study.page().html)
    assert [factor["key"] for factor in content["factors"]] == ["fleet.size"]
    assert dict(content["facts"])["Charging threshold (energy)"] == "2"


@pytest.mark.parametrize(
    ("vary", "said"),
    [
        ("", r"compares 2 to 120 designs \(got 1\), vary something, such as --vary fleet.size=1..6"),
        (f"--vary fleet.size=1..{MOST_DESIGNS + 1}", r"compares 2 to 120 designs \(got 121\), vary less"),
        (
            "--vary fleet.size=1,2 --vary battery.threshold=2,3 --design paired",
            r"\(got paired\), expected design: grid",
        ),
        ("--vary fleet.size=1..6 --design '{sobol: 4}'", r"\(got sobol\), expected design: grid"),
    ],
)
def test_what_has_no_page_is_refused_before_anything_is_simulated(vary, said, tmp_path, monkeypatch):
    monkeypatch.setattr(dw.Study, "run", lambda *_, **__: pytest.fail("simulated"))
    with pytest.raises(ReportError, match=said):
        call(f"desim what-if {MULTIBOTS} {vary} --page {tmp_path}/page.html")


def test_a_study_file_and_a_study_folder_have_a_page_too(folder, tmp_path):
    path = tmp_path / "robots.yaml"
    path.write_text(f"name: robots\nmodel: {Path(MULTIBOTS).resolve()}\nfactors: {{fleet.size: 1..2}}\n")
    assert " kB; open it in a browser" in call(f"desim study {path} --page {tmp_path}/page.html --quiet")
    content = held((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert (content["model"], content["name"]) == ("MultiBots", "robots")
    assert content["command"] == f"desim study {path} --page {tmp_path}/page.html"
    assert held(dw.Study.open(folder).page().html)["command"] == f"desim study {folder} --page FILE"
    assert held(dw.Study.open(folder).page().html)["means"] == held((folder / "page.html").read_text())["means"]


def test_a_page_that_cannot_be_written_is_one_message(tmp_path, monkeypatch):
    study = dw.Study(MULTIBOTS, {"fleet.size": [1, 2]}).run()
    (tmp_path / "file").write_text("")
    with pytest.raises(ReportError, match="page cannot be written"):
        study.page(tmp_path / "missing" / "page.html")
    page = study.page(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == page.html
    assert repr(page).startswith("WhatIfPage(study: what if, 0.")
    assert 'sandbox="allow-scripts' in page._repr_html_()
    monkeypatch.setattr(dw.Study, "run", lambda *_, **__: pytest.fail("simulated"))
    with pytest.raises(ReportError, match="page cannot be written"):
        call(f"desim what-if {MULTIBOTS} --vary fleet.size=1,2 --page {tmp_path}/file/page.html")
