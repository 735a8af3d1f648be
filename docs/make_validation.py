"""docs/dev/validation.md with its figures, made anew: `python -m docs.make_validation` (some ten minutes of processor).

The cases are those of the tests (`tests/theory/cases.py`, `tests/reference`), with the same seeds; `make test` checks
that the fast ones still give the rows of the page, `make test-long` all of them.
"""

from __future__ import annotations

import random
import statistics
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import desim_warehouse as dw
from desim_warehouse.look.palette import COLOURS, FAINT
from docs.make_reference import table
from tests.reference import rawsimo
from tests.reference.paper import CELLS, GROUPS, changes, settings
from tests.reference.stepped import Setting, simulate
from tests.reference.stops import SAME, SHORT, Unmatched, unmatched
from tests.study.statistics import coverage
from tests.theory.cases import CASES, WITHIN, Found, half_width

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "dev" / "validation.md"
PICTURES = ROOT / "docs" / "pictures"
MULTIBOTS = ROOT / "models" / "multibots.yaml"
ROBOTS = tuple(range(1, 13))
_PLANS = 300
LISTS = 20  # random experiments for each number of robots
MEDIAN = 0.005  # beside the stepped reference
BESIDE = 0.01  # in the cells of the paper


HEAD = """# Validation

Does the simulator compute what it should? This page compares it with theory, with a second program that shares no
code with it, and with the paper. `make validation` regenerates the page; seeds are fixed, so the figures are
reproducible. `make test` checks the fast rows and the laws below, `make test-long` all of them.

No page can tell whether a *model*, with your layout, times and orders, is right: compare a run of yesterday's orders
with what happened yesterday ([What it cannot do](../cannot.md), [STRESS checklist](stress.md)).

## How it is judged

- Stochastic cases: independent runs, of which the 99 % interval of the mean (Student's t) must **contain** the
  theoretical value and lie **within 3 %** of it. By chance one interval in a hundred would miss; with these seeds
  none does.
- Deterministic cases: one run, which must come within the stated bound.

![Where chance plays a part: simulated against theory, with 99 % intervals](../pictures/validation.png)

![Where it does not: closed lines and rings by the number of robots](../pictures/validation-curves.png)
"""
LITTLE = """## Little's law on every run

The average number of open tasks L equals their arrival rate times their mean time W. `tests/little.py` computes the
area under the number of open tasks from the log, event by event, and compares it with `tasks` and `cycle_time_mean`
of the indicators. Tasks cut off at either end of the counted time are included, so the law holds exactly, not just
in the limit. It is checked to 1e-9 on every random warehouse of `tests/laws`, 82 in `make test` and 23,000 in
`make test-long`, with stations, batteries, two-way lanes, zones and every policy; on runs with several flows, for
each flow; and on the packing hall.
"""
BESIDES = """## The same rules, step by step

`tests/reference/stepped.py` is an independent reimplementation of the paper's program: it moves every robot 0.05 s
at a time and tests the distance and bearing of every pair, as the paper does. It shares no code with the event-based
simulator. For each number of robots {lists} experiments are drawn: goods, unloading letter, thresholds, consumption.
Steps round every drive up to whole steps and jump over short conflicts, and a different order of arrival at a node
may change the rest of an experiment. So the values of T do not agree exactly: in most experiments they differ by a
fraction of a percent, in a few by more. Half of the experiments must be within 0.5 %, and the interval of the mean
ratio within 3 %.

**S has no verdict.** It counts how often a robot stops, and steps of 4 px jump over short stops: a robot right
behind another waits 1.5 steps here while that one is on a node, and need not stop in the stepped program. "Alone"
counts the waits without a counterpart in the other model (of the same robot at the same time), in experiments whose
T differs by at most {same} steps. Short waits take up to {short} steps.
"""
SUMS = """
In all experiments S is {here:,} here and {there:,} stepped, {more:+.1f} %. Short waits alone: {short} here and
{stepped_short} stepped. Longer ones, where robots arrive at a node in another order: {longer} and {stepped_longer}.
"""
PAPER = """## The paper's cells

The 30 cells of the paper, 1 to 6 robots and five lists of goods, compared with the authors' program. [The paper's
experiment](../paper.md) has the means; `desim paper` shows each cell. The program works in steps, so theory gives no
bound, and we report only the differences.
"""
FINER = """
The stepped reference has the program's T and C in all cells, and S {whole}. With steps cut in 2 and in 4 its T stays
within {time:.2g} %, but S becomes {halves} and {quarters}: a robot that waits for another that turns off stops once
here and in whole steps. In finer steps it moves on in jerks, each of which counts. So S does not converge as steps
shrink.
"""
COVERAGE = """## How often answers are right

The commands' own code analyses synthetic days with known truth, in {studies} studies of each kind
(`tests/study/statistics/coverage.py`). Each kind should be right in 95 %; this many studies estimate the rate to
about 2 points. Tasks of one day are correlated, more so on floors that jam now and then. For up to 17 days, the
lower bounds of intervals for shares of tasks assume a correlation of at least 0.04, because a few days that happen
to be alike say little about the others. More days show the correlation themselves.
"""
MISSES = """A fleet that misses a target by 0.05 points should be declared to meet it in at most 5 % of plans. Plans
make up to seven interim analyses, after 5 to 80 days, and declare success after 33 days or more. Where
days differ gradually, the rate is kept at a target of 95 %. At a target of 99 % it is kept for
correlations of up to 0.05, and nearly at 0.1:
"""
KINDS = """If days are of two kinds, good and bad, bounds know nothing of bad days before the first occurs, so a
minimum number of days is required. Where the model has nothing rarer than one day in ten, 33 days are
needed, otherwise 59 of up to 120 (breakdowns and outages by their rates, `study/rare.py`). Rarer days are
not covered, and the answer says so. The table gives the share of plans, of {studies} for each cell, that
wrongly declare *met* for fleets that miss a share by 0.05 points or a time by 0.1 %:
"""
BETTER = """A fleet that exceeds its target by the indifference zone, here a quarter of the room above the target,
should be declared to miss it in at most 5 % of plans. Upper bounds rest on the observed days alone,
because rare bad days only lower a mean:
"""
LIVE = """The live page repeats its analysis as days come in, first after ten; it declares *met* from 35 on. For a
design *exactly at* its target it should ever do so in at most 5 % of sessions, here of 120 days:
"""
PODS = """## Goods to person beside RAWSim-O

We compare [RAWSim-O](https://github.com/merschformann/RAWSim-O) (commit d500e09), built unmodified, with this
simulator on one floor by the same rules: 5 x 5 blocks of 4 x 2 places, 170 pods, a hall of 10 m before two stations
of one picker and 9 `places`. Robots drive 1.5 m/s, accelerate at 1 m/s2 and turn in 0.625 s; lifting a pod takes 2.2
s, a line 10 s. Each station has 12 open orders of one line, and there are 200 in all, of 100 items, of which a pod
has 15. Half an hour of warm-up is discarded, two hours are counted, and means are of three runs. One figure was
fitted to RAWSim-O: 5.3 s to change pods. Its empty robots drive under pods, and ours do not, so distances are not
compared. Lines an hour:
"""
PODS_NEAR = """
The largest difference is {most:.1f} % for most lines and {nearest:.1f} % for the nearest pod. With most lines the
maximum is at {here} robots here and at {there} there.
"""
BANKS = """## Banks of made-up warehouses

These searches run on many warehouses with known truth. Each command takes minutes to hours, so `make validation`
does not repeat them:
"""
BANK_HEADS = ("question", "bank", "ours", "others")
BANK_ROWS = (
    (
        "`why`",
        "24 kinds of bottleneck, planted (`python -m tests.study.planted`)",
        "23 named first and alone",
        "",
    ),
    (
        "`best` with a target",
        "200 warehouses, 500 runs each (`python -m tests.study.best_banks 200`)",
        "1.10 % worse than the best, the target never missed",
        "random designs 2.46 %, 26 missed; successive halving 3.37 %, 2; CMA-ES 0.14 %, 20; TPE 0.18 %, 4 of 60",
    ),
    (
        "`best --directions`",
        "512 designs of a floor, 500 runs",
        "the best found in 97 % of searches",
        "random designs 40 %, successive halving 37 %, CMA-ES 62 %",
    ),
    (
        "`orient`",
        "14 floors (`python -m tests.study.directions_gains 0 14`)",
        "6.7 to 15.2 % gained on fresh days",
        "",
    ),
    (
        "thresholds",
        "300 plants (`python -m tests.study.tipping_banks 300`)",
        "619 of 632 in their intervals, 412 confirmed on both sides",
        "a parabola through three probes: 603 and 248; straight lines: nothing in 12 of 50",
    ),
    (
        "two-way lanes",
        "700 random runs (`python -m benchmarks.two_way strict`)",
        "of states granted none was dead; of 14,675 refused 108 were not",
        "by an acyclic relation 4,899",
    ),
)
"""Figures that their commands print; not made anew with the page."""
TAIL = """## What else is checked

- Single robots on worked routes, intersections, rings and stations, calculated by hand (`tests/world`).
- An auditor rebuilds positions from the log and applies the paper's rule literally, and a recount computes every
  indicator again from the log; both on random warehouses (`tests/laws`).
- Liveness: work ends in thousands of random worlds, and in every reachable state of small ones.
- Further statistics: quantiles, selections, screening, warm-ups (`tests/study/statistics`).
"""


