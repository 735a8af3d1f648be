"""One answer: what is printed, kept and shown is the same, of one design, with one interval for each number."""

import ast
import html
import json
import random
import re
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse import answer as answer_package
from desim_warehouse import questions
from desim_warehouse.answer import answer as answers
from desim_warehouse.answer import words
from desim_warehouse.answer.numbers import capital
from desim_warehouse.answer.page import page
from desim_warehouse.answer.parts import Rows
from desim_warehouse.answer.standing import WORDS
from desim_warehouse.answer.text import printed
from desim_warehouse.cli import desim
from desim_warehouse.errors import ReportError
from desim_warehouse.live.answers import Named, RunsSoFar
from desim_warehouse.model.facts.workers import Group, Load
from desim_warehouse.outcome.verdicts import Verdict
from desim_warehouse.questions import judged as judged_words
from desim_warehouse.questions.plan import plan_fleet, worded
from desim_warehouse.questions.plan.cells import named
from desim_warehouse.questions.size import size
from desim_warehouse.questions.why import why
from desim_warehouse.questions.why import worded as why_worded
from desim_warehouse.report.example import example
from desim_warehouse.report.write import report
from desim_warehouse.study.fleet import Designs, FleetSizes, Shown, Sized, Strategy
from desim_warehouse.study.held_up import HeldUp
from desim_warehouse.study.plan import run_seed
from desim_warehouse.study.statistics.effects import Gain, Gains
from desim_warehouse.study.statistics.intervals import Estimate
from desim_warehouse.study.statistics.judge import DesignVerdict
from desim_warehouse.study.suspects import Suspect
from desim_warehouse.study.target import read_target
from tests.daily import some
from tests.lasting import LASTING
from tests.live.test_frozen import held
from tests.report.test_report import needs_nothing_from_outside

pytestmark = pytest.mark.usefixtures("brief_probes")

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
    return why_worded(HeldUp(example(), indicator, tuple(pairs), gains, number, seen))


GOAL = read_target("on_time >= 95 %")
GROWS = Verdict("CANNOT_KEEP_UP", "cannot keep up: open tasks grow by 20 an hour", 20.0, 61.5, 41.5)


def judged(chance, kind, number):
    """A verdict on a design by chance: `kind` is meets, fails or undecided."""
    mean = {"meets": 0.98, "fails": 0.9, "undecided": 0.95}[kind] + chance.uniform(-0.015, 0.015)
    low = 0.95 + chance.uniform(0, mean - 0.95) if kind == "meets" else mean - chance.uniform(0.001, 0.04)
    high = 0.95 - chance.uniform(0.0001, 0.95 - mean) if kind == "fails" else min(mean + chance.uniform(0.001, 0.04), 1)
    zone = kind == "undecided" and chance.random() < 0.3
    low, high = min(low, mean), max(high, mean)
    return DesignVerdict(number, kind, chance.choice([10, 20, 40]), mean, low, high, 0.99, False, zone)


def shown(chance, counts, kind, overloaded=False):
    """A fleet that was judged; an overloaded one has a share on time that nobody may see."""
    one = judged(chance, kind, 0)
    seen = Estimate(one.n, one.mean, (one.low, one.high), 0.01, one.mean, {}, False, 0.95)
    wrong = (GROWS,) if overloaded else ()
    cost = 1000.0 * counts[0] if chance.random() < 0.5 else None
    return Shown(counts, {"fleet.size": counts[0]}, one, seen, GROWS.text if overloaded else None, cost, wrong)


def made_up_plan(number):
    """What `desim plan` may find, by chance: enough, open, on the edge, none, with and without growth."""
    chance = random.Random(number)

    def sized(name, growth):
        robots, chargers = range(1, chance.randint(4, 9)), range(1, chance.randint(2, 4))
        counts = tuple((first, second) for first in robots for second in chargers)
        at = (chance.randint(2, robots[-1]), chance.randint(1, chargers[-1]))
        kind = chance.choice(["met", "met", "none", "ended"])
        best = None if kind == "none" else shown(chance, at, "meets")
        under = (at[0] - 1, chargers[-1]) if best else counts[-1]
        below = (
            shown(chance, under, chance.choice(["fails", "undecided"]) if best else "fails", chance.random() < 0.3),
        )
        left = tuple(chance.sample(counts, 2)) if kind == "ended" else ()
        busy = {Load(Group("robots"), 0.941): Estimate(10, 0.941, (0.93, 0.95), 0.01, 0.94, {}, False, 0.95)}
        change = {"tasks.demand": growth}
        return Sized(name, growth, 60.0 * growth, best, below, busy, False, change, left, counts=counts)

    grown = sized("growth", 1.3) if chance.random() < 0.6 else None
    runs = chance.randint(20, 5000)
    today = sized("today", 1.0)
    demands = (today,) if grown is None else (today, grown)
    sizes = FleetSizes(example(), GOAL, 0.01, 0.95, "nearest", demands, (), None, Designs(example()), runs, (), number)
    return worded(sizes)


