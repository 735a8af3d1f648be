"""What axe-core says of the pages: nothing, on light and on dark ground, on a screen and on a phone.

Every day one page of each template, answers as `make_answers` has kept them; fresh answers of every question are for
the long run.
"""

import shutil
from importlib.resources import files
from pathlib import Path

import nbclient
import nbformat
import pytest

import desim_warehouse as dw
from desim_warehouse.folders import ANSWER
from desim_warehouse.questions import compare_words, input_words
from desim_warehouse.questions.orient import worded
from desim_warehouse.questions.plan import plan_fleet
from desim_warehouse.questions.size import size
from desim_warehouse.questions.why import why
from desim_warehouse.report import validation_page
from desim_warehouse.report.example import example
from desim_warehouse.report.write import report, template
from desim_warehouse.study.designs.directions import DirectionGain, SearchedDirections
from desim_warehouse.study.fit import fit
from desim_warehouse.study.warm_up import settle
from tests.browser.pages import Opened
from tests.kept.test_kept import HERE as KEPT
from tests.report.replay.floors import busy_run, people_run
from tests.report.test_days import by_hand

AXE = "const [how, done] = arguments; axe.run(how).then((found) => done(found.violations))"
EVERY = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]}
KEPT_ANSWERS = Path(__file__).parent / "answers"
UNFOLD = "for (const one of document.querySelectorAll('details')) one.open = true"


def a_study(folder):
    study = dw.Study(example(), {"fleet.size": [1, 3]}, replications=3, target="on_time >= 70 %").run()
    dw.what_if_page(study.results, folder / "page.html")
    return folder / "page.html"


def a_study_of_words(folder):
    factors = {"fleet.size": [1, 3], "policies.allocation": ["nearest", "hungarian"]}
    dw.what_if_page(dw.Study(example(), factors, replications=2).run().results, folder / "page.html")
    return folder / "page.html"


def an_answer_of_plan(folder):
    plan_fleet(example(), "on_time >= 75 %", growth=2, strategies={}, robots=range(1, 5)).answer.save(folder)
    return report(folder, folder / "page.html")


def an_answer_of_why(folder):
    why(example(), search=dw.Search(first=5, cap=5)).answer.save(folder)
    return report(folder, folder / "page.html")


def an_answer_of_a_study(folder):
    factors = {"tasks.demand": [1, 2.2], "fleet.size": [1, 3]}
    dw.Study(example(), factors, replications=3, target="on_time >= 60 %").run(out=folder / "study")
    return report(folder / "study", folder / "page.html")


def an_answer_of_a_race(folder):
    choice = dw.best(
        dw.Study(example(), {"fleet.size": [1, 3]}), "throughput_per_hour", search=dw.Search(first=3, cap=3)
    )
    choice.answer.save(folder)
    return report(folder, folder / "page.html")


def of(answer, folder):
    answer.save(folder)
    return report(folder, folder / "page.html")


def an_answer_of_size(folder):
    study = dw.Study(example(), {"fleet.size": [1, 2, 3]}, target="on_time >= 70 %")
    study.plan = study.plan.unreplicated()
    return of(size(study, "on_time >= 70 %", search=dw.Search(first=3, cap=6)).answer, folder)


def an_answer_of_a_search(folder):
    searched = dw.best(
        example(),
        "throughput_per_hour",
        vary={"fleet.size": [1, 2, 3]},
        target="on_time >= 60 %",
        search=dw.Search(runs=60),
    )
    return of(searched.answer, folder)


def an_answer_of_a_comparison(folder):
    results = dw.Study(example(), {"fleet.size": [1, 2, 3]}, replications=3).run().results
    return of(compare_words.answer(results, {"T": results.compare("T"), "S": results.compare("S")}), folder)


def an_answer_of_tipping_points(folder):
    ranges = {"tasks.load_time": (5.0, 20.0)}
    return of(dw.tipping_points(example(), "throughput_per_hour >= 40", ranges).answer, folder)


def an_answer_of_directions(folder):
    gains = [DirectionGain(where, 0.05, low, 0.09, 12, low > 0) for where, low in (("", 0.01), ("6 robots", -0.02))]
    turned = SearchedDirections(
        example(), {}, ("column B",), 3, "throughput_per_hour", gains[0], (gains[1],), 200, 0.95
    )
    return of(worded(turned).answer, folder)


