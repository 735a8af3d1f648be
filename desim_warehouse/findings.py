"""Findings of a check of a model: every code with its severity and meaning, and a finding with position and cure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

Severity = Literal["error", "warning", "note"]
Acceptable = Literal["BATTERY_TOO_SMALL", "NO_CHARGER", "ROBOT_WIDER_THAN_AISLE"]
"""Errors that a model may accept (`accept: [CODE]`): those that rest on an estimate. As long as any of the
others stands, nothing can be simulated."""


class Code(NamedTuple):
    """The severity of a code, and what it means."""

    level: Severity
    meaning: str


CODES: dict[str, Code] = {
    "UNREACHABLE": Code("error", "a node in use cannot be reached from the others, or cannot be left"),
    "NO_BAYS": Code("error", "the layout has no bays"),
    "START_WITHOUT_BAY": Code("error", "`fleet.start` names a node without a bay"),
    "BAY_CROWDED": Code("error", "more robots start at a node than its bay has slots"),
    "TOO_FEW_PLACES": Code("error", "all bays together have fewer slots than there are robots"),
    "ROTATE_TWO_WAY": Code("error", "`traffic.gridlock: rotate` on a layout with two-way lanes"),
    "BAY_IN_LANE": Code("error", "a bay in the lane cuts off a part of the layout, or something else is there"),
    "START_ON_LANES": Code("error", "a robot cannot stand where it starts on the lanes"),
    "START_STUCK": Code(
        "error", "robots start in each other's way home where lanes are two-way, and none of them can make way"
    ),
    "ZONE": Code("error", "a zone names something that does not exist, or could leave robots waiting for ever"),
    "LIFT": Code("error", "robots would drive through a lift, wait or work in its cabin, or never get it"),
    "CLOSURE": Code(
        "error",
        "a closure, slow zone or aisle of people names something that does not exist, or no robot can wait "
        "in front of it",
    ),
    "CUT_OFF": Code("error", "a closure cuts off something that is in use for the whole run"),
    "NEVER_OPEN": Code(
        "error", "a calendar does not open during the run, or not long enough for all that is asked for"
    ),
    "HOURS_NEVER_MEET": Code("error", "a station is open only when no robot is at work"),
    "ROBOT_WIDER_THAN_AISLE": Code("error", "a robot's diameter is more than the width of an aisle"),
    "BATTERY_TOO_SMALL": Code("error", "a full battery does not last for a task and the drive to a charger"),
    "NO_CHARGER": Code("error", "no bay has a charger, and the batteries do not last for the run"),
    "NO_SPARE": Code("error", "fewer spare batteries than bays where batteries are swapped"),
    "UNREACHABLE_UNUSED": Code("warning", "an unused node cannot be reached, or cannot be left"),
    "NOTHING_TO_DRIVE": Code("warning", "loads are picked and put down at the same node: nothing is carried anywhere"),
    "LANES_OVERLAP": Code("warning", "two lanes are drawn on one aisle, side by side with less than D between them"),
    "UNLOAD_IN_LANE": Code("warning", "robots unload standing on a node where edges meet"),
    "SHORT_EDGES": Code("warning", "edges are shorter than D, the distance that robots keep"),
    "SHARP_MERGE": Code("warning", "edges meet at less than 60 degrees"),
    "CROSSING_EDGES": Code("warning", "edges cross where there is no node"),
    "AISLES_OCCUPIED": Code("warning", "people are in the aisles for more than 90 % of the time"),
    "LANES_BLOCKED": Code("warning", "a broken robot blocks its lane for more than five minutes"),
    "ZONES_JOINED": Code("warning", "one-robot zones share a node, so that one robot at a time is in all of them"),
    "TWO_WAY": Code("note", "lanes that serve both directions, one at a time"),
    "LOAD_NEAR_NODE": Code("note", "storage places nearer than D to a node"),
    "LOAD_ON_NODE": Code("note", "robots load standing on nodes where edges meet"),
    "SHARED_NAMES": Code("note", "storage places have several names, of which logs and reports show the first"),
    "STATION_PLACES": Code(
        "note", "the slots of stations hold robots back, as a task needs a free slot before it is assigned"
    ),
    "CHARGER_SLOTS": Code("note", "bays with chargers have slots in which robots wait for one"),
    "START_ENERGY": Code("note", "batteries do not start where they settle, and the warm-up is shorter than they last"),
    "EDGES_BELOW_2D": Code("note", "edges shorter than 2 D, before which robots wait on the node"),
    "AISLES_TIGHT": Code("note", "aisles whose width is given, and too small for one robot to drive past another"),
    "AISLES_SHORT": Code("note", "edges in wide aisles shorter than 2 D, so that robots load in the lane"),
    "FLOOR_SIZE": Code("warning", "the floor is larger than 2 km or smaller than 2 m: is the unit of length right?"),
    "FAST": Code("warning", "robots drive faster than 3 m/s"),
    "SLOW": Code("warning", "robots drive slower than 0.05 m/s"),
    "LONG_HANDLING": Code("warning", "loading or unloading one good takes an hour or more"),
    "SHORT_RUN": Code("warning", "the run, or its counted time, is shorter than a few tasks take"),
    "DEMAND_ABOVE_FLEET": Code("warning", "more tasks are demanded than the robots can do"),
    "PEAK_ABOVE_FLEET": Code(
        "warning", "more tasks are demanded in the busiest hour than the robots can do, or a station in its own"
    ),
    "DEMAND_ABOVE_STATIONS": Code("warning", "more tasks are demanded than the stations can serve"),
    "DEMAND_ABOVE_LIFT": Code("warning", "more rides are asked of a lift than it can do"),
    "LIFT_UNUSED": Code("warning", "routing takes only one lift although another goes to the same floors"),
    "ONE_LOAD": Code(
        "warning",
        "robots carry several loads but no tasks are batched, or tasks are batched but no robot carries several loads",
    ),
    "STOCK_RUNS_OUT": Code("warning", "more of an item is picked in the run than pods hold and receive"),
    "PODS_QUEUE": Code("warning", "more pods may be bound for a station than keep its pickers busy"),
    "DUE_TOO_SOON": Code("warning", "tasks are due sooner than a robot already at the good can deliver them"),
    "NEVER_CHARGED": Code("warning", "no bay has a charger, and by the quick estimate the batteries do not last"),
    "CHARGERS_SHORT": Code("warning", "the chargers supply less than the fleet draws"),
    "CHARGERS_WITHOUT_SLOT": Code("warning", "chargers of a bay have no slot, so no robot is ever charged there"),
    "NO_SPARE_SLOT": Code(
        "warning",
        "there are as many slots as robots, and some have no charger: while all robots rest, none can change places",
    ),
    "CHARGED_TOO_LOW": Code(
        "warning", "charging ends too low for a task, for which only a fuller battery at the start lasts"
    ),
    "BATTERY_OF_KIND": Code("warning", "the battery of a kind of robots does not last for tasks that others must do"),
    "CHARGE_AT_ONCE": Code(
        "warning", "a fleet that is always at work comes to its chargers all at once, and work stops"
    ),
    "THRESHOLD_TOO_LOW": Code("warning", "a robot just above the threshold cannot finish a task and reach a charger"),
    "SLOW_WAY": Code("warning", "the shortest route takes far longer than another, because of speed limits"),
    "ONE_AT_WORK": Code("warning", "the only slot of a station lets one robot of the fleet work at a time"),
    "SPREAD_WITH_TURNS": Code("warning", "equally short routes are not shared, because turns take time"),
    "FAST_CHARGE": Code("warning", "an empty battery is full within a minute"),
    "NIGHT_FLAT": Code("warning", "a robot runs flat in a night without orders"),
    "NO_ESTIMATE": Code("note", "a robot by itself does none of the work, so there is no estimate"),
    "REST_FLAT": Code("note", "a robot would run flat on a day without orders; this run has no such day"),
    "BATTERY_RATES": Code("warning", "battery capacities do not fit consumption or charge rates"),
    "START_LOW": Code("warning", "every robot has to charge before its first task"),
    "STOPS_AT_NODES": Code("warning", "`node_time` beside an acceleration: robots stop at every node"),
    "FASTER_LOADED": Code("warning", "robots are faster with a load than without"),
    "UNUSUAL": Code("warning", "a value far outside what robots and warehouses do: is its unit right?"),
    "CHANGES_NOTHING": Code("warning", "a key was set for a purpose, but nothing in this model uses it"),
    "CALENDAR_SLIP": Code("warning", "periods of a calendar overlap, or a break lies outside of them"),
    "NEVER_IN_RUN": Code("warning", "a closure, a visit or tasks come only after the run is over"),
    "BREAK_BEYOND_DUE": Code("warning", "a break in working hours is longer than the time until tasks are due"),
    "NEVER_LATE": Code("warning", "tasks are due so late that none can be late in this run"),
    "DUE_CLOCK": Code("warning", "departures count from the start of the run, although it starts by the clock"),
    "WAITS_BEYOND_DUE": Code("warning", "a policy lets tasks wait for longer than they have until they are due"),
    "MORE_THAN_FIT": Code(
        "warning",
        "there are more robots than the lanes hold, more loads than a robot carries, or more chargers or "
        "pod stations than robots",
    ),
    "KINDS_AND_SIZE": Code(
        "warning", "kinds of robots nearly add up to the fleet, so that a few robots are of no kind"
    ),
    "NARROW_AISLES": Code("warning", "an aisle leaves less than 10 cm on either side of a robot"),
    "ENDS_SWAPPED": Code("warning", "rows of orders lead from where their flow ends to where it begins"),
    "SAME_ENDS": Code("warning", "a flow begins and ends at the same nodes"),
    "NOT_USED": Code("note", "a key changes nothing in this model, and may be there for a variant of it"),
    "PROFILE_REPEATS": Code("note", "the rates of a profile are over before the run, and start again"),
    "PROFILE_CLOCK": Code(
        "note", "which rate of a profile holds at the start of a run that does not start at midnight"
    ),
    "LAST_DEPARTURE": Code("note", "how many orders come after the last departure of the run, and are not counted"),
    "CLOSED_GOODS": Code("note", "storage places and stations that no robot can reach while something is closed"),
    "PRICE_A_YEAR": Code("note", "a yearly price looks like a purchase price"),
    "QUANTITY_IS_TRIPS": Code("note", "each unit of a quantity in the rows of orders is a task, and so a trip"),
}
"""Every code, errors first. A code, once published, keeps its meaning."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing to know about a model: its code, the position, what is wrong, and what to do about it."""

    code: str
    place: str
    text: str
    cure: str = ""

    @property
    def level(self) -> Severity:
        """The severity: `error`s are refused by `simulate`, unless accepted; the others are not."""
        return CODES[self.code].level

    @property
    def problem(self) -> str:
        """One line: position, what is wrong, what to do, and the code."""
        return f"{self.place}: {self.text}{'; ' if self.cure else ''}{self.cure} [{self.code}]"

    def __str__(self) -> str:
        """One line, the severity first."""
        return f"{self.level}: {self.problem}"


def amount(value: float) -> str:
    """Write a number as in messages: with three or four digits."""
    return f"{value:,.0f}" if 1e3 <= abs(value) < 1e12 else f"{value:.4g}"  # noqa: PLR2004 - whole from 1,000 on
