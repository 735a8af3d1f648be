"""A first model file from a few words: floors, aisles, lifts, stations, robots, orders, chargers.

Whatever is not given is worked out by the quick estimate of `desim check`, so that the fleet can do the work, and by
a night without orders, so that its batteries last until the morning.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from desim_warehouse.errors import ModelError, number_of
from desim_warehouse.layout.naming import block_nodes
from desim_warehouse.model import Model
from desim_warehouse.values.fields import LIMITS
from desim_warehouse.working_day import AROUND_THE_CLOCK, DAY, WorkingDay, clock

if TYPE_CHECKING:
    from desim_warehouse.feasibility.estimate import QuickEstimate


PLACE = 1.2
"""Side of a storage place in metres."""
AISLE = 3.0
"""Width in metres of aisles whose number is not given, and the least of cross aisles."""
DEPTH = 15.0
"""Approximate length of a block in metres, the distance between cross aisles."""
UNLOAD_TIME, LOAD_TIME = 20, 10
"""Seconds."""
ON_BREAK = 30 / 480
"""Part of a shift of 8 h that people are on their break, and relieved."""
BUSY = 0.75
"""Share of their time that stations and robots may be busy by the quick estimate, where their number is not given."""
MOST_ROBOTS = 1000
_A_DAY = re.compile(r"/\s*d\s*$")
KEPT = 1.0
"""Metres that the robots of a draft keep apart: their width and margin."""
NARROWEST = 1.0
"""Metres that an aisle must have: a robot is 0.8 m wide."""
LIFTS_BUSY = 0.6
"""Share of their time that lifts may be busy, where their number is not given: queues for them stand in the lanes."""
MOST_FLOORS, MOST_LIFTS = 20, 8
RIDE, DOORS, LANE = 8, 3, 3
"""Seconds of a goods lift from one floor to the next, and of its doors; metres of the lanes into its cabin."""


@dataclass(frozen=True)
class Draft:
    """A warehouse in a few words: lengths in metres, orders an hour, due in minutes after release.

    None: worked out. `aisles` run north to south; storage lies between them, stations at their south ends, bays at
    their north ends. `packers`: people in all stations together; `inbound`: loads an hour that are put away. `people`:
    their times vary and they have breaks, as where anything is said of packers, the day or goods in. `floors` are of
    this size and alike; `lifts` stand at ends of aisles, and stations and bays are on the ground floor.
    """

    size: tuple[float, float] = (60.0, 40.0)
    orders: float = 200.0
    aisles: int | None = None
    stations: int | None = None
    robots: int | None = None
    chargers: int | None = None
    due: float = 15.0
    day: WorkingDay = AROUND_THE_CLOCK
    packers: int | None = None
    inbound: float = 0.0
    people: bool = False
    floors: int = 1
    lifts: int | None = None
    name: str = "our warehouse"

    @property
    def busiest(self) -> float:
        """Orders and loads put away in the busiest hour."""
        return self.orders * self.day.busiest + self.inbound


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
        raise ModelError(
            [f"--stations {complete.stations}: no aisle is left for goods in, expected fewer, or more aisles"]
        )
    if words.day != AROUND_THE_CLOCK:
        complete = _full_in_the_morning(_lasts_a_night(complete, chargers), chargers)
    return _text(complete)


def read_size(text: str) -> tuple[float, float]:
    """Read a floor such as `60x40` or `240x160ft`, in metres; a unit behind both sides, or behind each.

    Raises:
        ModelError: no such size.
    """
    from desim_warehouse.values.units import UnitNames, quantity

    width, _, height = (part.strip() for part in re.sub("[*×X]", "x", text).partition("x"))
    unit = height.lstrip("0123456789. ")
    try:
        sides = (quantity(width, "length", UnitNames(), unit), quantity(height, "length", UnitNames()))
        whole = min(sides) > 0 and (bool(unit) or width[-1:] in "0123456789.")
    except ValueError:
        whole = False
    if not whole:
        raise ModelError([f"--size {text}: not a floor, expected width x height such as 60x40 (metres) or 200x130ft"])
    return sides


def read_orders(text: str, option: str = "--orders", day: WorkingDay = AROUND_THE_CLOCK) -> float:
    """Read orders in a usual hour, such as `200`, `200/h` or `4/min`; `1600/d` are spread over the hours of a `day`.

    Raises:
        ModelError: no such rate, or more than a model may have.
    """
    from desim_warehouse.values.units import UnitNames, quantity

    try:
        number = quantity(text, "rate", UnitNames())
    except ValueError:
        number = math.nan
    if not 0 < number < math.inf:
        raise ModelError([f"{option} {text}: not a rate, expected {option[2:]} an hour such as 200/h"])
    number = number * 24 / day.hours if _A_DAY.search(text) else number
    if number > (most := LIMITS["hourly"][0]):
        raise ModelError([f"{option} {text}: too many, expected at most {most}/h"])
    return number


def read_packers(text: str) -> int | None:
    """Read how many people pack, such as `8`; None for `auto`: as many as the busiest hour needs.

    Raises:
        ModelError: no such number.
    """
    if text == "auto":
        return None
    if not text.isdecimal() or not int(text):
        raise ModelError([f"--packers {text}: not a number of people, expected one above 0, or auto"])
    return int(text)


@dataclass(frozen=True)
class _Floor:
    """The floor in blocks of storage places."""

    aisles: int
    blocks_down: int
    depth: int
    aisle: float
    cross_aisle: float


def _floor(words: Draft) -> _Floor:
    """Return the floor with the given number of aisles, or as many as fit; they share the width that storage leaves."""
    width, height = words.size
    aisles = words.aisles or max(math.floor((width + 2 * PLACE) / (2 * PLACE + AISLE)), 2)
    problems = []
    if aisles < 2:  # noqa: PLR2004 - a ring has two
        problems.append(f"--aisles {aisles}: too few, expected at least 2: robots go up one and down another")
    aisle = (width - 2 * PLACE * (aisles - 1)) / aisles
    if aisle < NARROWEST:
        most = math.floor((width + 2 * PLACE) / (2 * PLACE + NARROWEST))
        problems.append(
            f"--aisles {aisles}: too many for {width:g} m (each would be {aisle:.2g} m wide), expected at most {most}"
        )
    down = max(round(height / (DEPTH + AISLE)), 1)
    depth = math.floor((height - (down + 1) * AISLE) / down / PLACE)
    if depth < 1:
        problems.append(f"--size {width:g}x{height:g}: too small, expected at least {2 * AISLE + PLACE:g} m each way")
    if (number := aisles * (down + 1) * words.floors) > (most := LIMITS["nodes"][0]):
        nodes = f"{aisles:,} aisles with {number:,} nodes"
        problems.append(f"--size {width:g}x{height:g}: {nodes}, expected at most {most:,}; sizes are in metres")
    if problems:
        raise ModelError(problems)
    return _Floor(aisles, down, depth, aisle, (height - down * depth * PLACE) / (down + 1))


def _worked_out(words: Draft) -> Draft:
    """Complete a draft: work out everything that was not given."""
    _see_floors(words)
    floor = _floor(words)
    words = replace(words, aisles=floor.aisles)
    stations, packers = _staff(words, floor.aisles)
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
    from desim_warehouse.feasibility.power import needed_at_rest

    words = _with_lifts(words)
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


def _staff(words: Draft, aisles: int) -> tuple[int, int]:
    """Return the packing stations, one in an aisle at most, and the people in all of them."""
    need = words.orders * UNLOAD_TIME / 3600 / BUSY
    stations, packers = words.stations, words.packers
    if stations is None:
        stations = min(max(math.ceil(need), 1), aisles)
        if packers is not None:
            stations = max(n for n in range(1, stations + 1) if packers % n == 0)
    each = max(math.ceil(need / max(stations, 1)), 1)
    return stations, each * stations if packers is None else packers


def _fits(words: Draft, wanted_robots: int | None) -> None:
    """Refuse more robots than the lanes hold."""
    from desim_warehouse.layout.checks import room

    assert words.robots is not None
    model = _model(words)
    if words.robots > (most := room(model.floor, model.fleet.contact)):
        floor = f"the lanes of {_sized(words)} hold {most}"
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

    return valid(read_yaml(_text(words), "desim new"), Model, OUTLINE)


def _estimated(words: Draft) -> QuickEstimate:
    """Return the quick estimate of a draft."""
    from desim_warehouse.run.quick import estimate

    return estimate(_model(words))


def _spread(names: tuple[str, ...], count: int) -> list[str]:
    """Return a number of these names, evenly spaced."""
    step = len(names) / count
    return [names[math.floor((rank + 0.5) * step)] for rank in range(count)]


def _passing(floor: _Floor) -> str:
    """Say whether robots may drive past one that loads, by the width of the aisles."""
    need = f"{2 * KEPT:g} m"
    return f"to pass they would need {need}" if floor.aisle < 2 * KEPT else f"(!) wide: they pass, in {need}"


# In one piece, long as it is: it looks like the file that it makes.
def _text(words: Draft) -> str:
    """Write the model file of a complete draft."""
    assert words.robots is not None and words.chargers is not None and words.stations is not None  # noqa: PT018
    floor = _floor(words)
    rows = block_nodes(floor.aisles - 1, floor.blocks_down)
    packing = _spread(rows[-1], words.stations)
    charging = _spread(rows[0], min(words.chargers, max(floor.aisles // 2, 1)))
    parking = [name for name in rows[0] if name not in charging]
    assert words.packers is not None
    servers = words.packers // words.stations
    blocks = f"{floor.aisles - 1} x {floor.blocks_down} blocks of 2 x {floor.depth} places, one-way aisles around each"
    receiving = next((name for name in reversed(rows[-1]) if name not in packing), None) if words.inbound else None
    free = [name for name in rows[-1] if name not in {*packing, receiving}]
    fronts = _in_front(words, free, parking) if words.floors > 1 else []
    parking = [name for name in parking if name not in fronts]
    return f"""\