def an_answer_of_a_warm_up(folder):
    warm_up = settle(example(), replications=2, observations=50)
    return of(input_words.warm_up(warm_up, example(), "throughput", 2), folder)


def an_answer_of_a_fit(folder):
    return of(input_words.fit(fit([2.0 + number % 7 for number in range(60)]), "picks.csv", "load_s", "s"), folder)


def kept_answer(name, folder):
    shutil.copy(KEPT_ANSWERS / f"{name}.json", folder / ANSWER)
    return report(folder, folder / "page.html")


def a_kept_plan(folder):
    return kept_answer("plan", folder)


def a_kept_reason(folder):
    return kept_answer("why", folder)


def an_answer_of_before(folder):
    return report(KEPT / "plan", folder / "page.html")


def a_validation(folder):
    model = example().replace({"run.length": 1800, "run.warm_up": 0, "log": "all"})
    page = validation_page.page(by_hand(model, [3.0, 9.0], [[3.0 + n % 2, 4.0] for n in range(40)]))
    (folder / "page.html").write_text(page, encoding="utf-8")
    return folder / "page.html"


def two_replays(folder):
    busy_run().replay(folder / "page.html", beside=people_run())
    return folder / "page.html"


def a_replay(folder):
    busy_run().replay(folder / "page.html")
    return folder / "page.html"


def a_report(folder):
    return report(people_run(), folder / "page.html")


DAILY = (two_replays, a_report, a_kept_reason)
LONG = (
    a_validation,
    a_study,
    a_kept_plan,
    an_answer_of_before,
    a_study_of_words,
    a_replay,
    an_answer_of_plan,
    an_answer_of_why,
    an_answer_of_size,
    an_answer_of_a_study,
    an_answer_of_a_race,
    an_answer_of_a_search,
    an_answer_of_a_comparison,
    an_answer_of_tipping_points,
    an_answer_of_directions,
    an_answer_of_a_warm_up,
    an_answer_of_a_fit,
)


SCREENS = [("light", (390, 844)), ("dark", (1400, 900)), ("light", (1400, 900))]
"""Every day the first of them for one page, the second for the next: both grounds and both sizes."""


@pytest.mark.parametrize(
    ("make", "screens"),
    [
        *((make, [SCREENS[rank % 2]]) for rank, make in enumerate(DAILY)),
        *(pytest.param(make, SCREENS, marks=pytest.mark.long) for make in (*DAILY, *LONG)),
    ],
)
def test_axe_finds_nothing(browser, tmp_path, make, screens):
    page = Opened(browser, make(tmp_path))
    browser.execute_script(files("axe_core_python").joinpath("axe.min.js").read_text("utf-8"))
    browser.execute_script(UNFOLD)
    violations = []
    for scheme, (width, height) in screens:
        browser.execute_cdp_cmd(
            "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        )
        page.enlarge(width, height)
        violations += [
            (scheme, width, one["id"], [node["html"][:120] for node in one["nodes"][:3]])
            for one in browser.execute_async_script(AXE, EVERY)
        ]
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    assert violations == []


@pytest.mark.long
def test_axe_finds_nothing_on_the_notebook_as_html_and_nothing_is_wider_than_it(browser, tmp_path):
    """By `nbconvert`, whose own prompts and comments are too pale; the answer's frame is a page of its own."""
    nbconvert = pytest.importorskip("nbconvert", reason="nbconvert is not installed")
    book = nbformat.read(template(), as_version=4)
    nbclient.NotebookClient(book, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()
    page = tmp_path / "notebook.html"
    page.write_text(nbconvert.HTMLExporter().from_notebook_node(book)[0], encoding="utf-8")
    Opened(browser, page).enlarge(1200, 900)
    assert browser.execute_script("return document.documentElement.scrollWidth") == 1200
    browser.execute_script(files("axe_core_python").joinpath("axe.min.js").read_text("utf-8"))
    violations = browser.execute_async_script(AXE, {**EVERY, "iframes": False})
    assert [(one["id"], [node["html"][:120] for node in one["nodes"][:3]]) for one in violations] == []
