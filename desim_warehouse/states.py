"""The one list of robot states.

Everything that knows more about a state than its name reads it here: the log and the share of time in it, the battery,
forecasts, queues, figures and replay page. To add one, add it to `STATES` and say what is true of it. Outside this file
a state is named only where a robot enters it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, Literal, NamedTuple

Role = Literal["idle", "empty", "loaded", "charging", "wait", "picker", "broken"]
ROLES = {
    "idle": ("#5b6670", "#9aa7b3"),
    "empty": ("#0062a3", "#56b4e9"),
    "loaded": ("#d55e00", "#ff8a3d"),
    "charging": ("#00735a", "#2fc79b"),
    "wait": ("#9c5c00", "#ffd34d"),
    "picker": ("#c2185b", "#ff6fa5"),
    "broken": ("#22272c", "#f2f5f8"),
}
"""How the replay page draws robots: colours on light and on dark ground, safe for colour-blind people."""
Consumption = Literal["standing", "empty", "loaded", "handling"]
Place = Literal["station", "chargers", "storage"]
PACKING = "packing"
"""A station of this name, as of drafts, has people who pack."""


class Phase(Enum):
    """The parts of a robot's round: forecasts go on from the one in which it is."""

    REST = "in a bay, with nothing to do"
    TO_GOOD = "driving to an item"
    LOADING = "picking up an item"
    TO_STATION = "driving with an item"
    QUEUE = "in a station or bay, or at a storage place, waiting for its turn there"
    UNLOADING = "putting an item down"
    DECISION = "in a station, unloaded, until the next decision"
    TO_BAY = "driving to a bay"
    CHARGING = "at a charger"
    BREAKDOWN = "out of order: afterwards it goes on with what it did before"


class Queue(NamedTuple):
    """The server, charger or picker that robots queue for, as in *for a charger at B*, and where they do."""

    at: Place
    what: str


@dataclass(frozen=True)
class State:
    """A state of a robot.

    `name`: the kind of its row in the log, its column in the table of robots, and `share_NAME` among the indicators.
    `doing`: for people, in figures and on the replay page. `begins`: what its row in the log says. `time`: what is
    done in its share of time. `better`: whether less or more of that is better; None: it depends. `draws`: which
    consumption of the model file applies; None: nothing is drawn. `phase`: the part of its round that a robot is in;
    None: any. `queue`: what it queues for; only in the phase `QUEUE`. `role`: how the replay page draws a robot
    that is in it. `colour` and `stacked`: in figures, and its place in a stack of states, from below.
    `applies`: whether robots of a model can be in it; else no table, figure or page has it.
    """

    name: str
    doing: str
    begins: str
    time: str
    better: Literal["less", "more"] | None
    draws: Consumption | None
    phase: Phase | None
    queue: Queue | None
    role: Role
    colour: str
    stacked: int
    applies: Callable[[Any], bool]

    @property
    def occupies(self) -> Place | None:
        """The place where a robot in it has a server or a charger in use."""
        if self.phase in (Phase.LOADING, Phase.UNLOADING):
            return "station"
        return "chargers" if self.phase is Phase.CHARGING else None

    @property
    def is_parked(self) -> bool:
        """Whether a robot in it is parked: at rest, charged, or in a queue for that."""
        return self.phase in (Phase.REST, Phase.CHARGING) or self.queue == CHARGER


def _always(_: object) -> bool:
    return True


def seen(name: str, task: int) -> State:
    """Return the state of a robot as it is shown, by the number of its task: without one it queues for a charger."""
    state = STATES[name]
    if state is not _QUEUEING:
        return state
    return FOR_CHARGER if task < 0 else FOR_SERVER


def names(is_so: Callable[[State], bool]) -> frozenset[str]:
    """Return the states of the log with a property; queueing, if one of its two kinds has it."""
    return frozenset(name for name in STATES if is_so(seen(name, 0)) or is_so(seen(name, -1)))


SERVER = Queue("station", "a loading point")

OPENING = Queue("station", "its opening")
CHARGER = Queue("chargers", "a charger")
PICKER = Queue("storage", "a picker")