def text_of(source):
    """What a page says, unfolded, without its style."""
    body = re.sub(r"<style>.*?</style>", "", source, flags=re.DOTALL)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", body)).replace("\u00a0", " "))


def is_everywhere(answer):
    """Whether terminal, page and JSON say the same, every number once with one interval."""
    shown, terminal = text_of(page(answer)), printed(answer, 400)
    content = json.loads(json.dumps(answer.content()))
    assert content["answer"] == list(answer.answer)
    for line in (*answer.answer, *answer.notes, answer.promise):
        assert line in shown
        assert line in terminal
        assert not BRACKETS.search(line)
    intervals, left_out = {}, 0
    for option, kept in zip(answer.options, content["options"], strict=True):
        assert re.sub(r"\s+", " ", option.text) in shown
        assert re.sub(r"\s+", " ", option.full_name) in shown
        left_out += option.text not in terminal or option.full_name not in terminal
        assert kept["number"] is None or option.text.startswith(kept["number"]["text"])
        assert not (option.standing == "overloaded" and option.number)
        if option.number:
            intervals.setdefault((option.name, option.group), set()).add(option.number.text)
    assert all(len(spellings) == 1 for spellings in intervals.values())
    assert left_out <= sum(map(int, re.findall(r"(\d+) more options?", terminal)))
    if isinstance(answer.figure, Rows):
        texts = {", ".join(filter(None, (one.group, one.name))): one.numbers for one in answer.options}
        assert all(mark.text in [number.text for number in texts[mark.label]] for mark in answer.figure.rows)
    if answer.about is None:
        assert not answer.tiles
    *tables, _ = printed(answer, 80).split("\n\n")[1:]
    assert all(len(line) <= 80 for table in tables for line in table.splitlines())
    return True


@pytest.mark.parametrize("number", some(range(40), 8))
def test_terminal_page_and_json_of_why_are_equal(number):
    assert is_everywhere(made_up_why(number).answer)


@pytest.mark.parametrize("number", some(range(40), 8))
def test_terminal_page_and_json_of_plan_are_equal(number):
    plan = made_up_plan(number)
    answer = plan.answer
    assert is_everywhere(answer)
    # the page shows the fleet of an answer, of which the first or second sentence speaks, or none
    demands = [one for one in (plan.grown, plan.today) if one is not None and one.best and not one.open]
    if not demands:
        assert (answer.about, answer.tiles) == (None, ())
    else:
        best = demands[0].best
        assert answer.about.model["fleet"]["size"] == best.robots
        if plan.grown is None:
            assert (answer.tiles[0].value, answer.tiles[1].value) == (str(best.robots), str(best.chargers))
        else:  # a tile for each demand
            assert answer.tiles[-1].value == named(plan, best.counts)
        assert any(line.startswith(answer.about.name.partition(",")[0]) for line in answer.answer)
    for sized, panel in zip(filter(None, (plan.today, plan.grown)), answer.figure.panels.values(), strict=True):
        cells = [cell for row in panel for cell in row]
        follows = [one for one in sized.open if not is_known(sized, one)]
        assert cells.count("open") >= len(follows)
        assert not set(cells) - set(WORDS)


def is_known(sized, one):
    """Whether it follows from others that a fleet is enough, or is not."""
    best = sized.best
    above = best and one[0] >= best.robots and one[1] >= best.chargers
    return above or any(one[0] <= few.robots and one[1] <= few.chargers for few in sized.below)


