"""A first model file from a few words: floors, aisles, lifts, stations, robots, orders, chargers.

Whatever is not given is worked out by the quick estimate of `desim check`, so that the fleet can do the work, and by
a night without orders, so that its batteries last until the morning.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from desim_warehouse.draft.text import text_of
from desim_warehouse.draft.words import (
    BUSY,
    LIFTS_BUSY,
    MOST_FLOORS,
    MOST_LIFTS,
    MOST_ROBOTS,
    Draft,
    floor_of,
    read_orders,
    read_packers,
    read_size,
    sized,
    staff,
)
from desim_warehouse.errors import ModelError, number_of
from desim_warehouse.model import Model
from desim_warehouse.values.fields import LIMITS
from desim_warehouse.working_day import AROUND_THE_CLOCK, DAY

if TYPE_CHECKING:
    from desim_warehouse.feasibility.estimate import QuickEstimate

__all__ = ["Draft", "checked", "draft", "read_orders", "read_packers", "read_size"]


def draft(words: Draft) -> str:
    """Write a model file, with comments, that `check`, `run` and `plan` take as it is.

    Raises:
        ModelError: what is impossible, with the option at fault.
    """
    chargers = words.chargers
    busiest = replace(words, orders=words.busiest, day=AROUND_THE_CLOCK, inbound=0.0)
    complete = _worked_out(busiest)
    complete = replace(complete, orders=words.orders, day=words.day, inbound=words.inbound)
    if complete.inbound and complete.stations == complete.aisles:
        beside = f"beside {number_of(complete.stations or 0, 'packing station')}"
        text = f"no aisle is left for goods in {beside}, expected fewer of these, or more aisles"
        raise ModelError([f"--inbound {complete.inbound:g}/h: {text}"])
    if words.day != AROUND_THE_CLOCK:
        complete = _full_in_the_morning(_lasts_a_night(complete, chargers), chargers)
    return text_of(complete)


def checked(words: Draft) -> Draft:
    """Complete a draft by its aisles, stations and packers, without an estimate.

    Raises:
        ModelError: what is impossible, with the option at fault.
    """
    _see_floors(words)
    floor = floor_of(words)
    words = replace(words, aisles=floor.aisles)
    stations, packers = staff(words, floor.aisles)
    words = replace(words, stations=stations, packers=packers)
    problems = [
        f"--{name} {value}: out of range, expected 1 to {most}"
        for name, value, most in (
            ("stations", words.stations, floor.aisles),  # one at the south end of each aisle
            ("robots", words.robots, MOST_ROBOTS),
            ("chargers", words.chargers, MOST_ROBOTS),
        )
        if value is not None and not 0 < value <= most
    ]
    if packers > (limit := max(stations, 1) * LIMITS["robots"][0]):
        problems.append(f"--packers {packers}: out of range, expected 1 to {limit}")
    elif 0 < stations <= floor.aisles and packers % stations:
        text = f"not as many at each of {stations} packing stations"
        problems.append(f"--packers {packers}: {text}, expected a multiple of {stations}")
    if not 0 < words.due < math.inf:
        problems.append(f"--due {words.due:g}: expected minutes above 0")
    if problems:
        raise ModelError(problems)
    return words


def _worked_out(words: Draft) -> Draft:
    """Complete a draft: work out everything that was not given."""
    from desim_warehouse.feasibility.power import needed_at_rest

    words = _with_lifts(checked(words))
    wanted_chargers, wanted_robots = words.chargers, words.robots
    if words.robots is None or words.chargers is None:
        # As many robots and chargers as there could be, so that the estimate says how many are needed.
        estimate = _estimated(replace(words, robots=words.robots or 50, chargers=words.chargers or 50))
        if words.robots is None:
            words = replace(words, robots=max(math.ceil((estimate.robots_busy or 1.0) / BUSY), 1))
        if words.chargers is None:
            one_each = replace(words, chargers=words.robots)
            power = _estimated(one_each).power
            needed = None if power is None else power.needed
            words = replace(words, chargers=max(needed or 1, needed_at_rest(_model(one_each))))
    _fits(words, wanted_robots)
    return _lasts_a_night(words, wanted_chargers)


def _see_floors(words: Draft) -> None:
    """Refuse floors and lifts that there cannot be."""
    if not 1 <= words.floors <= MOST_FLOORS:
        raise ModelError([f"--floors {words.floors}: out of range, expected 1 to {MOST_FLOORS}"])
    if words.lifts is not None and words.floors == 1:
        raise ModelError([f"--lifts {words.lifts}: one floor has no lift, expected --floors 2 or more beside it"])
    if words.lifts is not None and not 1 <= words.lifts <= MOST_LIFTS:
        raise ModelError([f"--lifts {words.lifts}: out of range, expected 1 to {MOST_LIFTS}"])


def _with_lifts(words: Draft) -> Draft:
    """Add as many lifts as the orders need, where there are several floors and their number is not given."""
    if words.floors == 1 or words.lifts is not None:
        return words
    estimate = _estimated(replace(words, robots=words.robots or 50, chargers=words.chargers or 50, lifts=1))
    busy = sum((estimate.rate or 0.0) * lift.share * lift.time for lift in estimate.lifts)
    lifts = max(math.ceil(busy / LIFTS_BUSY), 1)
    if lifts > MOST_LIFTS:
        text = f"takes {lifts} lifts, expected fewer orders, or --lifts, at most {MOST_LIFTS}"
        raise ModelError([f"--orders {words.orders:g}/h: {text}"])
    return replace(words, lifts=lifts)


def _fits(words: Draft, wanted_robots: int | None) -> None:
    """Refuse more robots than the lanes hold."""
    from desim_warehouse.layout.checks import room

    assert words.robots is not None
    model = _model(words)
    if words.robots > (most := room(model.floor, model.fleet.contact)):
        floor = f"the lanes of {sized(words)} hold {most}"
        if wanted_robots is None:
            takes = f"--orders {words.orders:g}/h: takes {number_of(words.robots, 'robot')}"
            problem = f"{takes}, and {floor}; expected fewer orders, or a larger floor"
        else:
            problem = f"--robots {wanted_robots}: {floor}; expected at most {most}, or a larger floor"
        raise ModelError([problem])


def _lasts_a_night(words: Draft, wanted_chargers: int | None) -> Draft:
    """Add chargers until a night without orders drains no battery; refuse it where their number is given."""
    from desim_warehouse.feasibility.power import at_rest, needed_at_rest
    from desim_warehouse.run.night import night

    assert words.chargers is not None and words.robots is not None  # noqa: PT018
    model = _model(words)
    if (flat := night(model)) is None:
        return words
    for chargers in range(max(words.chargers + 1, needed_at_rest(model)), words.robots + 1):
        if night(_model(more := replace(words, chargers=chargers))) is None:
            if wanted_chargers is None:
                return more
            cure = f"expected at least {chargers}"
            break
    else:
        cure = "no number of chargers helps"
    at_night = f"without orders robot {flat.robot} runs flat after {flat.hours:.1f} h"
    name = "chargers" if wanted_chargers is not None else "robots"
    raise ModelError([f"--{name} {getattr(words, name)}: {at_night}, {at_rest(model, model.floor)}; {cure}"])


def _full_in_the_morning(words: Draft, wanted_chargers: int | None) -> Draft:
    """Add chargers until every battery is full by morning, unless their number is given."""
    from desim_warehouse.model.facts.charging import refills_overnight

    assert words.chargers is not None and words.robots is not None  # noqa: PT018
    if wanted_chargers is not None or words.day.length == DAY:
        return words
    enough = (replace(words, chargers=number) for number in range(words.chargers, words.robots + 1))
    return next((more for more in enough if refills_overnight(_model(more))), words)


def _model(words: Draft) -> Model:
    """Return the model of a complete draft."""
    from desim_warehouse.model.parse import read_yaml, valid
    from desim_warehouse.model.schema import OUTLINE

    return valid(read_yaml(text_of(words), "desim new"), Model, OUTLINE)


def _estimated(words: Draft) -> QuickEstimate:
    """Return the quick estimate of a draft."""
    from desim_warehouse.run.quick import estimate

    return estimate(_model(words))
