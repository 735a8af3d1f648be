"""A run in a few sentences: its deliveries, whether it keeps up, its busiest group, and its cost."""

from __future__ import annotations

import math
from collections.abc import Sequence

from desim_warehouse.answer import busiest, numbers, words
from desim_warehouse.answer.course import moment, stood_still
from desim_warehouse.answer.numbers import capital, sentence
from desim_warehouse.answer.parts import BigNumber
from desim_warehouse.answer.root_words import root as in_words
from desim_warehouse.answer.text import WIDTH, printed_table
from desim_warehouse.errors import number_of
from desim_warehouse.feasibility.asked import orders_a_day
from desim_warehouse.outcome.chains import lost_to
from desim_warehouse.outcome.halts import Halt, halts
from desim_warehouse.outcome.indicators import chosen, judged_by
from desim_warehouse.outcome.verdicts import is_no_answer, lost_in_a_day, piles_up
from desim_warehouse.questions.run.lasting import Lasting, lasting
from desim_warehouse.run import RunData
from desim_warehouse.states import FOR_PICKER
from desim_warehouse.study.rare import unknown
from desim_warehouse.values.units import SECONDS


def text(run: RunData, indicators: Sequence[str] = (), width: int = WIDTH) -> str:
    """Return a run as text: its sentences, and a table of indicators, by default the usual ones for such runs."""
    usual = judged_by(run.kpis, never_ends=run.model.tasks.never_end)
    shown = chosen(indicators, run.kpis) if indicators else usual
    title = f"{run.model.name}: {number_of(run.model.fleet.size, 'robot')}, seed {run.seed}"
    rows = [(words.indicator_name(name), words.value(name, run.kpis[name], run.model), name) for name in shown]
    return "\n".join([*sentences(run), printed_table(title, ("indicator", "value", "name"), rows, width)])


def sentences(run: RunData) -> list[str]:
    """Return a run in a few sentences."""
    wrong = [sentence(verdict.text) for verdict in run.verdicts] + _left_open(run)
    lasts = wrong or [*_keeps_up(run), *_departures(run)]
    return [
        _delivered(run),
        *_asked(run),
        *_halts(run),
        *_gone_home(run),
        *lasts,
        *_batteries(run),
        _busiest(run),
        *_pods(run),
        *_breakdowns(run),
        *_cost(run),
    ]


def numbers_of(run: RunData) -> list[BigNumber]:
    """Return the three main numbers of a run."""
    kpis, model = run.kpis, run.model
    pairs = [(numbers.measured(kpis["throughput_per_hour"]), f"{words.loads(model)} an hour")]
    if piles_up(run.verdicts):
        pairs.append((number_of(kpis["backlog"], words.load(model)), "open at the end: it cannot keep up"))
    elif math.isfinite(kpis.get("on_time", math.nan)):
        pairs.append((numbers.PERCENT.value(kpis["on_time"]), "on time"))
    else:
        pairs.append(
            (words.value("cycle_time_p95", kpis["cycle_time_p95"], model), f"95 % of {words.loads(model)} done within")
        )
    if "annual_cost" in kpis:
        pairs.append((words.scale("annual_cost", model).value(kpis["annual_cost"]), "cost a year"))
    else:
        pairs.append((numbers.PERCENT.value(kpis["share_waiting"]), "of the time waiting in traffic"))
    return [BigNumber(value=value, what=what) for value, what in pairs]


def waited(run: RunData) -> list[str]:
    """Return the sentence on the main cause of waiting; none without a full log."""
    if run.record.level != "all" or not run.history.counted:
        return []
    whole, lost = run.history.counted * run.model.fleet.size, lost_to(run.history)
    if not lost:
        return []
    root, (time, _) = next(iter(lost.items()))
    lasted, share = numbers.duration(time, run.model.units.time), numbers.PERCENT.value(time / whole)
    return [f"Robots waited longest {in_words(root, run.model)}: {lasted} in all, {share} of their time."]


def counted_time(run: RunData) -> str:
    """Return the evaluation period, with the warm-up before it if there is one: `4 h after a warm-up of 1 h`."""
    unit = run.model.units.time
    phrase = numbers.duration(run.history.counted, unit)
    if unit not in SECONDS:
        phrase += f" ({numbers.duration(run.history.counted * run.model.units.seconds, 's')})"
    if run.history.begin:
        phrase += f" after a warm-up of {numbers.duration(run.history.begin, unit)}"
    return phrase


def _delivered(run: RunData) -> str:
    kpis = run.kpis
    phrase = f"{number_of(kpis['tasks'], words.load(run.model))} delivered in {counted_time(run)}"
    if math.isfinite(kpis["throughput_per_hour"]):
        phrase += f", {numbers.measured(kpis['throughput_per_hour'])} an hour"
    share = kpis.get("on_time", math.nan)
    has_answer = math.isfinite(share) and not is_no_answer("on_time", run.verdicts)
    return f"{phrase}, {numbers.PERCENT.value(share)} on time." if has_answer else f"{phrase}."


def _asked(run: RunData) -> list[str]:
    """Return the sentence on the number of orders a day, if orders arrive at a rate."""
    return [sentence(line) for line in orders_a_day(run.model)]


def _left_open(run: RunData) -> list[str]:
    """Return the sentence on open tasks, which cycle times leave out, if the backlog grows or the work is not done."""
    left = int(run.kpis["backlog"])
    if math.isnan(run.kpis["T"]):
        loads = (
            f"{number_of(left, words.load(run.model))} open at the end" if left else "more was to come, or to return"
        )
        return [f"The run ends before its work is done: {loads}."]
    if not left or not piles_up(run.verdicts):
        return []
    are, still = "is" if left == 1 else "are", number_of(left, words.load(run.model))
    return [f"Cycle times are those of finished {words.loads(run.model)}: the {still} still open {are} not included."]


