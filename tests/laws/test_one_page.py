"""A number that a run shows in two places is equal in both: on the terminal, in JSON, on pages and in the replay."""

import html
import json
import re

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.answer import numbers
from desim_warehouse.answer.words import load
from desim_warehouse.cli import desim
from desim_warehouse.errors import number_of
from desim_warehouse.live.answers import Named, RunsSoFar
from desim_warehouse.questions.run import page, words
from desim_warehouse.replay.payload import payload
from desim_warehouse.replay.tiles import tiles
from desim_warehouse.study.execution.work import Outcome
from tests.daily import some
from tests.run.halls import RING, loaded_hall

pytestmark = pytest.mark.usefixtures("brief_probes")
GALLERY = {
    "e-commerce": "10 min",
    "goods-to-person": "5 min",
    "hospital": "1 h",
    "mezzanine": "20 min",
    "milk-run": "20 min",
    "pallets": "20 min",
    "pick-assist": "10 min",
    "sorting": "3 min",
}


def shortened(name):
    length = {"run.length": GALLERY[name], "run.warm_up": 60, "log": "all", "fleet.start_energy": 0.9}
    return dw.load(f"models/gallery/{name}.yaml", length)


def story(run):
    header, _ = payload(run.history, 0.0, run.history.end)
    return [stop["said"] for stop in header["stops"]]


def disagreements(run):
    """Return the values that differ between two places, each with both."""
    kpis, text, stops = run.kpis, " ".join(words.sentences(run)), story(run)
    differing = []

    def hold(what, here, elsewhere):
        if here != elsewhere:
            differing.append((what, here, elsewhere))

    for tile in tiles(run.history):
        if tile.key in kpis and tile.form in {"count", "share", "time", "open"} and tile.curve[1]:
            hold(f"tile {tile.key}", round(float(tile.curve[1][-1]), 9), round(float(kpis[tile.key]), 9))
    delivered = number_of(kpis["tasks"], load(run.model))
    hold("delivered, terminal", text.startswith(f"{delivered} delivered in "), True)
    hold("delivered, story", stops[-1].startswith(f"In all: {delivered} delivered"), True)
    waits = numbers.PERCENT.value(kpis["share_waiting"])
    hold("waiting, terminal", f"Robots waited in traffic {waits} of the time." in text, True)
    hold("waiting, story", f"robots wait in traffic {waits} of the time." in stops[-1], True)
    first, lines = words.sentences(run)[0], words.sentences(run)
    hold("on time", re.findall(r"[\d.]+ % on time", first), re.findall(r"[\d.]+ % on time", stops[-1]))
    for busiest in (line for line in stops if "the busiest" in line):
        hold("busiest", [line for line in lines if "the busiest" in line and line.startswith(busiest)] != [], True)
    return differing


LARGE = {"goods-to-person", "sorting", "hospital", "mezzanine", "milk-run"}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long if name in LARGE else pytest.mark.slow) for name in GALLERY]
)
def test_no_number_of_a_gallery_model_has_two_values(name):
    run = dw.simulate(shortened(name), 1)
    assert disagreements(run) == []


@pytest.mark.parametrize("number", some(range(20), 2))
def test_no_number_of_a_small_hall_has_two_values(number):
    """Each hall has one packer; fleets, rates, warm-ups and due times vary."""
    rate, size, warm_up = 10 + 3 * number, 1 + number % 6, 600 * (number % 3)
    goods = {"poisson": rate, "due_within": 120 + 60 * (number % 4)}
    changes = {"tasks.goods": goods, "tasks.unload_time": 40, "fleet.size": size, "run": {"length": 7200}}
    run = dw.simulate(dw.load(RING, {**changes, "run.warm_up": warm_up}), number)
    assert disagreements(run) == []


@pytest.mark.parametrize("number", some(range(60), 30))
def test_a_run_begins_alike_wherever_it_is_read(number, tmp_path):
    """The first sentence agrees on the terminal, in JSON, in the report, in the replay and on the live page."""
    model = loaded_hall(number, "4 h")[0]
    goods = {**model.content()["tasks"]["goods"], "due_within": 600}
    model = model.replace({"tasks.goods": goods, "log": "all"})
    run, file = dw.simulate(model, number), tmp_path / "hall.yaml"
    assert disagreements(run) == []
    first = words.sentences(run)[0]
    file.write_text(json.dumps(model.content()), "utf-8")
    arguments = ["run", str(file), "--seed", str(number)]
    terminal, data = (CliRunner().invoke(desim, [*arguments, *more]).stdout for more in ([], ["--json"]))
    assert " ".join(terminal.split()).startswith(first)
    assert json.loads(data)["answer"] == words.sentences(run)
    assert first in " ".join(html.unescape(re.sub(r"<[^>]+>", "", page.page(run))).split())
    live = (
        RunsSoFar(Named("the hall", {}, model), [Outcome(dict(run.kpis), 1.0)], "on_time", number)
        .in_words(None)
        .sentence
    )
    on_time = re.findall(r"[\d.]+ % on time", first)
    assert re.findall(r"[\d.]+ % on time", live) == on_time
    if not on_time:
        assert live.startswith(("Only ", "Cannot keep up"))
