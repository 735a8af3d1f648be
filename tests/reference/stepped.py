"""The paper's warehouse run step by step: an oracle for the event-driven model, sharing no code with it.

In every step every robot tests its distance and bearing to every other robot, as Liu et al. (ROBIO 2017) do.
What the paper leaves open was settled by comparison with the results of their program (`program.csv`).
One file on purpose, though long: it stands alone, so nothing it checks can lend it a mistake.
Lengths are in pixels, times in steps. What happens within one step, in this order:

1. Full robots at home take waiting goods; robots that are ready come out (lower number first).
2. Robots act from the highest number to the lowest, but a robot in another's way acts before it. So a robot
   sees the one ahead where it is after this step: that one goes on, the one behind waits until it is away.
3. Batteries: a robot that gets to its threshold on the way to a good gives it back (lower number first).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

START_STEPS = 11  # from the start of a run to standing at the letter: 40 px at 4 px a step, and a turn
TURN_STEPS = 1  # at every node reached, also when going straight on, before unloading and before going in
AFTER_UNLOADING_STEPS = 3
FULL_STEPS = 1  # from fully charged to taking the next good
COMING_OUT_STEPS = 2  # from taking a good after a charge to standing at the letter
TINY = 1e-9
ROUNDED = 0.5  # what a drive of 150 or 250 px takes longer in whole steps of 4 px than it should

Point = tuple[float, float]


@dataclass(frozen=True)
class Setting:
    """One experiment: `robots` robots fetch `goods` (numbers 0..79, in order) to the letter `unload_at`.

    `finer`: into how many equal parts each step is cut, an even number (or 1, as in the paper): what drives are rounded
    up by in whole steps is then spent at the nodes. Times stay in whole steps. `braking`: how much speed robots gain or
    lose in a step, if not all at once. Then they can always brake before the place where they have to stop.
    """

    robots: int
    goods: tuple[int, ...]
    unload_at: str = "M"
    capacity: float = 10.0
    threshold: float = 3.5
    consumption: float = 0.005
    charge_rate: float = 0.05
    radius: float = 12.5
    margin: float = 8.0
    speed: float = 4.0
    collision_angle: float = 30.0
    load_time: int = 10
    unload_time: int = 20
    finer: int = 1
    braking: float | None = None

    @property
    def stride(self):
        """How far a robot drives in a part of a step."""
        return self.speed / self.finer

    @property
    def braking_distance(self):
        """From its speed."""
        return self.speed**2 / (2 * self.braking) if self.braking else 0.0


@dataclass(frozen=True)
class Outcome:
    """Task time `T` in steps, waiting episodes `S`, outings after a charge `C`, and goods delivered."""

    T: float
    S: int
    C: int
    delivered: int


# The warehouse

LETTERS = "ABCDEFGHIJKLMNOPQR"
PLACES = {a: (25.0 + 150 * (i % 6), 25.0 + 250 * (i // 6)) for i, a in enumerate(LETTERS)}
ROWS = ("ABCDEF", "GHIJKL", "RQPONM")
COLUMNS = ("MGA", "BHN", "OIC", "DJP", "QKE", "FLR")


def successors():
    """The one-way edges: for each letter the row successor first, then the column successor."""
    after = {letter: [] for letter in LETTERS}
    for street in ROWS + COLUMNS:
        for a, b in pairwise(street):
            after[a].append(b)
    return after


AFTER = successors()


def highways(start, goal):
    """Give the letters after `start` up to `goal` on Algorithm 1's path: fewest hops, rows before columns."""
    paths = deque([[start]])
    seen = {start}
    while paths:
        path = paths.popleft()
        if path[-1] == goal:
            return path[1:]
        for letter in AFTER[path[-1]]:
            if letter not in seen:
                seen.add(letter)
                paths.append([*path, letter])
    raise ValueError(f"no way from {start} to {goal}")