STATES = {
    state.name: state
    for state in (
        State(
            "idle",
            doing="idle",
            begins="a robot stands in a bay, or rests where it unloaded, with nothing to do",
            time="in a bay or where it unloaded, with nothing to do",
            better=None,
            draws="standing",
            phase=Phase.REST,
            queue=None,
            role="idle",
            colour="#D9D9D9",
            stacked=7,
            applies=_always,
        ),
        State(
            "empty",
            doing="driving empty",
            begins="it sets out for an item",
            time="driving to an item",
            better="less",
            draws="empty",
            phase=Phase.TO_GOOD,
            queue=None,
            role="empty",
            colour="#0072B2",
            stacked=1,
            applies=_always,
        ),
        State(
            "loading",
            doing="loading",
            begins="it begins to pick up the item",
            time="picking up an item",
            better=None,
            draws="handling",
            phase=Phase.LOADING,
            queue=None,
            role="empty",
            colour="#E69F00",
            stacked=2,
            applies=_always,
        ),
        State(
            "loaded",
            doing="driving loaded",
            begins="it sets out for a station",
            time="driving to a station",
            better=None,
            draws="loaded",
            phase=Phase.TO_STATION,
            queue=None,
            role="loaded",
            colour="#D55E00",
            stacked=0,
            applies=_always,
        ),
        State(
            "queueing",
            doing="queueing at a station or charger",
            begins="a robot in a station waits to be served, or in a bay for a charger",
            time="in a station, waiting to be served, or in a bay, waiting for a charger",
            better="less",
            draws="standing",
            phase=Phase.QUEUE,
            queue=SERVER,
            role="loaded",
            colour="#CC79A7",
            stacked=6,
            applies=_always,
        ),
        State(
            "unloading",
            doing="unloading",
            begins="it begins to put the item down, or to hand it over at a stop on its way (`via`)",
            time="putting an item down",
            better=None,
            draws="handling",
            phase=Phase.UNLOADING,
            queue=None,
            role="loaded",
            colour="#9F9600",
            stacked=3,
            applies=_always,
        ),
        State(
            "returning",
            doing="going to a bay",
            begins="it sets out for a bay",
            time="driving to a bay",
            better="less",
            draws="empty",
            phase=Phase.TO_BAY,
            queue=None,
            role="idle",
            colour="#56B4E9",
            stacked=4,
            applies=_always,
        ),
        State(
            "charging",
            doing="charging",
            begins="it begins to be charged",
            time="being charged",
            better=None,
            draws=None,
            phase=Phase.CHARGING,
            queue=None,
            role="charging",
            colour="#009E73",
            stacked=5,
            applies=_always,
        ),
        State(
            "closed",
            doing="waiting for a station to open",
            begins="in a station that is closed it waits until it opens; only with `hours` of stations",
            time="in a station, waiting until it opens; only with `hours` of stations",
            better="less",
            draws="standing",
            phase=Phase.QUEUE,
            queue=OPENING,
            role="loaded",
            colour="#5E6738",
            stacked=12,
            applies=lambda model: model.layout.has_hours,
        ),
        State(
            "on_break",
            doing="on a break",
            begins="its hours are over and it rests in a bay; only with `hours` of robots",
            time="resting in a bay outside its hours; only with `hours` of robots",
            better=None,
            draws="standing",
            phase=Phase.REST,
            queue=None,
            role="idle",
            colour="#EFEFEF",
            stacked=13,
            applies=lambda model: model.fleet.has_hours,
        ),
        State(
            "broken",
            doing="broken down",
            begins="it has broken down where it stands; repaired, it begins again what it did before",
            time="broken down, until it is repaired; only with `breakdowns`",
            better="less",
            draws="standing",
            phase=Phase.BREAKDOWN,
            queue=None,
            role="broken",
            colour="#8C564B",
            stacked=11,
            applies=lambda model: model.fleet.breaks_down,
        ),
        State(
            "awaiting",
            doing="waiting for a decision",
            begins="it has unloaded in a station and waits there for the next decision; only with `policies.interval`",
            time="in a station, unloaded, until the next decision; only with `policies.interval`",
            better="less",
            draws="standing",
            phase=Phase.DECISION,
            queue=None,
            role="idle",
            colour="#6A51A3",
            stacked=14,
            applies=lambda model: model.policies.interval > 0,
        ),
        State(
            "too_low",
            doing="too low to work, waiting for a charger",
            begins="it rests in a slot without a charger, its battery too low for the work, and no charger is free",
            time="resting in a slot without a charger, the battery too low for the work, until a charger is free",
            better="less",
            draws="standing",
            phase=Phase.QUEUE,
            queue=CHARGER,
            role="wait",
            colour="#B8860B",
            stacked=15,
            applies=lambda model: model.battery is not None and model.layout.has_slots_without_charger,
        ),
        State(
            "awaiting_picker",
            doing="waiting for a picker",
            begins="it waits for a picker at a storage place, or before it sets out; only with `pickers`",
            time="at a storage place, or before setting out, waiting for a picker; only with `pickers`",
            better="less",
            draws="standing",
            phase=Phase.QUEUE,
            queue=PICKER,
            role="picker",
            colour="#B07AA1",
            stacked=17,
            applies=lambda model: model.pickers is not None,
        ),
    )
}
"""By name, in the order of tables and indicators."""

