"""The page of `desim what-if --page`: every option with the text of the answer, and what it refuses."""

import json
import re

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ReportError
from desim_warehouse.live.frozen import MOST, check
from desim_warehouse.report.example import example
from tests.lasting import LASTING

pytestmark = pytest.mark.usefixtures("brief_probes")

MULTIBOTS = "models/multibots.yaml"


def held(page):
    """What a page holds."""
    return json.loads(re.search(r'<script type="application/json" id="frozen">(.*?)</script>', page, re.DOTALL)[1])


@pytest.fixture(scope="module")
def study():
    prices = {"hours": 4000, "robot": 9000, "currency": "EUR"}
    base = example().replace({"prices": prices, **LASTING, "run.length": 1800, "run.warm_up": 300})
    factors = {"fleet.size": [1, 3, 4], "policies.allocation": ["nearest", "hungarian"]}
    return dw.Study(base, factors, replications=4, target="on_time >= 60 %").run()


@pytest.fixture(scope="module")
def data(study):
    return held(dw.what_if_page(study.results).html)


def test_every_option_has_the_texts_of_the_answer(study, data):
    answer = study.results.answer
    assert len(data["designs"]) == 6
    assert data["answers"] == list(answer.answer)
    by_size = {(one.set["fleet.size"], "hungarian" in one.name): one for one in answer.options}
    for asked, watched in data["designs"]:
        key = asked["levels"]["fleet.size"], asked["levels"]["policies.allocation"] == "hungarian"
        option = by_size.get(key) or by_size[key[0], False]  # where both are the same, run by run
        assert watched["verdict"] == option.standing
        assert (option.instead or option.text) in watched["sentence"][:1].lower() + watched["sentence"][1:]
        assert watched["sentence"].endswith(f"{9000 * key[0]:,} EUR a year.")
        assert [one["text"] for one in watched["measured"]] == [one.text for one in option.numbers]
        values = study.results.values(
            f"fleet.size={key[0]}, policies.allocation={asked['levels']['policies.allocation']}", "on_time"
        )
        assert watched["values"] == pytest.approx([100 * value for value in values], rel=1e-5)


def test_differences_are_those_of_compare(study, data):
    """Copies of another option have its difference; from the one that is pinned they have none."""
    results = study.results
    rows = {str(row.design): row for row in results.compare_finished("on_time").differences}
    assert data["differences"][0][0] is None
    for design, text in list(zip(results.designs, data["differences"][0], strict=True))[1:]:
        row = rows.get(results.same.get(design, design))
        if row is None:
            assert text == "none"
        else:
            number = float(re.match(r"\S+", text)[0].replace("−", "-"))
            assert number == pytest.approx(100 * row.estimate.mean, abs=0.6)
    assert len(rows) == len(results.designs) - 1 - len(results.same)


def test_it_begins_with_the_option_of_the_answer_beside_the_baseline(study, data):
    assert data["designs"][data["start"]][0]["words"] == study.results.answer.about.name
    assert data["designs"][data["pinned"]][0]["levels"]["fleet.size"] == 1


def test_a_page_of_ten_options_is_small(tmp_path):
    changes = {"tasks.goods": {"random": 1}}
    study = dw.Study(MULTIBOTS, {"fleet.size": range(1, 11)}, changes=changes, replications=10).run()
    path = tmp_path / "page.html"
    dw.what_if_page(study.results, path)
    assert path.stat().st_size < 60_000
    assert "fetch(" not in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("factors", "design", "message"),
    [
        (
            {"fleet.size": [1, 2], "tasks.load_time": [9, 10]},
            "paired",
            r"every combination must be a design \(got paired\)",
        ),
        ({"fleet.size": range(1, MOST + 2)}, "grid", rf"2 to {MOST} options \(got {MOST + 1}\), vary less"),
        ({}, "grid", r"\(got 1\), vary something"),
    ],
)
def test_what_has_no_page_is_refused(factors, design, message):
    with pytest.raises(ReportError, match=message):
        check(dw.Study(MULTIBOTS, factors, design=design).plan)


def test_the_command_is_on_the_page_and_it_needs_no_server(tmp_path):
    line = ["what-if", MULTIBOTS, "--vary", "fleet.size=1,2", "--quiet", "--page", str(tmp_path / "page.html")]
    done = CliRunner().invoke(desim, line, catch_exceptions=False)
    assert "kB; open it in a browser" in done.output
    assert held((tmp_path / "page.html").read_text(encoding="utf-8"))["about"]["folder"].startswith("desim what-if ")
