"""Sentences on the busiest group and scarce resources of a run or a forecast.

For the answers of `desim run`, `check`, `plan` and `why`, and for the live page and the replay.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from desim_warehouse.answer import numbers
from desim_warehouse.answer.numbers import capital
from desim_warehouse.errors import spoken
from desim_warehouse.model.facts.lifts import called
from desim_warehouse.model.facts.workers import NEAR, Load, busiest, ranked, scarce
from desim_warehouse.outcome.history import History
from desim_warehouse.outcome.loads import loads

_WORK = {"robots", "people", "pickers"}
"""Kinds of groups that are `at work`; other groups are `in use`."""
_SHOWN = 0.005
"""Least load that is listed beside others, as a share of the time."""


def of_run(history: History, kpis: Mapping[str, float]) -> str:
    """Return the sentences on the busiest group of a run, and on the time that robots waited in traffic."""
    measured = loads(history, kpis)
    line = was(measured)
    if any(load.group.kind == "lanes" for load in busiest(measured)[:1]):  # the line says how long
        return line
    return f"{line} Robots waited in traffic {_percent(kpis['share_waiting'])} of the time.".strip()


def was(measured: Iterable[Load]) -> str:
    """Return the sentence on the busiest group; empty if no group worked.

    Such as `The robots were the busiest, at work 77 % of the time.`
    """
    measured = list(measured)
    most = busiest(measured)
    if not most:
        return ""
    first, *near = most
    if first.group.kind == "lanes":
        return f"The lanes held most up: robots waited in traffic {_percent(first.mean)} of the time."
    line = f"{_the(first)}{first.group.name} {'was' if first.group.is_lift else 'were'} the busiest, {_spent(first)}"
    line += "".join(f", and {_the(load)}{load.group.name}, {_spent(load)}" for load in near)
    kept_up = not any(load.piles_up for load in measured)
    return capital(f"nothing was scarce: {line}." if kept_up and not scarce(measured) else f"{line}.")


def are(foreseen: Iterable[Load], time: str = "of the time", where: str = "") -> str:
    """Return a clause on the busiest groups of a forecast: `the robots are busiest: 77 % of the time; packers 48 %`.

    It is empty if no group works. If several groups are busiest, each share follows the name of its group. Lifts with
    equal shares are named together.

    Args:
        foreseen: the loads of all groups.
        time: the time of which shares are given.
        where: the start of the sentence, such as `with 6 robots`.
    """
    listed = ranked(foreseen)
    most = busiest(listed)
    if not most:
        return ""
    alike = _alike(most)
    who = spoken([_named(together) for together in alike])
    shares = []
    for rank, together in enumerate(alike):
        name = f"{_named(together)} " if len(alike) > 1 and together[0].group.kind != "lanes" else ""
        shares.append(f"{name}{_share(together[0], '' if rank else time, len(together))}")
    idle = "" if scarce(listed) else "nothing is scarce, and "
    is_one = len(most) == 1 and most[0].group.is_lift
    line = f"{where} {idle}{_the(most[0])}{who} {'is' if is_one else 'are'} busiest: {', '.join(shares)}"
    others = _alike(load for load in listed if load not in most and load.need >= _SHOWN)
    rest = [
        f"{_named(together)} {whole_percent(together[0].mean)}{' each' * (len(together) > 1)}" for together in others
    ]
    return (f"{line}; {spoken(rest)}" if rest else line).strip()


def _alike(listed: Iterable[Load]) -> list[list[Load]]:
    """Group lifts whose shares are equal as written; every other load is a group of its own."""
    together: dict[tuple[str, ...], list[Load]] = {}
    for load in listed:
        lift = (whole_percent(load.mean), whole_percent(load.need)) if load.group.is_lift else (load.group.name,)
        together.setdefault(lift, []).append(load)
    return list(together.values())


def _named(together: Sequence[Load]) -> str:
    """Return the name of a load, or of several lifts."""
    return called([load.group.zone for load in together]) if together[0].group.is_lift else together[0].group.name


def _the(load: Load) -> str:
    """Return the article before the name of a load; lifts have none."""
    return "" if load.group.is_lift else "the "


def whole_percent(share: float) -> str:
    """Format a share in whole per cent, or with a decimal close to 0 and 100 %."""
    return f"{100 * share:.0f} %" if 0.01 <= share <= 0.99 or share > 1 else _percent(share)  # noqa: PLR2004


def _spent(load: Load) -> str:
    """Return a phrase for the share of time that a group worked in a run, or for demand that was more than it did."""
    verb = "at work" if load.group.kind in _WORK or load.group.packs else "in use"
    capacity = f"of {_its(load)} capacity"
    line = f"{verb} {_percent(load.mean)} of the time"
    if load.piles_up or load.mean > 1:
        line = f"with demand at {_percent(load.mean)} {capacity}"
    if _peaks(load):
        waits = _with_waits(load, _percent)
        line += f" (demand in the busiest hour was {_percent(load.peak or 0.0)} {capacity}{waits})"
    return f"{line}, plus {_percent(load.back)} driving back to parking" if load.back >= _SHOWN else line


def _share(load: Load, time: str, number: int) -> str:
    """Return a phrase for the share of the time that a group, or each of a `number` of lifts, is busy."""
    if load.group.kind == "lanes":
        return f"robots wait in traffic {whole_percent(load.mean)} {time}".strip()
    share, each = whole_percent(load.mean), "" if number == 1 else " each"
    line = f"demand is {share} of {_its(load, number)} capacity" if load.mean > 1 else f"{share} {time}".strip()
    line += each
    if _peaks(load):
        peak = load.peak or 0.0
        waits = _with_waits(load, whole_percent)
        beyond = f"in the busiest hour demand is {whole_percent(peak)} of {_its(load, number)} capacity{waits}"
        line += f" ({beyond})" if peak > 1 >= load.mean else f" ({whole_percent(peak)} in the busiest hour{waits})"
    return f"{line}, plus {whole_percent(load.back)} driving back to parking" if load.back >= _SHOWN else line


def _its(load: Load, number: int = 1) -> str:
    return "its" if load.group.is_lift and number == 1 else "their"


def _peaks(load: Load) -> bool:
    return load.peak is not None and load.peak > load.mean + NEAR


def _with_waits(load: Load, percent: Callable[[float], str]) -> str:
    """Return the addition that waits also take time of robots in the busiest hour: `, 108 % with waits`."""
    with_waits = load.peak_with_waits
    if with_waits is None or load.peak is None or with_waits < load.peak + NEAR:
        return ""
    return f", {percent(with_waits)} with waits"


def _percent(share: float) -> str:
    return numbers.PERCENT.value(share)