def place_of(good):
    """Give the edge (from, to) a good is picked from and the point where the robot stands to pick it."""
    group, i = divmod(good, 8)
    column, row = group // 2 + i % 2, group % 2
    upper, lower = LETTERS[6 * row + column], LETTERS[6 * row + 6 + column]
    x, y = PLACES[upper]
    a, b = (upper, lower) if lower in AFTER[upper] else (lower, upper)
    return a, b, (x, y + 50.0 * (i // 2 + 1))


# The robots


@dataclass(eq=False)
class Robot:
    """What the others can see of a robot, and where its `story` (one `yield` a step) has got to."""

    number: int
    home: str
    good: int | None = None
    point: Point = (0.0, 0.0)
    heading: Point = (0.0, 1.0)
    battery: float = 0.0
    inside: bool = True  # in the charging zone, where it is in no robot's way
    ready: bool = False  # in the zone, waiting to come out
    idle: bool = False  # in the zone, full, nothing to fetch
    charged: bool = False  # has charged before: going out again counts for C
    awake: bool = False  # uses its battery: from the moment it is sent out until it is home
    low: bool = False  # has reached the threshold since the last charge
    fetching: bool = False  # on the way to the node where its good's edge begins
    waits_for: Robot | None = None
    pace: float = 0.0
    story: Iterator[None] = field(default_factory=lambda: iter(()))


class Warehouse:
    """One run of a setting; `self.now` counts the finished steps."""

    def __init__(self, setting, *, higher_first=True):
        self.setting = setting
        self.higher_first = higher_first
        self.goods = deque(setting.goods)
        self.now = self.finished = self.S = self.C = self.delivered = 0
        self.reach = 2 * setting.radius + setting.margin
        self.robots = [Robot(k, LETTERS[k % 6], battery=setting.capacity) for k in range(setting.robots)]
        for robot in self.robots:
            robot.good = self.goods.popleft() if self.goods else None
            robot.awake = robot.good is not None
            robot.story = self.life(robot)

    def run(self):
        while self.delivered < len(self.setting.goods) or not all(robot.inside for robot in self.robots):
            self.step()
            if self.now > 1_000_000 * self.setting.finer:
                raise RuntimeError(f"no end in sight: {self.setting}")
        return Outcome(self.finished / self.setting.finer, self.S, self.C, self.delivered)

    def step(self):
        for robot in self.robots:
            if robot.idle and self.goods:
                robot.idle, robot.awake, robot.good = False, True, self.goods.popleft()
                self.C += robot.charged
            if robot.ready:
                self.open_door(robot)
        waiting = set(self.robots)
        for robot in reversed(self.robots) if self.higher_first else self.robots:
            self.act(robot, waiting)
        for robot in self.robots:
            self.use_battery(robot)
        self.now += 1

    def act(self, robot, waiting):
        """Let a robot do its step, once those in its way, or in its way within a step, have done theirs."""
        if robot not in waiting:
            return
        waiting.remove(robot)
        if not robot.inside:
            for other in self.in_way(robot, self.reach + self.setting.stride + self.setting.braking_distance):
                self.act(other, waiting)
        next(robot.story)

    # Batteries and doors

    def use_battery(self, robot):
        """Use one step's charge; at the threshold a good still being fetched goes back to the front."""
        if not robot.awake:
            return
        robot.battery -= self.setting.consumption / self.setting.finer
        if not robot.low and robot.battery <= self.setting.threshold + TINY:
            robot.low = True
            if robot.fetching and robot.good is not None:
                self.goods.appendleft(robot.good)
                robot.good = None

    def open_door(self, robot):
        """Put a robot on its letter as soon as no other is within the stopping distance of it."""
        door = PLACES[robot.home]
        near = (r for r in self.robots if not r.inside and math.dist(r.point, door) <= self.reach + TINY)
        self.wait_for(robot, next(near, None))
        if robot.waits_for is None:
            robot.inside, robot.ready, robot.point = False, False, door

    def wait_for(self, robot, other):
        """Stop for `other`, or go on; S counts the stops, however many robots one stop is for in turn."""
        if other and not robot.waits_for:
            self.S += 1
        robot.waits_for = other

    # Collisions

    def in_way(self, robot, reach):
        """List the robots within `reach` and within the collision angle of the robot's heading."""
        cosine = math.cos(math.radians(self.setting.collision_angle))
        robots = []
        for other in self.robots:
            if other is robot or other.inside:
                continue
            dx, dy = other.point[0] - robot.point[0], other.point[1] - robot.point[1]
            distance = math.hypot(dx, dy)
            along = dx * robot.heading[0] + dy * robot.heading[1]
            if distance <= reach + TINY and along > cosine * distance + TINY:
                robots.append(other)
        return robots

    def must_wait(self, robot):
        """Test all other robots: whether the robot has to stop, or stay where it is, in this step.

        A robot that has stopped waits until the other is away, whatever the angle by then. It never stops for
        one that is waiting for it, directly or through others: so no ring of robots waits without end.
        """
        candidates = self.in_way(robot, self.reach)
        before = robot.waits_for
        if before and not before.inside and math.dist(before.point, robot.point) <= self.reach + TINY:
            candidates.insert(0, before)
        self.wait_for(robot, next((other for other in candidates if not is_waiting_for(other, robot)), None))
        return robot.waits_for is not None

    # The life of a robot

    def drive(self, robot, goal):
        """Drive straight on to `goal`; the last step is as short as it needs to be (150 px take 38 steps)."""
        length = math.dist(robot.point, goal)
        while length > TINY:
            robot.heading = ((goal[0] - robot.point[0]) / length, (goal[1] - robot.point[1]) / length)
            if self.must_wait(robot):
                robot.pace = 0.0
            else:
                stride = self.stride(robot, length)
                x, y = robot.point
                robot.point = (x + stride * robot.heading[0], y + stride * robot.heading[1])
                length = math.dist(robot.point, goal)
                if length <= TINY:
                    robot.point = goal
            yield

    def stride(self, robot, length):
        """How far it drives in this step: if it brakes, so that it can stop at its goal and before the others."""
        setting = self.setting
        if setting.braking is None:
            return min(setting.stride, length)
        room, change = min(length, self.free_way(robot)), setting.braking / setting.finer
        # After v / finer in this step it needs v^2 / 2 b more to stop: as fast as leaves that.
        safe = math.sqrt(change * change + 2 * setting.braking * room) - change
        robot.pace = min(setting.speed, robot.pace + change, safe)
        if room <= change / setting.finer / 2:  # the rest in one step
            robot.pace = 0.0
            return room
        return robot.pace / setting.finer

    def free_way(self, robot):
        """How far it could drive until it had to wait, if all others stood still."""
        tangent = math.tan(math.radians(self.setting.collision_angle))
        free = math.inf
        for other in self.robots:
            dx, dy = other.point[0] - robot.point[0], other.point[1] - robot.point[1]
            along, across = (
                dx * robot.heading[0] + dy * robot.heading[1],
                abs(dx * robot.heading[1] - dy * robot.heading[0]),
            )
            if other is robot or other.inside or across >= self.reach or is_waiting_for(other, robot):
                continue
            near = math.sqrt(self.reach**2 - across**2)
            if near * tangent > across and along >= near:
                free = min(free, along - near)
        return free

    def follow(self, robot, letters):
        for letter in letters:
            yield from self.drive(robot, PLACES[letter])
            yield from self.rest(TURN_STEPS + (ROUNDED if self.setting.finer > 1 else 0))

    def life(self, robot):
        """Go in and out of the charging zone without end: `run` stops when the work is done."""
        steps = START_STEPS
        while True:
            if robot.good is None:
                robot.idle, steps = True, COMING_OUT_STEPS
            while robot.idle:  # until `step` gives it a good
                yield
            yield from self.come_out(robot, steps)
            yield from self.work(robot)
            yield from self.charge(robot)

    def come_out(self, robot, steps):
        robot.fetching = True
        yield from self.rest(steps, less=1)
        robot.ready = True
        while robot.inside:  # until `step` opens the door
            yield

    def work(self, robot):
        """From the home letter: fetch and deliver as long as there is a good for the robot, then go home."""
        at = robot.home
        while robot.good is not None:
            at = yield from self.fetch(robot, at)
            if robot.good is not None:
                yield from self.deliver(robot)
                at = self.setting.unload_at
        yield from self.follow(robot, highways(at, robot.home))

    def fetch(self, robot, at):
        """Go to where the good's edge begins, unless the battery gets low; return the letter reached."""
        assert robot.good is not None
        for letter in highways(at, place_of(robot.good)[0]):
            if robot.good is None:
                break
            yield from self.follow(robot, [letter])
            at = letter
        robot.fetching = False
        return at

    def deliver(self, robot):
        """Pick the good, take it to the unloading letter, and be given the next unless the battery is low."""
        assert robot.good is not None
        _, end, point = place_of(robot.good)
        yield from self.drive(robot, point)
        yield from self.rest(self.setting.load_time)
        yield from self.follow(robot, [end, *highways(end, self.setting.unload_at)])
        yield from self.rest(self.setting.unload_time)
        self.delivered += 1
        robot.good = self.goods.popleft() if self.goods and not robot.low else None
        robot.fetching = True
        yield from self.rest(AFTER_UNLOADING_STEPS)

    def charge(self, robot):
        """Go in and charge up; the charge counts when the robot goes out again (see `step`)."""
        robot.inside, robot.awake = True, False
        self.finished = self.now + 1
        missing = self.setting.capacity - robot.battery
        charging = math.ceil(missing / self.setting.charge_rate * self.setting.finer - TINY) / self.setting.finer
        yield from self.rest(charging + FULL_STEPS, less=1)
        robot.battery, robot.low, robot.charged = self.setting.capacity, False, True

    def rest(self, steps, *, less=0):
        """Stand for some steps, `less` that many of the parts into which they are cut."""
        for _ in range(round(steps * self.setting.finer) - less):
            yield


def is_waiting_for(robot, other):
    following = robot.waits_for
    while following is not None and following is not other:
        following = following.waits_for
    return following is other


def simulate(setting, *, higher_first=True):
    """Run a setting to the end: all goods delivered and every robot back in its charging zone.

    `higher_first` says who goes on when two robots are equally far from the node where their ways meet. One
    cell of the program tells (6 robots, goods group 1: 1167 steps, not 1171). Where the two orders give
    different outcomes the setting turns on such a tie, and a model with another order may agree with either.
    """
    return Warehouse(setting, higher_first=higher_first).run()
