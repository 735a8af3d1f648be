"""Charging policies: when a robot leaves its work to charge, at which charger, and when it is ready again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from desim_warehouse.policies.protocols import CHARGERS, Levels, RobotView
from desim_warehouse.values.fields import Unit, Usual

ShareOfCapacity = Annotated[float, Unit("share")]


@dataclass(frozen=True)
class Threshold:
    """Sends an unloaded robot home at the battery's threshold: it gives its task back and charges fully (the paper).

    Above the threshold it takes any task, so the threshold must cover the longest route from a good's edge via the
    station to a charger. Source: Liu et al., ROBIO 2017, section IV.

    `level`: the threshold, default battery.threshold. `charger`: own (its home), nearest or least-loaded.
    """

    level: float | None = None
    charger: str = "own"
    fixed: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the parameters."""
        _known_charger(self.charger)

    def levels(self, robot: RobotView) -> Levels:
        """Return the threshold, and a full battery."""
        level = robot.threshold if self.level is None else self.level
        return Levels(level, level, robot.capacity, robot.capacity, charger=self.charger)


@dataclass(frozen=True)
class ReachAware:
    """Works until the last moment at which it can still reach a charger, with a margin; then charges fully.

    A robot gets a task only if its energy suffices for all of it and for free driving to the nearest charger, with
    `margin` left. On the route to a good only waiting can use that up: at that instant it gives the task back. After
    loading, the delivery is always finished, so the margin covers waiting from then on. Source: the reachability
    condition of electric-vehicle routing, as in Schneider, Stenger and Goeke, Transportation Science 48 (2014) 500-520,
    applied at every decision.

    `margin`: share of the capacity. `charger`: nearest, own (its home) or least-loaded.
    """

    margin: ShareOfCapacity = 0.1
    charger: str = "nearest"
    fixed: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the parameters."""
        _part("margin", self.margin)
        _known_charger(self.charger)

    def levels(self, robot: RobotView) -> Levels:
        """Return no fixed level but the margin."""
        margin = self.margin * robot.capacity
        return Levels(margin, margin, robot.capacity, robot.capacity, margin=margin, charger=self.charger)


@dataclass(frozen=True)
class Opportunity:
    """Charges whenever the robot is idle, and stops as soon as it may take a task.

    Source: opportunity charging; McHaney, Int. J. Production Research 33 (1995), on batteries in AGV simulations.
    `minimum`: share of the capacity below which it takes no task. `margin`: share of the capacity to be left after a
    task on reaching a charger. `charger`: nearest, own or least-loaded.
    """

    minimum: ShareOfCapacity = 0.2
    margin: ShareOfCapacity = 0.1
    charger: str = "nearest"
    fixed: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the parameters."""
        _part("minimum", self.minimum)
        _part("margin", self.margin)
        _known_charger(self.charger)

    def levels(self, robot: RobotView) -> Levels:
        """Return levels that send the robot to a charger at any level, and release it above the minimum."""
        full, low = robot.capacity, self.minimum * robot.capacity
        return Levels(low, full, low, full, margin=self.margin * full, charger=self.charger)


@dataclass(frozen=True)
class FourThresholds:
    """Charges by four levels: critical, at once; good, when idle; sufficient, work may interrupt; full, end.

    Source: the four energy levels of openTCS vehicles (critical, good, sufficiently recharged, fully recharged). All
    are shares of the capacity, as is `margin`, to be left after a task on reaching a charger. `charger`: nearest, own
    or least-loaded.
    """

    critical: ShareOfCapacity = 0.3
    good: ShareOfCapacity = 0.6
    sufficient: ShareOfCapacity = 0.5
    full: ShareOfCapacity = 0.95
    margin: ShareOfCapacity = 0.1
    charger: str = "nearest"
    fixed: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the parameters."""
        for name in ("critical", "good", "sufficient", "full", "margin"):
            _part(name, getattr(self, name))
        if not self.critical <= self.sufficient <= self.full:
            raise ValueError("expected critical <= sufficient <= full")
        if not self.critical <= self.good:
            raise ValueError("expected critical <= good")
        _known_charger(self.charger)

    def levels(self, robot: RobotView) -> Levels:
        """Return the four levels in the model's unit."""
        full = robot.capacity
        return Levels(
            self.critical * full,
            self.good * full,
            self.sufficient * full,
            self.full * full,
            margin=self.margin * full,
            top_up=False,
            charger=self.charger,
        )


@dataclass(frozen=True)
class Swap:
    """Swaps the battery at a charger for a full one in a fixed time.

    Source: battery swapping of AGVs; McHaney (1995). `time`: of a swap, in time units. `level`: share of the capacity
    at which a robot goes to swap. `margin`: share to be left after a task on reaching a charger. `batteries`: spare
    ones, full at the start, shared out among the bays with chargers; a battery taken out of a robot charges by itself
    from then on, and robots wait for a full one. None: a full one is always available.
    """

    time: Annotated[float, Unit("time"), Usual("5 s", "1 h")]
    level: ShareOfCapacity = 0.2
    margin: ShareOfCapacity = 0.1
    charger: str = "nearest"
    batteries: int | None = None
    fixed: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Check the parameters."""
        if not self.time >= 0:
            raise ValueError(f"time is {self.time}, expected at least 0")
        if self.batteries is not None and self.batteries < 1:
            raise ValueError(f"batteries is {self.batteries}, expected at least 1, or none for as many as are needed")
        _part("level", self.level)
        _part("margin", self.margin)
        _known_charger(self.charger)

    def levels(self, robot: RobotView) -> Levels:
        """Return the level for a swap; a robot that parks beside a charger above it keeps its battery."""
        full, low = robot.capacity, self.level * robot.capacity
        margin = self.margin * full
        return Levels(low, low, full, full, margin=margin, top_up=False, charger=self.charger, swap_time=self.time)


def _part(name: str, value: float) -> None:
    if not 0 <= value <= 1:
        raise ValueError(f"{name} is {value}, expected a share of the capacity, from 0 to 1")


def _known_charger(charger: str) -> None:
    if charger not in CHARGERS:
        raise ValueError(f"charger is {charger!r}, expected one of {', '.join(CHARGERS)}")