def test_the_sheet_of_a_plan_has_nearest_misses_what_changes_it_and_what_it_rests_on():
    """11 robots and 3 chargers are enough; 10 and 5 miss by less than 7 and 5. Two guesses are left in the model."""
    chance = random.Random(3)
    best, close, far = shown(chance, (11, 3), "meets"), shown(chance, (10, 5), "fails"), shown(chance, (7, 5), "fails")
    far = replace(far, verdict=replace(far.verdict, mean=0.61, low=0.5, high=0.7))
    today, later = (
        Sized(name, growth, 200 * growth, best, (far, close), {}, False, {}, counts=((11, 3), (10, 5), (7, 5)))
        for name, growth in (("today", 1.0), ("growth", 1.3))
    )
    sizes = FleetSizes(example(), GOAL, 0.01, 0.95, "nearest", (today, later), (), None, Designs(example()), 400)
    answer = worded(sizes, guesses=["tasks.load_time", "fleet.robot.speed"]).answer
    assert [[bar.label for bar in figure.rows] for figure in answer.nearest] == [
        ["11 robots and 3 chargers", "10 robots and 5 chargers"]
    ] * 2
    changes, rests = (dict(part.rows) for part in answer.tables if part.on_sheet)
    assert changes == {
        "With 30 % more orders (260 an hour)": "11 robots and 3 chargers",
        "Guesses that are wrong": "not tried",
    }
    assert rests["Guesses left, marked (!)"] == "2: load time, speed"
    assert rests["Simulated"].startswith("400 days, each ")
    assert "people in the aisles" in rests["Not in this model"]
    source = text_of(page(answer))
    assert "What the answer rests on" in source.partition("Everything tried")[0]
    assert "What the answer rests on" not in printed(answer)


def test_a_better_strategy_has_its_name_in_each_row_and_each_design_has_one_row():
    """With earliest-due 4 robots and 1 charger are enough; with nearest 4 and 3 are not, and hungarian is like it."""
    chance, due = random.Random(7), {"policies.allocation": "earliest-due"}
    few, enough = ((3, 5), "fails"), ((4, 3), "meets")
    best, own_best = shown(chance, (4, 1), "meets"), shown(chance, (5, 1), "meets")
    own_few = tuple(shown(chance, counts, "fails") for counts, _ in (few, enough))
    today = Sized("today with earliest-due", 1.0, 60.0, best, (shown(chance, *few),), {}, False, due)
    with_own = Sized("today", 1.0, 60.0, own_best, own_few, {}, False, {})
    earliest = Strategy("earliest-due", due, (shown(chance, *few), shown(chance, *enough)))
    hungarian = Strategy("hungarian", {"policies.allocation": "hungarian"}, (), ((3, 5), (4, 3)))
    sizes = FleetSizes(
        *(example(), GOAL, 0.01, 0.95, "nearest", (today,), (hungarian, earliest), earliest, Designs(example()), 400),
        with_own=with_own,
    )
    rows = [(option.full_name, option.set.get("policies.allocation")) for option in worded(sizes).answer.options]
    assert rows == [
        ("4 robots and 1 charger, earliest-due", "earliest-due"),
        ("3 robots and 5 chargers, earliest-due", "earliest-due"),
        ("3 robots and 5 chargers, nearest (same results: hungarian)", None),
        ("4 robots and 3 chargers, nearest (same results: hungarian)", None),
        ("4 robots and 3 chargers, earliest-due", "earliest-due"),
    ]


def test_every_open_fleet_is_named_or_counted():
    """Ten robots and five chargers were judged last and remain open, and with them all that are smaller."""
    chance = random.Random(5)
    best, close = shown(chance, (11, 3), "meets"), shown(chance, (10, 5), "undecided")
    close = replace(close, verdict=replace(close.verdict, within_zone=False))
    few = (shown(chance, (7, 5), "fails"), shown(chance, (14, 2), "fails"))
    counts = tuple((robots, chargers) for robots in range(6, 15) for chargers in range(2, 6))
    sized = Sized("today", 1.0, 200.0, best, (close, *few), {}, False, {}, counts=counts)
    sizes = FleetSizes(example(), GOAL, 0.01, 0.95, "nearest", (sized,), (), None, Designs(example()), 400)
    assert "8 to 10 robots and 3 to 5 chargers may also be enough; " in worded(sizes).answer.answer[0]


@pytest.mark.parametrize(
    ("robots", "changes", "runs"),
    [
        ("2..3", {**LASTING, "run.length": 1800, "run.warm_up": 300}, {"first": 3, "cap": 6}),
        pytest.param("1..4", {}, {}, marks=pytest.mark.long),
    ],
    ids=["few runs", "many"],
)
def test_a_plan_has_the_page_of_its_fleet(tmp_path, robots, changes, runs):
    search, model = dw.Search(out=tmp_path, **runs), example().replace(changes)
    plan = plan_fleet(model, "on_time >= 75 %", growth=2, strategies={}, robots=robots, search=search)
    plan.answer.save(tmp_path)
    source = needs_nothing_from_outside(report(tmp_path).read_text(encoding="utf-8")).text
    for line in plan.answer.answer:
        assert line in source.replace("\u00a0", " ")
    shown, days = plan.answer.about, (plan.grown.best or plan.today.best).days
    assert [one.seed for one in (shown, shown.worst)] == [run_seed(0, run) for run in (days.median_run, days.worst_run)]
    by_seed = {seed: dw.simulate(shown.model, seed).kpis["on_time"] for seed in (shown.seed, shown.worst.seed)}
    assert list(by_seed.values()) == pytest.approx([days.median, days.worst])
    for text in (shown.day, shown.worst.words):
        assert capital(text) in source
    assert "Watch this run" in report(tmp_path, replay=True).read_text(encoding="utf-8")
    assert (tmp_path / "report-replay.html").is_file()
    assert "iframe" in plan._repr_html_()