# Rows


def row(estimate: Found) -> str:
    """The line of the page for one quantity of a case."""
    verdict = "agrees" if estimate.contains and estimate.near else "DIFFERS"
    interval = f"± {estimate.half_width:.2g}" if len(estimate.values) > 1 else "no chance"
    difference = round(100 * (estimate.mean / estimate.quantity.theory - 1), 2) + 0.0  # no -0.00
    cells = (
        estimate.case.title,
        estimate.quantity.name,
        f"{estimate.quantity.theory:.5g}",
        f"{estimate.mean:.5g}",
        interval,
        f"{difference:+.2f} %",
        f"{verdict} ({100 * estimate.quantity.within:g} %)",
    )
    return "| " + " | ".join(cells) + " |"


def cases(section: str, estimates: Iterable[Found]) -> str:
    """The table of a section."""
    heads = ("case", "quantity", "theory", "simulated", "99 % interval", "difference", "verdict (bound)")
    head = table(heads, [], "llrrrr")
    return f"## {section}\n\n{head}" + "\n".join(row(one) for one in estimates if one.case.section == section) + "\n"


# The stepped reference


class Beside(NamedTuple):
    """Experiments with one number of robots in both models: ratios of T, and stops and charges counted.

    `alone`: waits without a counterpart in the other model, in the experiments that go `alike`.
    """

    robots: int
    ratios: tuple[float, ...]
    stops: int
    expected_stops: int
    same_charges: int
    alike: int
    alone: Unmatched

    @property
    def half_width(self) -> float:
        """Of the mean ratio."""
        return half_width(self.ratios)

    @property
    def mean(self) -> float:
        """Of the ratios."""
        return statistics.fmean(self.ratios)

    @property
    def median(self) -> float:
        """How much T differs in the middle of the experiments."""
        return statistics.median(abs(ratio - 1) for ratio in self.ratios)

    @property
    def agrees(self) -> bool:
        """Whether half of the experiments are within 0.5 %, and the interval of the mean within 3 %; C is equal."""
        near = self.median <= MEDIAN and abs(self.mean - 1) + self.half_width <= WITHIN
        return near and self.same_charges == len(self.ratios)

    @property
    def row(self) -> tuple[str, ...]:
        """Its line of the page."""
        return (
            f"{self.robots}",
            f"{100 * self.median:.2f} %",
            f"{100 * (self.mean - 1):+.2f} %",
            f"± {100 * self.half_width:.2f} %",
            f"{self.stops}",
            f"{self.expected_stops}",
            f"{self.same_charges} of {len(self.ratios)}",
            "agree" if self.agrees else "DIFFER",
            f"{self.alone.here} + {self.alone.here_longer}",
            f"{self.alone.stepped} + {self.alone.stepped_longer}",
        )