def _keeps_up(run: RunData) -> list[str]:
    """Return the sentence on whether the warehouse keeps up, or why the run does not show it."""
    judged = lasting(run)
    if judged is None:
        return []
    left = f"{number_of(run.kpis['backlog'], words.load(run.model))} open at the end"
    if judged.keeps_up and not judged.piles_up_at_peak:
        return [f"The warehouse keeps up: {left}."]
    if judged.keeps_up:
        return [f"The warehouse keeps up by the end, but not in the busiest hour: {left}."]
    time = numbers.duration(run.history.counted, run.model.units.time)
    do = "does" if time.startswith("1 ") else "do"
    return [f"{time} {do} not show whether the warehouse keeps up: {left}{_against(judged)}."]


def _against(judged: Lasting) -> str:
    """Return the evidence that a run may not keep up, for the end of the sentence on its backlog."""
    if judged.unknown:
        return f", and its model cannot be checked: {judged.unknown}"
    demand = f"{numbers.PERCENT.value(judged.asked)} of the capacity of {judged.scarce}" if judged.scarce else ""
    if judged.overload:
        return f", and by the check demand exceeds capacity{f' ({demand})' if demand else ''}"
    if judged.scarce:
        return f", and demand is {demand}"
    return f", and {judged.grown:,} more are waiting for a robot than when counting began"


def _departures(run: RunData) -> list[str]:
    """Return the sentence on how long before its departure the latest order in time came.

    There is none unless orders have departures, of lorries or the like.
    """
    lead = run.kpis.get("departure_lead", math.nan)
    if not math.isfinite(lead):
        return []
    if not lead:
        return [f"No {words.load(run.model)} missed its departure."]
    before = numbers.duration(lead, run.model.units.time)
    return [f"{capital(words.loads(run.model))} that came more than {before} before a departure were in time for it."]


def _halts(run: RunData) -> list[str]:
    """Return a sentence for each cause of halts in delivery while tasks were open, on its longest halt."""
    by_cause: dict[str, list[Halt]] = {}
    for halt in halts(run.history):
        by_cause.setdefault(halt.cause, []).append(halt)
    return [_longest(of_cause, run) for of_cause in by_cause.values()]


def _longest(of_cause: list[Halt], run: RunData) -> str:
    longest = max(of_cause, key=lambda halt: halt.end - halt.start)
    return stood_still(longest, run.model, run.history.chargers, len(of_cause))


def _gone_home(run: RunData) -> list[str]:
    """Return the sentence on pickers who went home while robots waited; none if a sentence on halts tells it."""
    history, spec = run.history, run.model.pickers
    if spec is None:
        return []
    hours, end = run.model.hours(spec.hours), history.end
    waiting = sum(robot[-1].seen == FOR_PICKER for robot in history.states)
    stretches = list(hours.between(0.0, end))
    stood = any(halt.cause == "pickers" and halt.end >= end for halt in halts(history))
    if not waiting or stood or not stretches or stretches[-1][1] >= end:
        return []
    last = moment(run.model, stretches[-1][1])
    when = f"at {last}" if run.model.run.start != "00:00" else f"after {last}"
    again = "" if math.isfinite(hours.following(end)[0]) else " for good"
    return [f"Pickers went home{again} {when}: at the end {number_of(waiting, 'robot')} still waited for one."]


def _batteries(run: RunData) -> list[str]:
    """Return the sentence on batteries that end a day lower than they begin it, although no verdict says so."""
    lost = 0.0 if run.verdicts else lost_in_a_day(run.kpis.get("energy_drift_per_hour", 0.0), run.model)
    return [words.batteries_end_lower(lost)] if lost else []


def _busiest(run: RunData) -> str:
    """Return the sentences on the busiest group, and on the time that robots waited in traffic."""
    return busiest.of_run(run.history, run.kpis) if run.history.counted else "No time was counted."


def _pods(run: RunData) -> list[str]:
    """Return the sentence on the lines that a visit of a pod served, and on the idle time of pickers."""
    pile, idle = run.kpis.get("pile_on", math.nan), run.kpis.get("station_idle", math.nan)
    if not math.isfinite(pile) or not math.isfinite(idle):
        return []
    none, lines = numbers.PERCENT.value(idle), f"{numbers.measured(pile)} {numbers.plural('line', pile)}"
    return [f"A pod served {lines} a visit; pickers had nothing to pick {none} of the time."]


def _breakdowns(run: RunData) -> list[str]:
    """Return the sentences on how often robots broke down, its cost, and what is too rare for one run to show."""
    rare = [sentence(line) for line in unknown(run.model, 1, run.history.end)]
    if "breakdowns" not in run.kpis:
        return rare
    count, share = run.kpis["breakdowns"], run.kpis["availability"]
    left = f"; their availability was {numbers.PERCENT.value(share)}" if share < 1 else ""
    return [f"Robots broke down {number_of(count, 'time')}{left}.", *rare]


def _cost(run: RunData) -> list[str]:
    if "annual_cost" not in run.kpis:
        return []
    scale, each = words.scale("annual_cost", run.model), run.kpis["cost_per_task"]
    task = f", or {scale.value(each)} a task" if math.isfinite(each) else ""
    return [f"A year like this costs {scale.value(run.kpis['annual_cost'])}{task}."]