# {said_in_full(words)}
# A first draft by `desim new`: correct what is different in your warehouse, above all what is marked with (!). Then
#   desim check FILE                              errors, and a quick estimate
#   desim draw FILE -o floor.svg                  the floor
#   desim run FILE                                {"a day" if words.day != AROUND_THE_CLOCK else "six hours"} of it
#   desim plan FILE --target "on_time >= 95 %"    how many robots and chargers
name: {words.name}

layout:                       # metres; every key: docs/reference/model.md
  blocks:                     # {blocks}
    columns: {floor.aisles - 1}
    rows: {floor.blocks_down}{_floors_of_blocks(words, rows)}
    block_width: 2            # places across a block: the left ones are picked from the aisle on their left
    block_depth: {floor.depth}
    goods_size: {PLACE:g}           # (!) side of a storage place: a EUR-pallet is 1.2 x 0.8 m (EN 13698-1)
    aisle_width: {floor.aisle:.4g}         # what {floor.aisles} aisles leave of {words.size[0]:g} m
    cross_aisle_width: {floor.cross_aisle:.4g}
    directions: ring          # the outer aisles clockwise, the inner ones alternate
  aisles: narrow              # robots load in their lane, and others wait; {_passing(floor)}
  bays:                       # beside the north ends of the aisles; `desim draw` shows the names of the nodes
    charging: {{at: [{", ".join(charging)}], total_chargers: {words.chargers}}}   # a slot for each charger
    parking: {{at: [{", ".join(parking)}], chargers: 0}}
  stations:                   # beside the south ends; places: robots that may be there or on the way, at each
    packing: {{at: [{", ".join(packing)}], places: {max(10, math.ceil(2 * words.robots / words.stations), servers)}, \
servers: {servers}}}   # (!) servers: people who pack, at each{_goods_in(words, receiving)}\
{_lifts(words, floor, fronts)}