def test_copies_of_a_design_are_one_row_and_cost_no_certainty():
    """A key that nothing asks for: two copies of each of two fleets, judged as two designs."""
    copies = {"fleet.size": [1, 3], "case": {"cases": {"own": {}, "another": {"name": "by another name"}}}}
    model = example().replace(LASTING)
    alone = dw.Study(model, {"fleet.size": [1, 3]}, replications=4, target="on_time >= 60 %").run().results
    both = dw.Study(model, copies, replications=4, target="on_time >= 60 %").run().results
    assert len(both.same) == 2
    bounds = [(one.low, one.high) for one in alone.judged.values()]
    assert [(one.low, one.high) for one in both.judged.values()] == [end for end in bounds for _ in range(2)]
    assert [one.full_name for one in both.answer.options] == [
        f"{count}, case: own (same results: another)" for count in ("1 robot", "3 robots")
    ]


def test_size_leads_with_its_count(tmp_path):
    cases = {"fleet.size": [1, 2, 3, 4]}
    model = example().replace({**LASTING, "run.length": 1800, "run.warm_up": 300})
    study = dw.Study(model, cases, name="size", target="on_time >= 75 %")
    study.plan = study.plan.unreplicated()
    sizing = size(study, "on_time >= 75 %", search=dw.Search(first=5, cap=40, out=tmp_path))
    answer = sizing.answer
    assert is_everywhere(answer)
    assert answer.tiles[0].value == str(sizing.smallest)
    assert dw.load(answer.about.model).fleet.size == sizing.smallest
    by_value = {one.value: one for one in sizing.decisions}
    for option in answer.options:
        one = by_value[option.set["fleet.size"]]
        assert option.number is None or (option.number.low, option.number.high) == (one.low, one.high)


def test_why_is_about_the_warehouse_as_it_is_and_its_page_shows_no_other(tmp_path):
    model = example().replace(LASTING)
    diagnosis = why(model, search=dw.Search(cap=5, first=5, out=tmp_path))
    answer = diagnosis.answer
    answer.save(tmp_path)
    assert answers.load(tmp_path) == answer
    assert dw.load(answer.about.model).fleet.size == model.fleet.size
    assert answer.tiles[0].what.endswith("as it is")
    assert float(answer.tiles[0].value.removesuffix(" min")) == pytest.approx(diagnosis.as_it_is.mean / 60, rel=0.01)
    source = report(tmp_path).read_text(encoding="utf-8")
    assert f"<h2>{answer.about.name.capitalize()}" in source
    assert source.partition("<details")[0].count("<figure") <= 3
    assert "<img" not in source
    assert len(source) < 40_000
    assert "iframe" in diagnosis._repr_html_()


def test_an_answer_is_as_its_schema_says():
    schema = CliRunner().invoke(desim, ["schema", "--answer"], catch_exceptions=False).output
    jsonschema.validate(json.loads(made_up_why(3).answer.model_dump_json()), json.loads(schema))


def test_a_damaged_answer_is_one_message(tmp_path):
    made_up_why(0).answer.save(tmp_path)
    path = tmp_path / "answer.json"
    path.write_text(path.read_text(encoding="utf-8").replace('"kind"', '"king"'), encoding="utf-8")
    with pytest.raises(ReportError, match=r"damaged, or made by another version: kind: Field required; run the same"):
        answers.load(tmp_path)
    path.write_text("{", encoding="utf-8")
    with pytest.raises(ReportError, match="damaged"):
        answers.load(tmp_path)


SAID_IN = [
    path for package in (answer_package, questions) for path in sorted(Path(package.__file__).parent.glob("*.py"))
]
"""Modules that have sentences."""


def test_no_template_has_a_bracket_in_a_bracket():
    """Whatever is put into a sentence: what stands in brackets in its template has no brackets of its own."""
    nested = []
    for path in SAID_IN:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.JoinedStr):
                text = "".join(str(one.value) if isinstance(one, ast.Constant) else "x" for one in node.values)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                text = node.value
            else:
                continue
            if BRACKETS.search(text) and "\n" not in text:
                nested.append((path.name, text))
    assert nested == []


