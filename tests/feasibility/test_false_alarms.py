"""What `desim check` knows of slips is not said of models that have none: shipped ones, those of pages, drafts."""

import math
import shutil

import pytest

import desim_warehouse as dw
from desim_warehouse.draft import Draft, draft
from desim_warehouse.findings import CODES
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.questions.check import check
from tests.daily import some
from tests.docs import pages

pytestmark = pytest.mark.usefixtures("brief_probes")

LARGE = pages.ROOT / "models" / "large.yaml"
"""Its check alone takes 5 s."""
GALLERY = pages.ROOT / "docs" / "gallery.md"
"""Its models are shipped, and a third of those looked at every day."""
SLIPS = tuple(CODES)[tuple(CODES).index("BATTERY_RATES") :]
"""The codes of slips."""
MEANT = {
    # packing is open from 06:00 to 14:00, tasks come day and night and are due after 8 h: those are late
    "desim check shifts.yaml --set layout.stations.packing.hours=early": {"BREAK_BEYOND_DUE"}
}
"""What a page shows on purpose."""


def slips(model, level=("warning", "note")):
    return {item.code: str(item) for item in check(model).findings if item.code in SLIPS and item.level in level}


def errors_and_slips(model):
    findings = check(model).findings
    return [str(item) for item in findings if item.level == "error" or item.code in SLIPS]


@pytest.mark.parametrize(
    "file",
    [
        *some(sorted({*pages.ROOT.glob("models/**/*.yaml")} - {LARGE}, key=lambda file: file.stat().st_size), 4),
        pytest.param(LARGE, marks=pytest.mark.long),
    ],
    ids=lambda file: file.stem,
)
def test_nothing_is_said_of_the_shipped_models(file):
    assert errors_and_slips(dw.load(file)) == []


WITH_MODELS = [page for page in pages.PAGES if "desim " in page.read_text(encoding="utf-8") and page != GALLERY]


@pytest.mark.parametrize("page", [*some(WITH_MODELS, 10), pytest.param(GALLERY, marks=pytest.mark.long)])
def test_no_warning_of_a_model_of_a_page(page, tmp_path, monkeypatch):
    for name in ("models", "studies"):
        shutil.copytree(pages.ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.chdir(tmp_path)
    for words, model in pages.models(page, tmp_path):
        codes = slips(model, ("warning",))
        assert set(codes) <= MEANT.get(words.strip(), set()), (words, codes)


def test_pages_have_models(tmp_path, monkeypatch):
    shutil.copytree(pages.ROOT / "models", tmp_path / "models")
    monkeypatch.chdir(tmp_path)
    assert len(list(pages.models(pages.ROOT / "docs/how-to/shifts.md", tmp_path))) > 2


HOURS = {
    "calendars": {"day": {"open": ["06:00-22:00"], "breaks": ["12:00-12:30"]}},
    "fleet.hours": "day",
    "tasks.goods.hours": "day",
    "run": {"start": "06:00", "length": "16 h", "warm_up": "1 h"},
}
HEAVY = {
    "tasks.load_time": {"lognormal": {"mean": 60, "cv": 0.5}},
    "tasks.unload_time": {"triangular": [40, 60, 120]},
    "fleet.robot.speed_loaded": 1,
}
VARIANTS = {"poisson": {}, "hours": HOURS, "heavy": HEAVY}
LARGER = ((60, 40), (40, 60), (80, 50), (120, 80))
SIZES = [(30, 20), *(pytest.param(size, marks=pytest.mark.long) for size in LARGER)]


@pytest.mark.parametrize("load", [0.8, *(pytest.param(load, marks=pytest.mark.long) for load in (0.3, 0.55))])
@pytest.mark.parametrize(  # of plain drafts every day those of test_slips.py
    "variant", [pytest.param("poisson", marks=pytest.mark.long), "hours", "heavy"]
)
@pytest.mark.parametrize("size", SIZES, ids=str)
def test_nothing_is_said_of_drafts(size, variant, load):
    words = Draft(size=size, orders=size[0] * size[1] / 12)
    model = dw.Model.model_validate(read_yaml(draft(words), "draft").data).replace(VARIANTS[variant])
    calculation = check(model).calculation
    robots = math.ceil(calculation.robots_busy / load)
    places = {"layout.bays.parking.places": robots, "layout.stations.packing.places": 2 * robots}
    assert slips(model.replace({"fleet.size": robots, **places})) == {}