fleet:
  size: {words.robots}
  start: [parking]
  robot:                      # (!)
    radius: 0.4               # robots keep 2 x radius + margin apart
    margin: 0.2
    speed: 1.5 m/s            # a MiR250 drives 2 m/s at most (data sheet)
    acceleration: 0.5 m/s^2   # and deceleration; typical where loads must not shift
  start_energy: {_start(words)}

{_tasks(words)}

battery:                      # (!) in % and seconds, as of a MiR250 (data sheet): a charge lasts 22 h standing,
  capacity: 100               # 17.4 h driving empty, 13 h driving loaded; from 0 to full in 1.4 h
  consumption: {{standing: 0.00126, empty: 0.0016, loaded: 0.00214, handling: 0.00126}}
  charge_rate: 0.02

traffic:
  turn_time: 2 s              # (!) for a turn of 90 degrees, standing

policies:                     # `desim policies` lists them
  allocation: nearest
{_routing(words)}  charging: four-thresholds
  parking: nearest

{_run(words.day)}

log: tasks                    # --set log=all records every move, for replays and accounts of time
"""


def said_in_full(words: Draft) -> str:
    """Describe a complete draft in a sentence: everything that was given or worked out."""
    assert words.stations is not None and words.packers is not None  # noqa: PT018
    packers = {"packer": words.packers} if words.people else {}
    lifts = {"lift": words.lifts} if words.floors > 1 else {}
    parts = {**lifts, "packing station": words.stations, **packers, "robot": words.robots, "charger": words.chargers}
    counted = ", ".join(number_of(number or 0, name) for name, number in parts.items())
    size = f"{_sized(words)}, {words.aisles} aisles{' on each' if words.floors > 1 else ''}"
    a_day = f" = {words.orders * words.day.hours:,.0f} orders a day"
    sentence = (
        f"{size}, {counted}, {words.orders:.4g} orders an hour{words.day.words()}{a_day}, due in {_minutes(words.due)}"
    )
    if not words.inbound:
        return f"{sentence}."
    loads = words.inbound * WorkingDay(words.day.shifts).hours
    return f"{sentence}, {words.inbound:.4g} loads an hour = {loads:,.0f} a day put away."


def _sized(words: Draft) -> str:
    size = f"{words.size[0]:g} x {words.size[1]:g} m"
    return size if words.floors == 1 else f"{words.floors} floors of {size}"


def _in_front(words: Draft, free: list[str], parking: list[str]) -> list[str]:
    """Choose nodes in front of lifts on the ground floor: free south ends of aisles, then ends where robots would park.

    Apart from each other they keep the lanes in front free: four lifts at one node halve what robots do.
    """
    assert words.lifts is not None
    ends = free if len(free) >= words.lifts else [*free, *parking[1:]]
    if not ends:
        raise ModelError([f"--aisles {words.aisles}: no end of an aisle is left for lifts, expected more aisles"])
    return _spread(tuple(ends), min(words.lifts, len(ends)))


def _floors_of_blocks(words: Draft, rows: tuple[tuple[str, ...], ...]) -> str:
    """Write how many floors have such blocks."""
    if words.floors == 1:
        return ""
    above = block_nodes(len(rows[0]) - 1, len(rows) - 1, 1)[0][0]
    return f"\n    floors: {words.floors:<18}# alike, and drawn side by side: {above} is above {rows[0][0]}"


def _lifts(words: Draft, floor: _Floor, fronts: list[str]) -> str:
    """Write the lifts, and names of floors."""
    if words.lifts is None:
        return ""
    levels = [block_nodes(floor.aisles - 1, floor.blocks_down, number) for number in range(words.floors)]
    above = {names[0]: ", ".join(names) for names in zip(*(sum(names, ()) for names in levels), strict=True)}
    times = f"lane: {LANE}, ride: {RIDE} s, doors: {DOORS} s"
    lines = []
    for rank, front in enumerate(fronts):
        name = "goods" if len(fronts) == 1 else f"goods{rank + 1}"
        cabins = words.lifts // len(fronts) + (rank < words.lifts % len(fronts))
        lines.append(f"\n    {name}: {{at: [{above[front]}], {times}{f', cabins: {cabins}' if cabins > 1 else ''}}}")
    lines[0] += "   # (!) ride: to the next floor"
    named = ", ".join(
        f"{f'floor {number}' if number else 'ground floor'}: [{names[0][0]}]" for number, names in enumerate(levels)
    )
    return f"""
  lifts:                      # at: in front of the doors on each floor; lane: from there into a cabin, for one robot\
{"".join(lines)}
  floors: {{{named}}}"""


def _routing(words: Draft) -> str:
    """Write the routing policy, where it is not the usual one."""
    if (words.lifts or 1) == 1:
        return ""
    return "  routing: congestion-aware   # it sees queues before lifts, so all of them are used\n"


def _minutes(due: float) -> str:
    return f"{due / 60:g} h" if due >= 60 else f"{due:g} min"  # noqa: PLR2004 - minutes


def _goods_in(words: Draft, node: str | None) -> str:
    """Write the station where goods come in."""
    if node is None:
        return ""
    servers = max(math.ceil(words.inbound * LOAD_TIME / 3600 / BUSY), 1)
    return f"\n    receiving: {{at: [{node}], places: 10, servers: {servers}}}   # (!) where goods come in"


def _tasks(words: Draft) -> str:
    """Write what is asked for, and how long people and robots take for it."""
    if words.day == AROUND_THE_CLOCK and not words.inbound:
        asked = f"""\
  goods: {{poisson: {words.orders:g} / h, due_within: {words.due:g} min}}   # (!) at random times, each for one place
  unload_at: [packing]"""
    else:
        asked = "  flows:                      # (!) at random times, each for one place\n"
        ways = f"from: storage, to: [packing], due_within: {words.due:g} min"
        asked += _flow("orders", ways, words.day, words.orders)
        if words.inbound:
            even = WorkingDay(words.day.shifts)
            asked += "\n" + _flow("inbound", "from: [receiving], to: storage", even, words.inbound)
    return f"""\
