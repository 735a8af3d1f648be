"""Each number has one interval, that of its verdict, whose ends never look like what they are not."""

import random
import re

import pytest

from desim_warehouse.answer import standing
from desim_warehouse.answer.numbers import PERCENT, Scale
from desim_warehouse.outcome.verdicts import Verdict, judge
from desim_warehouse.questions import sentences
from desim_warehouse.questions.study import Study
from desim_warehouse.report.example import example
from desim_warehouse.study.statistics.judge import DesignVerdict
from tests.lasting import LASTING

ONE = r"([<>]?[\d.,−]+)"
ENDS = re.compile(rf"{ONE}[^(]*\({ONE} to {ONE}\)")


def read(text):
    return [number(one) for one in ENDS.fullmatch(text).groups()]


def number(text):
    value = float(text.lstrip("<>").replace("−", "-").replace(",", ""))
    return value / 2 if text.startswith("<") else (value + 100) / 2 if text.startswith(">") else value


@pytest.mark.parametrize("times", [800, pytest.param(5000, marks=pytest.mark.long)])
@pytest.mark.parametrize("scale", [PERCENT, Scale("min", 1 / 60), Scale("tasks/h"), Scale("m", 1000.0)])
def test_neither_mean_nor_end_is_written_as_the_target_or_as_none_or_all_that_is_not(scale, times):
    chance = random.Random(1)
    for _ in range(times):
        aim = chance.choice([round(chance.uniform(0.5, 0.99), chance.randint(1, 4)), 0.0, 1.0])
        spread = 10 ** chance.uniform(-6, -1)
        mean = min(max(aim + chance.gauss(0, spread), 0), 1)
        low, high = max(mean - abs(chance.gauss(0, spread)), 0), min(mean + abs(chance.gauss(0, spread)), 1)
        shown = read(scale.within(mean, low, high, aim))
        for value, written in zip((mean, low, high), shown, strict=True):
            for other in (aim, 0.0, 1.0) if scale.is_share else (aim,):
                if value == other:
                    assert written == pytest.approx(scale.by * other, rel=0.01)
                else:
                    assert (written < scale.by * other) == (value < other), (value, written, other)
                    assert written != scale.by * other


@pytest.mark.parametrize(
    ("interval", "target", "expected"),
    [
        ((0.9838, 0.9462, 0.9991), 0.95, "98 % (94.6 to 99.9)"),
        ((0.976, 0.9496, 0.99), 0.95, "98 % (94.96 to 99)"),
        ((0.976, 0.95, 1.0), 0.95, "98 % (95 to 100)"),
        ((0.9503, 0.94, 0.96), 0.95, "95.03 % (94 to 96)"),
        ((0.98, 0.95, 1 - 1e-8), 0.94, "98 % (95 to 99.999)"),
        ((0.02, 1e-8, 0.07), 0.95, "2 % (0.001 to 7)"),
    ],
)
def test_only_what_would_look_like_the_target_has_more_digits(interval, target, expected):
    assert PERCENT.within(*interval, target) == expected


def test_what_a_table_and_a_sentence_show_is_the_interval_of_the_verdict():
    study = (
        Study(example().replace(LASTING), {"fleet.size": [1, 3, 4]}, replications=4, target="on_time >= 60 %")
        .run()
        .results
    )
    for design, one in study.judged.items():
        shown = study.shown(design, "on_time")
        assert shown.interval == (one.low, one.high)
        codes = [each.code for each in study.verdicts[design]]
        [option] = [each for each in study.answer.options if each.name == sentences.name_of(study, design)]
        assert (option.standing == "overloaded") == ("CANNOT_KEEP_UP" in codes)
        assert option.instead or option.text == PERCENT.within(one.mean, one.low, one.high, 0.6)


def test_near_the_target_and_not_known_yet_are_two_things():
    def judged(within):
        return DesignVerdict(1, "undecided", 30, 0.951, 0.949, 0.953, 0.99, False, within_zone=within)

    assert standing.WORDS[standing.standing(judged(False))] == "needs more runs"
    assert standing.WORDS[standing.standing(judged(True))] == "on the edge"
    falls = Verdict("BATTERIES_FALL", "batteries fall by 2 % an hour: not sustainable", 0.02)
    assert standing.WORDS[standing.lasts_not([falls])] == "cannot last"


def test_what_cannot_keep_up_is_said_as_what_it_delivers_of_what_came():
    model = example()  # 60 tasks an hour on average; in these 50 min 65 came, and 40 were delivered
    [grows] = judge({"tasks": 40, "throughput_per_hour": 48, "backlog_growth_per_hour": 30}, model)
    assert standing.instead([grows], model) == "only 48 of 78 loads an hour delivered"
    grows = Verdict("CANNOT_KEEP_UP", "cannot keep up: open tasks grow by 20 an hour", 20.0)
    assert standing.instead([grows], model) == grows.text  # what piles up is not the orders
    rises = Verdict("NOT_SETTLED", "not settled: batteries rise", -0.01)
    assert standing.instead([grows, rises], model) == grows.text
    text = "not settled: batteries fall by 5.6 % an hour in the counted time; settled, by hand"
    falls = Verdict("NOT_SETTLED", text, 0.06)
    assert standing.instead([falls], model) == "batteries fall by 5.6 % an hour"
