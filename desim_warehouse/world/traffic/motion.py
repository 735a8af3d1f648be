"""Acceleration and braking of robots: the exact extra time of a drive beyond its length at a steady pace.

A *stretch* is the drive of a robot from one stand to the next, in pieces of a length and a speed limit. Its
time-optimal drive accelerates to the limit, keeps to it, and brakes in time for a slower piece or a stop. Each piece
then takes its length / limit and a time lost, known in closed form (a trapezoid of speeds, or a triangle on short
pieces). In traffic a robot spends the time lost standing, as soon as it is known, and drives at the limit: no time
steps, one event a drive.

Approximations: times at the ends of a drive are exact, positions in between are not. Within v / 2a of a start and v /
2d of a stop a robot is up to v² / 2a (or v² / 2d) from a real one, 2.25 m with 1.5 m/s and 0.5 m/s².

- A robot granted the intersection just as it comes to the stop line has not braked; an instant later it has stopped,
  and pays for braking and starting.
- Robots that wait in a row start together, and a full ring when its last robot has braked and reached the pace of the
  slowest. A start postponed behind an accelerating robot counts as acceleration, up to its duration; only the rest is a
  wait.
- Robots that start one after the other from the same point, as out of a bay, follow each other v / 2a + D / v apart. A
  real robot is D away after sqrt(2 D / a) if it still accelerates then. Where D < v² / 2a they start (v - sqrt(2 a D))²
  / 2 a v too late, never too near. With D = 1, a = 0.5, v = 1.5 that is 2.167 for 2.000, with 0.4, 0.5, 1 it is 1.400
  for 1.265, with 1.3, 0.3, 1 it is 2.967 for 2.944. Queues that move up by D take 2 sqrt(D / a), exactly. The
  difference shows only where many leave one bay at the same time, as a station sends robots out one handling time
  apart.
- Estimates of energy count each stop in full, but not slower edges on the way.

The module also draws the delays of a robot at the nodes that it passes, from streams of its own.

Robots that keep their braking distance can at any time stop before the place where they may have to.

A robot that drives at v and brakes at b comes to a stand within B = v²/2b. Robots that keep only D stop instantly where
necessary, as in the paper: at the stop line, or D behind the robot ahead. Those that keep their braking distance look B
earlier. Behind another they stay D + B away while they drive (`Lane.free_at`). At B before the place that they are sure
to reach they go on, or begin to brake, and then come to a stand there whatever happens meanwhile. So an intersection is
claimed D + B ahead of it.

A ring of waiting robots sets off, and brakes, as one: while it turns they are D apart.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from desim_warehouse.values.distributions import draws
from desim_warehouse.values.disturbances import DelaySpec
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.traffic.events import Arrival, Clock
from desim_warehouse.world.traffic.rules import EPS

if TYPE_CHECKING:
    from simpy.events import Event

    from desim_warehouse.world.traffic.body import Body
    from desim_warehouse.world.traffic.drive import Drive
    from desim_warehouse.world.traffic.lane import Lane

Piece = tuple[float, float]
"""A piece of a drive: a length, and the speed limit on it."""
DRIVES_KEPT = 8192
"""Cached drives. A floor has few lengths and speeds, so 99 of 100 drives are hits, and runs take half the time."""


class Motion(NamedTuple):
    """The acceleration and deceleration of a robot, as times to gain and to lose a unit of speed."""

    gathers: float
    brakes: float


class Stretch(NamedTuple):
    """The drive of a robot since it last stood, done or committed to, and the time `lost` beyond a steady pace.

    Of a long stretch only the last pieces are kept, as far back as braking for later pieces may reach. The robot came
    to the first of them at `speed`.
    """

    motion: Motion
    speed: float = 0.0
    pieces: tuple[Piece, ...] = ()
    lost: float = 0.0

    @lru_cache(maxsize=DRIVES_KEPT)  # noqa: B019 - a stretch is a value
    def further(self, length: float, limit: float, foreseen: float = 0.0) -> tuple[float, Stretch]:
        """Return the time lost on a further piece, and the stretch including it, with the speed at its end free.

        If `foreseen` is longer, the time lost is that of a piece of this length.
        """
        more = max(time_lost(self._with(max(length, foreseen), limit), self.motion, self.speed) - self.lost, 0.0)
        return more, self._replace(pieces=self._with(length, limit), lost=self.lost + more)._without_the_past()

    def _with(self, length: float, limit: float) -> tuple[Piece, ...]:
        pieces = self.pieces
        if length <= 0:
            return pieces
        if pieces and pieces[-1][1] == limit:
            return (*pieces[:-1], (pieces[-1][0] + length, limit))
        return (*pieces, (length, limit))

    def later(self, time: float, limit: float) -> tuple[float, Stretch]:
        """Return the part of a late start that acceleration takes anyway, and the stretch with that part lost."""
        to_come = self.further(limit * limit * self.motion.gathers / 2, limit)[0]
        time = min(time, to_come)
        return time, self._replace(lost=self.lost + time)

    @property
    @lru_cache(maxsize=DRIVES_KEPT)  # noqa: B019 - a stretch is a value
    def stopped(self) -> tuple[float, Stretch]:
        """Return the further time lost if the robot stops at the end of the stretch, and the stretch after that."""
        lost = time_lost(self.pieces, self.motion, self.speed, stops=True)
        return max(lost - self.lost, 0.0), Stretch(self.motion)

    def braking_distance(self, most: float) -> float:
        """Return the distance over which it brakes to its end: `most`, or less if it reaches less speed."""
        gathers, brakes = self.motion
        run_up = self.speed * self.speed * gathers / 2 + math.fsum(length for length, _ in self.pieces)
        return min(most, run_up * brakes / (gathers + brakes))

    def at_speed(self, limit: float) -> Stretch:
        """Return the stretch after a stop, with all time lost that acceleration up to a limit can take."""
        return Stretch(self.motion, lost=limit * self.motion.gathers / 2)

    def _without_the_past(self) -> Stretch:
        """Return the stretch without the pieces that lie too far back to matter for braking."""
        pieces = self.pieces
        if len(pieces) <= 1:
            return self
        farthest = max(limit for _, limit in pieces) ** 2 * self.motion.brakes / 2
        first = len(pieces) - 1
        rest = pieces[first][0]
        while first and rest < farthest:
            first -= 1
            rest += pieces[first][0]
        if first == 0:
            return self
        speeds = _speeds(pieces, self.motion, self.speed, math.inf)
        past = math.fsum(_lost_on(pieces[i], speeds[i], speeds[i + 1], self.motion) for i in range(first))
        return Stretch(self.motion, speeds[first], pieces[first:], self.lost - past)


@lru_cache(maxsize=DRIVES_KEPT)
def time_lost(pieces: tuple[Piece, ...], motion: Motion, speed: float = 0.0, *, stops: bool = False) -> float:
    """Return the time that the time-optimal drive over pieces takes beyond the sum of length / limit.

    The robot comes to the first piece at `speed`. At the end it stops, or its speed is free.
    """
    speeds = _speeds(pieces, motion, speed, 0.0 if stops else math.inf)
    return math.fsum(_lost_on(piece, speeds[i], speeds[i + 1], motion) for i, piece in enumerate(pieces))


def _speeds(pieces: Sequence[Piece], motion: Motion, first: float, last: float) -> list[float]:
    """Return the speeds at the ends of all pieces: the highest that can be reached, and braked from in time."""
    speeds = [first]
    for i, (length, limit) in enumerate(pieces):
        then = pieces[i + 1][1] if i + 1 < len(pieces) else last
        speeds.append(min(limit, then, _reached(speeds[i], length, motion.gathers)))
    for i in reversed(range(len(pieces))):
        speeds[i] = min(speeds[i], _reached(speeds[i + 1], pieces[i][0], motion.brakes))
    return speeds


def _reached(speed: float, length: float, slowness: float) -> float:
    return math.sqrt(speed * speed + 2 * length / slowness) if slowness else math.inf


def _lost_on(piece: Piece, comes: float, goes: float, motion: Motion) -> float:
    """Return the time lost on one piece, between the speeds at its ends: up to a peak, at most the limit, and down."""
    (length, limit), (gathers, brakes) = piece, motion
    squared = (2 * length + gathers * comes * comes + brakes * goes * goes) / ((gathers + brakes) or math.inf)
    if gathers + brakes == 0 or squared >= limit * limit:
        return (gathers * (limit - comes) ** 2 + brakes * (limit - goes) ** 2) / (2 * limit)
    peak = math.sqrt(squared)
    return gathers * (peak - comes) + brakes * (peak - goes) - length / limit


class NodeDelays:
    """The random delays of a robot at the end of each lane that it enters."""

    def __init__(self, spec: DelaySpec, robot: int, streams: Streams) -> None:
        self._share = spec.share
        self._chance = streams.stream("delay-share", robot) if 0 < spec.share < 1 else None
        self._time = draws(spec.time if spec.share else 0.0, streams, "delay", robot)
        self._move = -1
        self._delay = 0.0

    def at(self, move: int) -> float:
        """Return the delay at the end of the lane that the robot entered as number `move`, from 1; 0: at its start.

        Repeated calls return the same delay.
        """
        while self._move < move:
            self._move += 1
            hit = self._share > 0 if self._chance is None else self._chance.random() < self._share
            self._delay = self._time() if hit else 0.0
        return self._delay


class LookAhead:
    """The braking distance that one robot looks ahead, where it decides whether to go on or to brake.

    `brakes` is the time in which it loses a unit of speed. `when` is the time of the latest decision expected,
    `pending` the time of its event, then or before, inf once it is made.
    """

    def __init__(self, env: Clock, robot: Body, brakes: float) -> None:
        self.env = env
        self.robot = robot
        self.brakes = brakes
        self.drive: Drive | None = None
        self.when = self.pending = math.inf

    def limit_on(self, lane: Lane) -> float:
        """Return the speed from which the robot can brake within a lane: there it claims the next intersection."""
        room = lane.length if lane.short else lane.stop_line
        return math.sqrt(2 * room / self.brakes)

    def distance(self, pace: float) -> float:
        """Return the braking distance."""
        return pace * pace * self.brakes / 2

    def expect(self) -> None:
        """Schedule the decision, one braking distance before the place that the robot is now sure to reach."""
        robot = self.robot
        assert robot.stretch is not None
        self.when = robot.until - robot.stretch.braking_distance(robot.braking) / robot.pace
        if self.when < self.pending:
            self._look_again_at(self.when)

    def _look_again_at(self, time: float) -> None:
        self.pending = max(time, self.env.now)
        Arrival(self.env, self.pending).callbacks.append(self._look)

    def _look(self, _: Event) -> None:
        now = self.env.now
        if now < self.pending:  # another event serves this decision
            return
        self.pending = math.inf
        if self.when > now + EPS:
            if self.when < math.inf:
                self._look_again_at(self.when)
            return
        robot, drive = self.robot, self.drive
        if drive is None or robot.lane is None or robot.until < now or not robot.braking:
            return
        if robot.goal - robot.target > EPS or not drive.goes_on_early(now):
            robot.begin_to_brake()