tasks:
{asked}
  station_choice: least-loaded
  load_time: {LOAD_TIME} s             # (!)
{_packing(words)}"""


def _packing(words: Draft) -> str:
    """Write how long a packer takes."""
    if not words.people:
        return f"  unload_time: {UNLOAD_TIME} s           # (!) of a packer's time"
    mean = UNLOAD_TIME / (1 - ON_BREAK)
    return f"""\
  # (!) of a packer's time: {UNLOAD_TIME} s, and what a break of 30 min in 8 h adds where packers relieve each other
  # (breaks: Directive 2003/88/EC, article 4). Times of people are skewed, and how much they vary differs widely
  # (Knott and Sury, IIE Transactions 19 (1987) 50-55): measure yours
  unload_time: {{lognormal: {{mean: {mean:.3g} s, cv: 0.3}}}}"""


def _flow(name: str, ways: str, day: WorkingDay, hourly: float) -> str:
    """Write a flow of the draft: at one rate, or at the rates of the day, by the clock."""
    if day == AROUND_THE_CLOCK:
        return f"    {name}: {{{ways}, arrivals: {{poisson: {hourly:g} / h}}}}"
    every, rates = day.rates(hourly)
    a_line = DAY // 2 // every
    listed = [", ".join(f"{rate:g}" for rate in rates[first : first + a_line]) for first in (0, a_line)]
    lines = ways.replace(", ", "\n      ")
    return f"""\
    {name}:
      {lines}
      arrivals:
        profile:              # an hour, every {every} min from midnight on
          every: {every} min
          per_hour: [{listed[0]},
                     {listed[1]}]"""


def _start(words: Draft) -> str:
    """Write what batteries hold at the start, with the reason."""
    if words.day.shifts:
        off = "day" if words.day.shifts[-1][1] > DAY else "night"
        return f"1               # full: chargers have had the {off}"
    return "settled       # batteries at the start as in the long run: the day before is not simulated"


def _run(day: WorkingDay) -> str:
    """Write how long a run is, and from when on it counts."""
    if day.shifts:
        return f"""\
run:                          # a working day, all of it counted
  start: "{clock(day.begin)}"
  length: {day.length / 60:g} h"""
    hours = 6 if day.peak is None else DAY // 60 + 2
    start = "" if day.peak is None else '  start: "22:00"\n'
    return f"""\
run:                          # the first two hours are not counted: chargers and queues come to their usual state
{start}  length: {hours} h
  warm_up: 2 h"""