def beside(robots: int) -> Beside:
    """The event model and the stepped reference with one number of robots."""
    model = dw.load(MULTIBOTS)
    ratios, stops, expected_stops, same, experiments = [], 0, 0, 0, []
    for setting, expected in settings(random.Random(robots), LISTS, robots=robots):  # noqa: S311 - for work
        experiments.append((model.replace(changes(setting)), setting))
        run = dw.simulate(experiments[-1][0])
        ratios.append(run.T / expected.T)
        stops, expected_stops = stops + run.S, expected_stops + expected.S
        same += run.C == expected.C
    return Beside(robots, tuple(ratios), stops, expected_stops, same, *unmatched(experiments))


def reference() -> tuple[str, list[Beside]]:
    """The section on the stepped reference."""
    besides = [beside(robots) for robots in ROBOTS]
    heads = ("robots", "T, median difference", "T, mean", "99 % interval", "S", "S stepped", "C equal", "T and C")
    heads += ("waits alone here, short + longer", "alone stepped")
    intro = BESIDES.format(lists=LISTS, same=SAME, short=SHORT)
    return f"{intro}\n{table(heads, (one.row for one in besides), 'rrrrrrrlrr')}{_sums(besides)}", besides


def _sums(besides: Sequence[Beside]) -> str:
    here, there = sum(one.stops for one in besides), sum(one.expected_stops for one in besides)
    short, longer, stepped_short, stepped_longer = (
        sum(one) for one in zip(*(one.alone for one in besides), strict=True)
    )
    return SUMS.format(
        here=here,
        there=there,
        more=100 * (here / there - 1),
        short=short,
        longer=longer,
        stepped_short=stepped_short,
        stepped_longer=stepped_longer,
    )


