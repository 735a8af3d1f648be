"""Work without end that is counted before its third hour: what it shows holds in hours 6 to 9 of other days, too.

That is so for the models of pages, drafts on them, and those that are shipped. Or a verdict says that it is not.
"""

import math
import shutil
from statistics import fmean, variance

import pytest

import desim_warehouse as dw
from desim_warehouse.model.sections.flows import ProfileArrivals
from desim_warehouse.outcome.verdicts import judge_design
from tests.docs.pages import ELSEWHERE, PAGES, ROOT, models

SHORT = 2 * 3600.0
"""Seconds: a warm-up in which batteries that do not start settled do not settle."""
TELLING = {"on_time": 0.03, "charger_utilisation": 0.06, "share_idle": 0.06}
"""Indicators that tell of a fleet, and by how much they may differ beyond three standard errors."""

LARGE = 300
"""Robots above which a run takes minutes, and whose mean varies so little that two runs tell it."""


def is_short(model):
    """Whether all its hours are alike, and those counted come soon; a day by a profile, or with hours, is one."""
    by_hours = model.layout.has_hours or model.fleet.has_hours
    by_hours = by_hours or any(isinstance(flow.when, ProfileArrivals) for flow in model.tasks.flows.values())
    soon = model.run.warm_up * model.units.seconds < SHORT
    return model.tasks.never_end and model.battery is not None and soon and not by_hours


def counted(model, seeds):
    return [dw.simulate(model, seed).kpis for seed in seeds]


def differences(model, few, many):
    """How the counted time differs from hours after the sixth; none where a verdict says that it is unlike them."""
    hour = model.units.hour
    model = model.replace({"log": "tasks"})
    here = counted(model, range(many))
    if judge_design(here, model):
        return {}
    # As long as the counted time, since chargers may be busier in every second hour, in all runs alike.
    hours = max(3 * hour, model.run.length - model.run.warm_up)
    later = counted(model.replace({"run.warm_up": 6 * hour, "run.length": 6 * hour + hours}), range(100, 100 + few))
    means = {}
    for name, least in TELLING.items():
        one, other = ([run[name] for run in runs if math.isfinite(run.get(name, math.nan))] for runs in (here, later))
        if len(one) > 1 and len(other) > 1:
            error = math.sqrt(variance(one) / len(one) + variance(other) / len(other))
            if abs(fmean(one) - fmean(other)) > least + 3 * error:
                means[name] = fmean(one), fmean(other)
    return means


@pytest.fixture
def folder(tmp_path, monkeypatch):
    for name in ("models", "studies"):
        shutil.copytree(ROOT / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def of_page(page, folder):
    """The short ones of a page, each once, by the command that has it."""
    short = {}
    for words, model in models(page, folder):
        if is_short(model):
            short.setdefault(model.digest(), (words, model))
    return list(short.values())


def test_the_chief_example_of_plans_is_as_hours_6_to_9(folder):
    [(_, model)] = of_page(ROOT / "docs/how-to/how-many-robots.md", folder)
    assert model.fleet.start_energy == "settled"
    assert differences(model, 2, 4) == {}


@pytest.mark.long
@pytest.mark.parametrize("page", [page for page in PAGES if page not in ELSEWHERE], ids=lambda page: page.stem)
def test_short_runs_of_pages_are_as_hours_6_to_9(page, folder):
    assert {words: means for words, model in of_page(page, folder) if (means := differences(model, 8, 24))} == {}


@pytest.mark.long
@pytest.mark.parametrize(
    "name", sorted(str(path.relative_to(ROOT / "models")) for path in (ROOT / "models").rglob("*.yaml"))
)
def test_short_runs_of_shipped_models_are_as_hours_6_to_9(name):
    model = dw.load(ROOT / "models" / name)
    few, many = (2, 2) if model.fleet.size > LARGE else (4, 8)
    assert not is_short(model) or differences(model, few, many) == {}
