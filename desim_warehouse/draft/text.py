"""The text of a draft: a commented model file that looks like one written by hand."""

from __future__ import annotations

import math
from dataclasses import replace

from desim_warehouse.draft.words import (
    BUSY,
    DOORS,
    KEPT,
    LANE,
    LOAD_TIME,
    ON_BREAK,
    PLACE,
    RIDE,
    UNLOAD_TIME,
    Draft,
    DraftFloor,
    floor_of,
    sized,
    staff,
)
from desim_warehouse.errors import ModelError, number_of
from desim_warehouse.layout.naming import block_nodes
from desim_warehouse.working_day import AROUND_THE_CLOCK, DAY, WorkingDay, clock


def _spread(names: tuple[str, ...], count: int) -> list[str]:
    """Return a number of these names, evenly spaced."""
    step = len(names) / count
    return [names[math.floor((rank + 0.5) * step)] for rank in range(count)]


def _passing(floor: DraftFloor) -> str:
    """Return the words that say whether robots may drive past a robot that loads, by the width of the aisles."""
    need = f"{2 * KEPT:g} m"
    return f"to pass they would need {need}" if floor.aisle < 2 * KEPT else f"(!) wide: they pass, in {need}"


# In one piece, long as it is: it looks like the file that it makes.
def text_of(words: Draft) -> str:
    """Write the model file of a complete draft."""
    assert words.robots is not None and words.chargers is not None and words.stations is not None  # noqa: PT018
    floor = floor_of(words)
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
# {in_full(words)}
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


def in_full(words: Draft) -> str:
    """Describe a complete draft in a sentence: everything that was given or worked out."""
    assert words.aisles is not None and words.stations is not None and words.packers is not None  # noqa: PT018
    packers = {"packer": words.packers} if words.people else {}
    lifts = {"lift": words.lifts} if words.floors > 1 else {}
    parts = {**lifts, "packing station": words.stations, **packers, "robot": words.robots, "charger": words.chargers}
    counts = {name: number_of(number or 0, name) for name, number in parts.items()}
    _, enough = staff(replace(words, packers=None), words.aisles)
    if words.people and words.packers < enough:
        counts["packer"] += f" (the busiest hour needs {enough})"
    size = f"{sized(words)}, {words.aisles} aisles{' on each' if words.floors > 1 else ''}"
    a_day = f" = {words.orders * words.day.hours:,.0f} orders a day"
    counted, asked = ", ".join(counts.values()), f"{words.orders:.4g} orders an hour{words.day.words()}"
    sentence = f"{size}, {counted}, {asked}{a_day}, due in {_minutes(words.due)}"
    if not words.inbound:
        return f"{sentence}."
    loads = words.inbound * WorkingDay(words.day.shifts).hours
    return f"{sentence}, {words.inbound:.4g} loads an hour = {loads:,.0f} a day put away."


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


def _lifts(words: Draft, floor: DraftFloor, fronts: list[str]) -> str:
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
    """Write the energy of batteries at the start, with the reason."""
    if words.day.shifts and words.day.length < DAY:
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