# The paper


def paper() -> str:
    """The section on the paper's cells."""
    model = dw.load(MULTIBOTS)
    off, stops, charges = [], 0, 0
    for cell in CELLS:
        goods = list(GROUPS[int(cell["group"])])
        run = dw.simulate(model.replace({"fleet.size": int(cell["robots"]), "tasks.goods": goods}))
        off.append(abs(run.T / cell["T_steps_program"] - 1))
        stops += run.S
        charges += cell["C_program"] == run.C
    expected = sum(int(cell["S_program"]) for cell in CELLS)
    rows = [
        ("T within 1 %", f"{sum(one <= BESIDE for one in off)} of 30 cells"),
        ("T, median and largest difference", f"{100 * statistics.median(off):.2f} %, {100 * max(off):.2g} %"),
        ("C equal", f"{charges} of 30 cells"),
        ("S of all cells", f"{stops}, by the program {expected}"),
    ]
    return f"{PAPER}\n{table(('what', 'here'), rows)}{_finer()}"


def _finer() -> str:
    """What the rules of the program give in finer steps."""
    runs = {
        finer: [simulate(Setting(int(cell["robots"]), GROUPS[int(cell["group"])], finer=finer)) for cell in CELLS]
        for finer in (1, 2, 4)
    }
    stops = {finer: sum(outcome.S for outcome in outcomes) for finer, outcomes in runs.items()}
    apart = max(abs(fine.T / whole.T - 1) for finer in (2, 4) for fine, whole in zip(runs[finer], runs[1], strict=True))
    return FINER.format(whole=stops[1], time=100 * apart, halves=stops[2], quarters=stops[4])


# Goods to person


def pods() -> str:
    """The section on RAWSim-O."""
    rates = {rule: {robots: rawsimo.lines_an_hour(rule, robots) for robots in rawsimo.LINES} for rule in rawsimo.RULES}
    apart, rows = {}, []
    for robots, there in rawsimo.LINES.items():
        here = [rates[rule][robots] for rule in rawsimo.RULES]
        rows.append((robots, *(f"{one:.1f}" for pair in zip(here, there, strict=True) for one in pair)))
    for number, rule in enumerate(rawsimo.RULES):
        apart[rule] = max(abs(rates[rule][n] / there[number] - 1) for n, there in rawsimo.LINES.items())
    first, second = rawsimo.RULES
    heads = ("robots", f"{first}: here", "RAWSim-O", f"{second}: here", "RAWSim-O")
    best = max(rawsimo.LINES, key=lambda n: rawsimo.LINES[n][0])
    comparison = PODS_NEAR.format(
        most=100 * apart[first], nearest=100 * apart[second], here=max(rates[first], key=rates[first].get), there=best
    )
    return f"{PODS}\n{table(heads, rows, 'rrrrr')}{comparison}"


# Coverage


def answers() -> str:
    """The section on how often what commands say is so."""
    rows = [(one.command, one.days, f"{100 * one.covered():.1f} %") for one in coverage.CASES]
    parts = [COVERAGE.format(studies=coverage.STUDIES), table(("command", "days", "right"), rows, "llr")]
    heads = ("target", "tasks a day", *(f"correlation {alike}" for alike in coverage.ALIKE))
    for text, wrong in ((MISSES, coverage.wrongly_met), (BETTER, coverage.wrongly_missed)):
        rows = [
            (
                f"{100 * target:g} %",
                f"{tasks:,}",
                *(f"{100 * wrong(target, tasks, alike, 200):.1f} %" for alike in coverage.ALIKE),
            )
            for target in (0.95, 0.99)
            for tasks in (50, 200, 1000)
        ]
        parts += [text, table(heads, rows, "rrrrrr")]
        if wrong is coverage.wrongly_met:
            parts += [KINDS.format(studies=_PLANS), table(*_kinds())]
    live = [
        (days, f"{100 * coverage.ever_met(draw, target, within, 400):.1f} %")
        for days, target, within, draw in coverage.AT_THE_TARGET
    ]
    parts += [LIVE, table(("days of a design exactly at its target", "said to meet it"), live, "lr")]
    return "\n".join(parts)