WAITING = State(
    "waiting",
    doing="waiting in traffic",
    begins="",
    time="waiting in traffic for other robots",
    better="less",
    draws="standing",
    phase=None,
    queue=None,
    role="wait",
    colour="#000000",
    stacked=8,
    applies=_always,
)
"""Held up by other robots, in any state: no row of the log begins it, but its time and energy are counted apart."""

APART = {
    state.name: state
    for state in (
        State(
            "waiting_closed",
            doing="waiting for a lane to open",
            begins="a robot has waited before a `node` to enter a lane (`edge`) that was closed",
            time="waiting before a lane that is closed; only with `traffic.closures`",
            better="less",
            draws="standing",
            phase=None,
            queue=None,
            role="wait",
            colour="#8C6D1F",
            stacked=9,
            applies=lambda model: bool(model.traffic.closures),
        ),
        State(
            "waiting_person",
            doing="waiting for a person",
            begins="a robot has waited before a `node` to enter a lane (`edge`) with a person in it",
            time="waiting before an aisle with a person in it; only with `people`",
            better="less",
            draws="standing",
            phase=None,
            queue=None,
            role="wait",
            colour="#E41A8B",
            stacked=10,
            applies=lambda model: bool(model.people),
        ),
        State(
            "in_lift",
            doing="waiting for a lift or riding in it",
            begins="a robot has waited for a cabin at a `node`, or ridden to it along an `edge` between floors",
            time="waiting before the doors of a lift for its cabin, and riding in it; only with `layout.lifts`",
            better="less",
            draws="standing",
            phase=None,
            queue=None,
            role="wait",
            colour="#3F6FA3",
            stacked=16,
            applies=lambda model: bool(model.layout.lifts),
        ),
    )
}
"""Waits in traffic that are no collisions, where closures, people or lifts are in the model: counted beside `waiting`.
"""
CLOSED_LANE, PERSON_AHEAD, IN_LIFT = APART

TIMES: dict[str, State] = {**STATES, WAITING.name: WAITING, **APART}
"""The states among which a robot's time is divided."""
AT_START = next(iter(STATES))
"""What robots are doing as a run begins: the first of them all."""

_QUEUEING = STATES["queueing"]
FOR_SERVER = replace(_QUEUEING, name="queueing_server", doing="queueing at a station")
FOR_CHARGER = replace(
    _QUEUEING,
    name="queueing_charger",
    doing="queueing for a charger",
    queue=CHARGER,
    role="idle",
    colour="#882255",
)
"""The two kinds of queueing, which reports and the account of time tell apart; in the log they are one state."""
FOR_PICKER = next(state for state in STATES.values() if state.queue == PICKER)
"""In which a robot waits for a person who picks beside it."""
SHOWN = {
    shown.name: shown
    for shown in (*(FOR_SERVER if state is _QUEUEING else state for state in STATES.values()), FOR_CHARGER)
}
"""The states as they are shown: a robot that queues for a charger is apart, as it is not working."""

OPERATING = names(lambda state: state.draws in ("empty", "loaded", "handling"))
"""In which a robot is in operation, unless it waits in traffic: it drives, or loads and unloads."""
SERVED = names(lambda state: state.occupies == "station")
"""In which a robot in a station has a server there in use."""
BROKEN = names(lambda state: state.phase is Phase.BREAKDOWN)
"""In which it is out of order."""
CHARGED = names(lambda state: state.draws is None)
"""In which a robot is charged."""
RESTING = names(lambda state: state.phase is Phase.REST)
"""In which nothing is drawn from the battery in a slot with a charger."""
OFF_DUTY = frozenset(name for name, state in STATES.items() if state.phase is Phase.REST) - {AT_START}
"""In which it rests outside its hours."""
TOO_LOW = frozenset(name for name, state in STATES.items() if state.queue == CHARGER)
"""In which it waits for a charger where there is none, too low to work."""


def absent(model: Any) -> frozenset[str]:
    """Return the states and times of `TIMES` that robots of a model cannot be in, by name."""
    return frozenset(name for name, state in TIMES.items() if not state.applies(model))
