"""The words of a draft: what was given or worked out, how they are read, and the floor in blocks that they make."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from desim_warehouse.errors import ModelError
from desim_warehouse.values.fields import LIMITS
from desim_warehouse.working_day import AROUND_THE_CLOCK, WorkingDay

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
        expected = f"{option[2:]} an hour such as 200/h, or a day such as 1600/d"
        raise ModelError([f"{option} {text}: not a rate, expected {expected}"])
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


def staff(words: Draft, aisles: int) -> tuple[int, int]:
    """Return the packing stations, one in an aisle at most, and the people in all of them: as many as were given.

    Where their number was not given, there are enough for the busiest hour.
    """
    need = words.orders * words.day.busiest * UNLOAD_TIME / 3600 / BUSY
    stations, packers = words.stations, words.packers
    if stations is None:
        stations = min(max(math.ceil(need), 1), aisles)
        if packers is not None:
            stations = max(n for n in range(1, stations + 1) if packers % n == 0)
    each = max(math.ceil(need / max(stations, 1)), 1)
    return stations, each * stations if packers is None else packers


@dataclass(frozen=True)
class DraftFloor:
    """The floor in blocks of storage places."""

    aisles: int
    blocks_down: int
    depth: int
    aisle: float
    cross_aisle: float


def floor_of(words: Draft) -> DraftFloor:
    """Return the floor with the given number of aisles, or as many as fit; they share the width that storage leaves."""
    width, height = words.size
    aisles = words.aisles or max(math.floor((width + 2 * PLACE) / (2 * PLACE + AISLE)), 2)
    problems = []
    if aisles < 2:  # noqa: PLR2004 - a ring has two
        problems.append(f"--aisles {aisles}: too few, expected at least 2: robots go up one and down another")
    aisle = (width - 2 * PLACE * (aisles - 1)) / aisles
    is_narrow = width < (narrowest := 2 * (PLACE + NARROWEST))  # two aisles with a block between them
    if aisle < NARROWEST and not is_narrow:
        most = math.floor((width + 2 * PLACE) / (2 * PLACE + NARROWEST))
        problems.append(
            f"--aisles {aisles}: too many for {width:g} m (each would be {aisle:.2g} m wide), expected at most {most}"
        )
    down = max(round(height / (DEPTH + AISLE)), 1)
    depth = math.floor((height - (down + 1) * AISLE) / down / PLACE)
    if depth < 1 or is_narrow:
        least = f"{narrowest:g} x {2 * AISLE + PLACE:g} m"
        problems.append(f"--size {width:g}x{height:g}: too small, expected at least {least}")
    if (number := aisles * (down + 1) * words.floors) > (most := LIMITS["nodes"][0]):
        nodes = f"{aisles:,} aisles with {number:,} nodes"
        problems.append(f"--size {width:g}x{height:g}: {nodes}, expected at most {most:,}; sizes are in metres")
    if problems:
        raise ModelError(problems)
    return DraftFloor(aisles, down, depth, aisle, (height - down * depth * PLACE) / (down + 1))


def sized(words: Draft) -> str:
    """Write the size of the floor, or of each of several."""
    size = f"{words.size[0]:g} x {words.size[1]:g} m"
    return size if words.floors == 1 else f"{words.floors} floors of {size}"
