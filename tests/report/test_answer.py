"""One answer: what is printed, kept and shown is the same, of one design, with one interval for each number."""

from __future__ import annotations

import html
import json
import random
import re

import jsonschema
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.errors import ReportError
from desim_warehouse.report import answer as answers
from desim_warehouse.report.answer_page import page
from desim_warehouse.report.page import example
from desim_warehouse.report.text.printed import printed
from desim_warehouse.report.write import report
from desim_warehouse.study.reliefs.suspect import Suspect
from desim_warehouse.study.statistics import Estimate, Gain, Gains
from desim_warehouse.study.why import Why, why

BRACKETS = re.compile(r"\([^)]*\(")


def made_up_why(number):
    """What `desim why` may find, by chance: gains of all sizes, of shares, times and rates."""
    chance = random.Random(number)
    indicator = chance.choice(["on_time", "cycle_time_mean", "throughput_per_hour"])
    size = 0.1 if indicator == "on_time" else 10.0
    pairs = []
    for rank in range(1, chance.randint(2, 6)):
        mean = chance.gauss(0.5, 1) * size
        low, high = mean - abs(chance.gauss(0, size)), mean + abs(chance.gauss(0, size))
        dose = chance.choice([None, 0.125, 1.0])
        suspect = Suspect(f"part {rank}", f"one part {rank} more", {"fleet.size": rank}, chance.random(), dose)
        same = chance.random() < 0.2
        nan = float("nan")
        gain = Gain(rank, 0, nan, nan, 10, same=True) if same else Gain(rank, mean, low, high, 10, suspect.scale)
        pairs.append((suspect, gain))
    pairs.sort(key=lambda pair: (not pair[1].competes, -pair[1].each.mean))
    base = 0.9 if indicator == "on_time" else 100.0
    seen = Estimate(10, base, (0.9 * base, 1.05 * base), base, base, {}, False, 0.95)
    gains = Gains(tuple(gain for _, gain in pairs), base, 0.01 * base, 0.95, 60)
    return Why(example(), indicator, tuple(pairs), gains, number, seen)


def text_of(source):
    """What a page says, unfolded, without its style."""
    body = re.sub(r"<style>.*?</style>", "", source, flags=re.DOTALL)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", body)).replace("\u00a0", " "))


def is_everywhere(answer):
    """Whether terminal, page and JSON say the same, every number once with one interval."""
    shown, terminal = text_of(page(answer, None)), printed(answer, 400)
    content = json.loads(json.dumps(answer.content()))
    assert content["answer"] == list(answer.answer)
    for line in (*answer.answer, *answer.notes, answer.promise):
        assert line in shown
        assert line in terminal
        assert not BRACKETS.search(line)
    intervals: dict[tuple[str, str], set[str]] = {}
    for option, kept in zip(answer.options, content["options"], strict=True):
        for text in (option.text, option.full_name):
            assert re.sub(r"\s+", " ", text) in shown
            assert text in terminal
        assert kept["number"] is None or kept["number"]["text"] == option.text
        assert not (option.standing == "overloaded" and option.number)
        if option.number:
            intervals.setdefault((option.name, option.demand), set()).add(option.number.text)
    assert all(len(found) == 1 for found in intervals.values())
    if isinstance(answer.figure, answers.Rows):
        texts = {option.name: option.text for option in answer.options}
        assert all(texts[mark.label] == mark.text for mark in answer.figure.rows)
    if answer.about is None:
        assert not answer.tiles
    return True


@pytest.mark.parametrize("number", range(40))
def test_terminal_page_and_json_of_why_are_equal(number):
    assert is_everywhere(made_up_why(number).answer)


def test_why_is_about_the_warehouse_as_it_is_and_its_page_shows_no_other(tmp_path):
    model = example().replace({"run.length": 3600})
    found = why(model, cap=5, first=5, out=tmp_path)
    answer = found.answer
    answer.save(tmp_path)
    assert answers.load(tmp_path) == answer
    assert dw.load(answer.about.model).fleet.size == model.fleet.size
    assert answer.tiles[0].what.endswith("as it is")
    assert float(answer.tiles[0].value.removesuffix(" min")) == pytest.approx(found.as_it_is.mean / 60, rel=0.01)
    source = report(tmp_path).read_text(encoding="utf-8")
    assert f"<h2>{answer.about.name.capitalize()}" in source
    assert source.count("<figure") <= 3
    assert "<img" not in source
    assert len(source) < 60_000
    assert "iframe" in found._repr_html_()


def test_an_answer_is_as_its_schema_says():
    said = CliRunner().invoke(desim, ["schema", "--answer"], catch_exceptions=False).output
    jsonschema.validate(json.loads(made_up_why(3).answer.model_dump_json()), json.loads(said))


def test_a_damaged_answer_is_one_message(tmp_path):
    made_up_why(0).answer.save(tmp_path)
    path = tmp_path / "answer.json"
    path.write_text(path.read_text(encoding="utf-8").replace('"kind"', '"king"'), encoding="utf-8")
    with pytest.raises(ReportError, match=r"damaged, or made by another version: kind: Field required; run the same"):
        answers.load(tmp_path)
    path.write_text("{", encoding="utf-8")
    with pytest.raises(ReportError, match="damaged"):
        answers.load(tmp_path)


def test_options_whose_runs_are_equal_are_one():
    found = answers.merged(["a", "b", "A", "c", "B"], str.lower)
    assert found == [("a", ["A"]), ("b", ["B"]), ("c", [])]
