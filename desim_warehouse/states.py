"""The one list of robot states.

Everything that knows more about a state than its name reads it here: the log and the share of time in it, the battery,
figures, film and replay page. To add one, add it to `STATES`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from collections.abc import Callable

Role = Literal["idle", "empty", "loaded", "charging", "wait", "broken"]
Consumption = Literal["standing", "empty", "loaded", "handling"]


@dataclass(frozen=True)
class State:
    """A state of a robot.

    `name`: the kind of its row in the log, its column in the table of robots, and `share_NAME` among the indicators.
    `doing`: for people, in figures and on the replay page. `begins`: what its row in the log says. `time`: what is
    done in its share of time. `draws`: which consumption of the model file applies; None: nothing is drawn. `role`: how
    the replay page and films draw a robot that is in it. `colour` and `stacked`: in figures, and its place in a stack
    of states, from below. `applies`: whether robots of a model can be in
    it; else no table, figure or page has it.
    """

    name: str
    doing: str
    begins: str
    time: str
    draws: Consumption | None
    role: Role
    colour: str
    stacked: int
    applies: Callable[[Any], bool] = lambda _: True


STATES = {
    state.name: state
    for state in (
        State(
            "idle",
            doing="idle",
            begins="a robot stands in a bay, with nothing to do",
            time="in a bay, with nothing to do",
            draws="standing",
            role="idle",
            colour="#D9D9D9",
            stacked=7,
        ),
        State(
            "empty",
            doing="driving empty",
            begins="it sets out for a good",
            time="driving to a good",
            draws="empty",
            role="empty",
            colour="#0072B2",
            stacked=1,
        ),
        State(
            "loading",
            doing="loading",
            begins="it begins to take the good",
            time="taking a good",
            draws="handling",
            role="empty",
            colour="#E69F00",
            stacked=2,
        ),
        State(
            "loaded",
            doing="driving loaded",
            begins="it sets out for a station",
            time="driving to a station",
            draws="loaded",
            role="loaded",
            colour="#D55E00",
            stacked=0,
        ),
        State(
            "queueing",
            doing="queueing for a server or charger",
            begins="a robot in a station waits for a server, or in a bay for a charger",
            time="in a station, waiting for a server, or in a bay, waiting for a charger",
            draws="standing",
            role="loaded",
            colour="#CC79A7",
            stacked=6,
        ),
        State(
            "unloading",
            doing="unloading",
            begins="it begins to put the good down, or to hand it over at a stop on its way (`via`)",
            time="putting a good down",
            draws="handling",
            role="loaded",
            colour="#F0E442",
            stacked=3,
        ),
        State(
            "returning",
            doing="going to a bay",
            begins="it sets out for a bay",
            time="driving to a bay",
            draws="empty",
            role="idle",
            colour="#56B4E9",
            stacked=4,
        ),
        State(
            "charging",
            doing="charging",
            begins="it begins to be charged",
            time="being charged",
            draws=None,
            role="charging",
            colour="#009E73",
            stacked=5,
        ),
        State(
            "closed",
            doing="waiting for a station to open",
            begins="in a station that is closed it waits until it opens; only with hours of stations",
            time="in a station, waiting until it opens; only with hours of stations",
            draws="standing",
            role="loaded",
            colour="#999933",
            stacked=12,
            applies=lambda model: model.layout.has_hours,
        ),
        State(
            "on_break",
            doing="on a break",
            begins="its hours are over and it rests in a bay; only with hours of robots",
            time="resting in a bay outside its hours; only with hours of robots",
            draws="standing",
            role="idle",
            colour="#EFEFEF",
            stacked=13,
            applies=lambda model: model.fleet.has_hours,
        ),
        State(
            "broken",
            doing="broken down",
            begins="it has broken down where it stands; repaired, it begins again what it did before",
            time="broken down, until it is repaired; only with breakdowns",
            draws="standing",
            role="broken",
            colour="#8C564B",
            stacked=11,
            applies=lambda model: model.fleet.breaks_down,
        ),
    )
}
"""By name, in the order of tables and indicators."""

WAITING = State(
    "waiting",
    doing="waiting in traffic",
    begins="",
    time="waiting in traffic for other robots",
    draws="standing",
    role="wait",
    colour="#000000",
    stacked=8,
)
"""Held up by other robots, in any state: no row of the log begins it, but its time and energy are counted apart."""

WaitName = Literal["waiting_closed", "waiting_person"]
APART: dict[str, State] = {
    "waiting_closed": State(
        "waiting_closed",
        doing="waiting for an edge to open",
        begins="",
        time="waiting before an edge that is closed",
        draws="standing",
        role="wait",
        colour="#8C6D1F",
        stacked=9,
        applies=lambda model: "waiting_closed" in model.waits_apart,
    ),
    "waiting_person": State(
        "waiting_person",
        doing="waiting for a person",
        begins="",
        time="waiting before an aisle with a person in it",
        draws="standing",
        role="wait",
        colour="#E41A8B",
        stacked=10,
        applies=lambda model: "waiting_person" in model.waits_apart,
    ),
}
"""Waits in traffic that are no collisions, where closures or people are in the model: counted beside `waiting`."""

TIMES: dict[str, State] = {**STATES, "waiting": WAITING, **APART}
"""The states among which a robot's time is divided."""
OPERATING = tuple(state.name for state in STATES.values() if state.draws in ("empty", "loaded", "handling"))
"""States in which a robot is in operation, unless it waits in traffic: it drives, or loads and unloads."""


def absent(model: Any) -> frozenset[str]:
    """The states and times of `TIMES` that robots of a model cannot be in, by name."""
    return frozenset(name for name, state in TIMES.items() if not state.applies(model))


FOR_SERVER = replace(STATES["queueing"], name="queueing_server", doing="queueing for a server")
FOR_CHARGER = replace(
    STATES["queueing"],
    name="queueing_charger",
    doing="queueing for a charger",
    role="idle",
    colour="#882255",
)
"""The two kinds of queueing, which reports and the account of time tell apart; in the log they are one state."""


def seen(name: str, task: int) -> State:
    """The state of a robot as it is shown, given the number of its task: one without a task queues for a charger."""
    if name != "queueing":
        return STATES[name]
    return FOR_CHARGER if task < 0 else FOR_SERVER