def test_keys_of_a_model_stand_in_commands_only():
    """A sentence names robots and lanes, not fleet.size and traffic; `input_words` has lines for a model file."""
    key = re.compile(r"\b(fleet|traffic|tasks|layout|policies|battery|prices|run)\.[a-z_]+")
    keys = []
    for path in SAID_IN:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            text = node.value if isinstance(node, ast.Constant) else None
            is_sentence = isinstance(text, str) and " " in text and "\n" not in text and not text.endswith(".")
            if is_sentence and key.search(text.partition("desim ")[0]) and path.name != "input_words.py":
                keys.append((path.name, text))
    assert keys == []


LONG = [pytest.mark.long]
STUDIES = [*some(range(12), 6), *(pytest.param(number, marks=LONG) for number in range(12, 40))]


def study_by_chance(number):
    """A small study: with and without a target, prices, growth, several fleets, chargers and ways of dispatching."""
    chance = random.Random(number)
    factors = {"fleet.size": sorted(chance.sample([1, 2, 3, 4], chance.randint(1, 3)))}
    if chance.random() < 0.5:
        factors["policies.allocation"] = ["nearest", "hungarian"]
    targets = [None, "on_time >= 50 %", "on_time >= 70 %", "on_time >= 99 %"]
    target = chance.choice([*targets, "cycle_time_mean <= 90", "throughput_per_hour >= 55"])
    base = example().replace({**LASTING, "run.length": 1800, "run.warm_up": 300})
    if chance.random() < 0.4:
        base = base.replace({"prices": {"hours": 4000, "robot": 9000}})
    replications = chance.randint(2, 5)
    if number >= len(STUDIES) // 4 and chance.random() < 0.4:
        factors["tasks.demand"] = [1, 1.6]
    if number >= len(STUDIES) // 4 and chance.random() < 0.3:
        factors["tasks.load_time"] = [5, 12]
    return dw.Study(base, factors, replications=replications, seed=number, target=target)


@pytest.mark.parametrize("number", STUDIES)
def test_numbers_of_a_first_page_are_of_the_option_of_its_sentence_and_have_one_interval(number):
    """On answers of random small studies: terminal, page, JSON, the page of sliders and the live page agree."""
    results = study_by_chance(number).run().results
    answer = results.answer
    assert is_everywhere(answer)
    if answer.about is None:
        assert answer.tiles == ()
    else:
        models = [results.base.replace(one.set).content() for one in answer.options]
        option = answer.options[models.index(answer.about.model)]
        texts = {one.of: one.text for one in option.numbers}
        for tile in answer.tiles:
            whole = f"{tile.value} ({tile.note})" if tile.note else tile.value
            assert whole in texts.values() or tile.what == "cost a year"
        sentences = " ".join(answer.answer)
        assert option.name in sentences or capital(option.name) in sentences or len(answer.options) == 1
    first = text_of(page(answer)).partition("Everything tried")[0]
    listed = {text for one in answer.options for text in [one.instead, *(number.text for number in one.numbers)]}
    for interval in re.findall(INTERVAL, first):
        assert any(interval in text for text in listed), interval
    told = re.findall(INTERVAL, " ".join(answer.answer))
    assert len(told) == len(set(told))
    if len(results.designs) > 1:
        watched = [one for _, one in held(dw.what_if_page(results).html)["designs"]]
        shown = {number["text"] for one in watched for number in one["measured"]}
        assert shown == {number.text for one in answer.options for number in one.numbers}
    is_what_the_live_page_says(results)


INTERVAL = r"[\d.,−]+ (?:%|\S+) \(\S+ to \S+\)"


def is_what_the_live_page_says(results):
    """Its sentence and its numbers have one interval; without a target, whose looks split, it is that of the study."""
    main, goal = next(iter(results.answer.measures)), results.target
    for design in results.designs:
        outcomes = [row.outcome for row in results.runs(design)]
        runs = RunsSoFar(Named(design, {}, results.models[design]), outcomes, main, results.plan.seed)
        measured = {one.name: one.text for one in runs.measured(goal)}
        sentence = runs.in_words(goal).sentence
        assert all(interval in measured[main] for interval in re.findall(INTERVAL, sentence))
        if runs.lasting is not None:
            assert re.findall(INTERVAL, sentence) == []
        estimates = {
            one: results.estimate(results.runs(design), one) for one in measured if goal is None or one != main
        }
        for of, estimate in estimates.items():
            scale = words.scale(of, runs.model, (estimate.mean,))
            low, high = estimate.interval or (None, None)
            assert measured[of] == judged_words.within(of, scale, (estimate.mean, low, high)).text