def _kinds() -> tuple[tuple[str, ...], list[tuple[str, ...]], str]:
    """The table of days of two kinds."""
    heads = ("a bad day", "days needed", "95 % on time, 100 tasks a day", "400 tasks a day", "a time")
    rows = []
    for kind in coverage.TWO_KINDS:
        met = [kind.wrongly_met(0.95, tasks, _PLANS) for tasks in (100, 400)] + [kind.wrongly_met_in_time(_PLANS)]
        rows.append((f"one in {kind.every}", str(kind.days.least), *(f"{100 * rate:.1f} %" for rate in met)))
    return heads, rows, "llrrr"


# Figures


def intervals(estimates: Sequence[Found], besides: Sequence[Beside]) -> Figure:
    """Every row with chance in it, as a difference from theory in percent with its interval."""
    from matplotlib.figure import Figure

    lines = [
        (f"{one.case.title}: {one.quantity.name}", one.mean / one.quantity.theory, one.half_width / one.quantity.theory)
        for one in estimates
        if len(one.values) > 1
    ]
    lines += [(f"stepped reference, robots: {one.robots}, T", one.mean, one.half_width) for one in besides]
    drawn = Figure(figsize=(10, 0.2 * len(lines) + 1), layout="constrained")
    axes = drawn.subplots()
    axes.axvspan(-100 * WITHIN, 100 * WITHIN, color=FAINT, alpha=0.18, linewidth=0)
    axes.axvline(0, color=FAINT, linewidth=1)
    for place, (_, ratio, half) in enumerate(reversed(lines)):
        style = {"color": COLOURS[0], "markersize": 3.5, "capsize": 2, "linewidth": 1}
        axes.errorbar(100 * (ratio - 1), place, xerr=100 * half, fmt="o", **style)
    axes.set_yticks(range(len(lines)), [name for name, _, _ in reversed(lines)], fontsize=6.5)
    axes.set_ylim(-0.8, len(lines) - 0.2)
    axes.set_xlim(-4, 4)
    axes.set_xlabel("simulated less theory, %\n(99 % intervals; shaded: 3 %)")
    axes.spines[["top", "right"]].set_visible(False)
    return drawn


def curves(estimates: Sequence[Found]) -> Figure:
    """Closed lines and rings by the number of robots: theory as lines, runs as points."""
    from matplotlib.figure import Figure

    points = [one for one in estimates if one.case.curve and one.quantity is one.case.quantities[0]]
    drawn = Figure(figsize=(9, 3), layout="constrained")
    for axes, section in zip(drawn.subplots(1, 2), dict.fromkeys(one.case.section for one in points), strict=True):
        shown = [one for one in points if one.case.section == section]
        for number, curve in enumerate(dict.fromkeys(one.case.curve for one in shown)):
            of = [one for one in shown if one.case.curve == curve]
            robots = [one.case.robots for one in of]
            axes.plot(robots, [one.quantity.theory for one in of], color=COLOURS[number], label=f"{curve}, theory")
            axes.plot(robots, [one.mean for one in of], "o", color=COLOURS[number], markersize=5, label="simulated")
        axes.set_xlabel("robots")
        axes.set_ylabel(shown[0].quantity.name)
        axes.set_ylim(0, None)
        axes.legend(frameon=False, fontsize=8)
        axes.spines[["top", "right"]].set_visible(False)
    return drawn


# The page


def page(estimates: Sequence[Found]) -> tuple[str, list[Beside]]:
    """The text of the page."""
    sections = dict.fromkeys(case.section for case in CASES)
    text, besides = reference()
    parts = [HEAD, *(cases(section, estimates) for section in sections), LITTLE, text, paper(), pods(), answers()]
    parts += [f"{BANKS}\n{table(BANK_HEADS, BANK_ROWS)}", TAIL]
    return "\n".join(parts), besides


def main() -> int:
    """Run every case, write the page and its figure; 1 where something differs."""
    estimates = []
    for case in CASES:
        estimates += case.simulate()
        print(*map(str, estimates[-len(case.quantities) :]), sep="\n", flush=True)
    text, besides = page(estimates)
    PAGE.write_text(text, encoding="utf-8")
    intervals(estimates, besides).savefig(PICTURES / "validation.png", dpi=110)
    curves(estimates).savefig(PICTURES / "validation-curves.png", dpi=110)
    print(PAGE.relative_to(ROOT))
    return int("DIFFERS" in text)


if __name__ == "__main__":
    sys.exit(main())
