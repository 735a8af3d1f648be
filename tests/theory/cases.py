"""Every value that theory gives and the simulation should: what the tests check, and docs/dev/validation.md shows.

Random cases: independent runs with fixed seeds; the 99 % interval of Student's t must contain the value, and lie
within 3 % of it. Cases without chance: one run, which must come as near as the case says.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from statistics import fmean
from typing import Any

from scipy.stats import t as student

import desim_warehouse as dw
from tests.theory import hours, models
from tests.theory.formulas import (
    completion,
    headway_of_a_turn,
    held_up,
    m_d_c_wait,
    m_g_1_wait,
    m_m_c_wait,
    on_and_off,
    repair_with_spares,
    repairman,
    repairmen,
    wait_until_empty,
)
from tests.theory.models import ROUND

CONFIDENCE = 0.99
WITHIN = 0.03


def half_width(values):
    """Of the interval of a mean, by Student's t."""
    n = len(values)
    return float(student.ppf(0.5 + CONFIDENCE / 2, n - 1)) * statistics.stdev(values) / math.sqrt(n)


Observe = str | Callable[[Any], float]


@dataclass(frozen=True)
class Quantity:
    """Something that theory gives a value for: `observe` reads it from a run, or names an indicator."""

    name: str
    theory: float
    observe: Observe
    within: float = WITHIN

    def of(self, run):
        return self.observe(run) if callable(self.observe) else run.kpis[self.observe]


@dataclass(frozen=True)
class Case:
    """A warehouse with a formula, and what it is known by; one run: there is no chance in it.

    `curve`: the curve that it is a point of, by its number of `robots`.
    """

    section: str
    title: str
    model: Callable[[], dict[str, Any]]
    quantities: tuple[Quantity, ...]
    runs: int = 20
    long: bool = False
    curve: str = ""
    robots: int = 0

    def simulate(self):
        model = dw.load(self.model())
        values = [[] for _ in self.quantities]
        for seed in range(self.runs):
            run = dw.simulate(model, seed)
            for quantity, sample in zip(self.quantities, values, strict=True):
                sample.append(quantity.of(run))
        return [Found(self, *one) for one in zip(self.quantities, values, strict=True)]


@dataclass(frozen=True)
class Found:
    """What the runs of a case gave for one quantity."""

    case: Case
    quantity: Quantity
    values: list[float]

    @property
    def mean(self):
        return statistics.fmean(self.values)

    @property
    def half_width(self):
        """0 where there is one run, without chance."""
        return half_width(self.values) if len(self.values) > 1 else 0.0

    @property
    def contains(self):
        """Whether the interval holds the value of theory; without chance there is none."""
        return len(self.values) == 1 or abs(self.mean - self.quantity.theory) <= self.half_width

    @property
    def near(self):
        """Whether the whole interval is as near to the value of theory as it should be."""
        farthest = abs(self.mean - self.quantity.theory) + self.half_width
        return farthest <= self.quantity.within * abs(self.quantity.theory)

    def __str__(self):
        interval = f"{self.mean:.6g} ± {self.half_width:.2g}, by theory {self.quantity.theory:.6g}"
        return f"{self.case.title}, {self.quantity.name}: {interval}"


def count(number, thing):
    return f"{number} {thing}{'s' * (number != 1)}"


# Queues

CYCLE = "mean time from release to delivery, s"


def queue(title, model, wait, service, *, long=False, section="Queues"):
    """A case whose mean cycle time is a wait and a service."""
    return Case(section, title, model, (Quantity(CYCLE, wait + service, "cycle_time_mean"),), long=long)


def queues():
    for load, tasks, long in ((0.3, 500, False), (0.5, 1200, True), (0.7, 8000, True)):
        model = partial(models.robots_that_serve, load, 10.0, 1, tasks)
        yield queue(f"M/D/1, one robot, load {load}", model, m_d_c_wait(load / 10, 10.0, 1), 10, long=long)
    for robots, load, tasks, long in ((2, 0.6, 1600, True), (5, 0.7, 1200, False), (5, 0.8, 5000, True)):
        model = partial(models.robots_that_serve, load, 1000.0, robots, tasks)
        wait = m_d_c_wait(load * robots / 1000, 1000.0, robots)
        yield queue(f"M/D/{robots}, {robots} robots, load {load}", model, wait, 1000, long=long)
    for servers, load, tasks, long in ((1, 0.4, 1000, True), (3, 0.6, 800, True), (3, 0.75, 4000, True)):
        model = partial(models.station_that_serves, load, 1000.0, servers, tasks)
        wait = m_d_c_wait(load * servers / 1000, 1000.0, servers)
        yield queue(f"M/D/{servers}, station, load {load}", model, wait, ROUND + 1000, long=long)
    for servers, load, tasks, long in ((1, 0.2, 2400, True), (1, 0.5, 9000, True), (3, 0.6, 6000, True)):
        model = partial(models.station_that_serves, load, 1000.0, servers, tasks, unload={"exponential": 1000})
        wait = m_m_c_wait(load * servers / 1000, 1000.0, servers)
        yield queue(f"M/M/{servers}, station, load {load}", model, wait, ROUND + 1000, long=long)
    near, far, unload, load = 4.0, 10.0, 1.0, 0.4
    mean = 0.75 * (near + unload) + 0.25 * (far + unload)
    square = 0.75 * (near + unload) ** 2 + 0.25 * (far + unload) ** 2
    model = partial(models.near_and_far, near, far, unload, load, 2400)
    yield queue(
        "M/G/1, one robot, goods near and far, load 0.4", model, m_g_1_wait(load / mean, mean, square), mean, long=True
    )
    times = {"quick": 500.0, "slow": 2000.0}
    wait = m_g_1_wait(0.4 / 1250, 1250.0, sum(t * t for t in times.values()) / 2)
    yield Case(
        "Queues",
        "M/G/1, station, two flows, load 0.4",
        partial(models.flows_at_a_station, 0.4, times, 6000),
        tuple(
            Quantity(f"{CYCLE}, flow {flow}", ROUND + service + wait, f"cycle_time_mean:{flow}")
            for flow, service in times.items()
        ),
        long=True,
    )
    busy = Quantity("part of its time that it is busy", 0.6, lambda run: 1 - run.kpis["share_idle"])
    model = partial(models.robots_that_serve, 0.6, 10.0, 1, 5000)
    yield Case("Queues", "M/D/1, one robot, load 0.6", model, (busy,), long=True)
    length = 0.4 / 1000 * m_d_c_wait(0.4 / 1000, 1000.0, 1)
    waiting = Quantity("robots in the queue, by Little's law", length, lambda run: 12 * run.kpis["share_queueing"])
    model = partial(models.station_that_serves, 0.4, 1000.0, 1, 16_000, robots=12)
    yield Case("Queues", "M/D/1, station, load 0.4, 12 robots", model, (waiting,), long=True)
    for robots in (2, 4, 5, 8):  # n robots get n tasks done a round as long as the desk is not the bottleneck
        done = Quantity("tasks per hour", 3600 * min(robots / 40, 1 / 10), "throughput_per_hour", 0.005)
        title = f"closed line D/D/1, {count(robots, 'robot')}, 30 s round, 10 s service"
        model = partial(models.crews, robots, 10.0, 30.0)
        yield Case("Queues", title, model, (done,), runs=1, curve="closed line D/D/1", robots=robots)


def lifts():
    """N robots that ride in one lift: what it lets through as the repairman of Takacs."""
    for robots, length, runs in ((1, 300, 20), (2, 100, 20), (4, 150, 20), (8, 8, 10), (12, 40, 20)):
        hourly = repairman(robots, 300.0, models.RIDING) * 3600 / models.RIDING
        rides = Quantity("rides per hour", hourly, "throughput_per_hour")
        model = partial(models.upstairs, robots, 300.0, 3600.0 * length)
        title = f"M/G/1//{robots}, {count(robots, 'robot')} and a lift"
        yield Case("Lifts", title, model, (rides,), runs=runs, long=runs > 10)


def pickers():
    """N robots that wait for c pickers, as machines for repairers; few waits are told less well than lines an hour."""
    for number, tasks, long in ((1, 250, False), (1, 2000, True), (2, 2000, True), (3, 2000, True), (4, 2000, True)):
        each = repairmen(6, number, 72.0, 60.0)
        lines = Quantity("lines per hour", 3600 * each, "throughput_per_hour")
        waits = Quantity("robots that wait for a picker", 6 - each * (72.0 + 60.0), waiting_for_pickers)
        model = partial(models.robots_that_wait_for_pickers, 6, number, 72.0, 60.0, tasks)
        title = (
            f"M/M/{number}//6, 6 robots and {count(number, 'picker')}{', long runs' if long and number == 1 else ''}"
        )
        quantities = (waits,) if not long else (lines, waits) if number <= 2 else (lines,)
        yield Case("People who pick into robots", title, model, quantities, long=long)


def waiting_for_pickers(run):
    """The mean number of robots that wait for one."""
    return run.kpis["share_awaiting_picker"] * run.model.fleet.size


# Lanes and intersections

ROADS = "Lanes and intersections"
TURN = headway_of_a_turn(math.pi / 2, math.radians(30), models.D, models.SPEED)


def per_time(run):
    """Tasks per time unit after the warm-up."""
    return run.kpis["tasks"] / (run.record.end - run.model.run.warm_up)


def headways(run, lane):
    """Times between robots that enter a lane, one after the other."""
    return [b - a for a, b in pairwise(row[0] for row in entries(run, lane))]


def entries(run, *lanes):
    return [row for row in run.record.rows if row[1] == "enter" and row[5] in lanes]


def straight_over_the_crossing(run):
    """Robots a second, after 500."""
    return sum(row[0] > 500 for row in entries(run, ("X", "E1"), ("X", "S1"))) / 1500


def ring(title, flow, within, robots, curve="", **more):
    model = partial(models.oval, 80 * models.D, robots, **more)
    passing = Quantity("robots past a point, 1/s", flow, per_time, within)
    return Case(ROADS, title, model, (passing,), runs=1, curve=curve, robots=robots)


def roads():
    # With robots 2 D apart all of these would be less; the corners are the bottleneck from 59 robots on.
    for robots in (45, 50, 55, 60, 70):
        flow = min(robots * models.SPEED / (80 * models.D), 1 / TURN)
        yield ring(f"ring of 80 D, {count(robots, 'robot')}", flow, 0.01, robots, "ring of 80 D")
    for robots in (20, 40, 60):
        title = f"ring of 80 D, {robots} robots, 3 s at each corner"
        yield ring(title, 1 / (TURN + 3), 0.01, robots, "3 s at each corner", node_time=3.0)
    # one robot at a time: it drives the last D, unloads, and sets off as the next one comes up the bend
    yield ring("ring of 80 D, 30 robots that unload 5 s in the lane", 1 / (TURN + 5), 0.02, 30, unload_time=5.0)
    close = models.D / models.SPEED
    yield Case(
        ROADS,
        "street with a corner of 90°, 30 robots out of a bay",
        partial(models.street, 30),
        (
            Quantity("headway out of the bay, s", close, lambda run: fmean(headways(run, ("A", "B"))), 1e-6),
            Quantity("headway straight on, s", close, lambda run: fmean(headways(run, ("B", "C"))), 1e-6),
            Quantity("headway after the corner, s", TURN, lambda run: fmean(headways(run, ("C", "E"))), 1e-6),
        ),
        runs=1,
    )
    over = Quantity("robots straight over it, 1/s", 1 / TURN, straight_over_the_crossing, 0.02)
    yield Case(ROADS, "two streams of 60 robots that cross at 90°", partial(models.crossing, 60), (over,), runs=1)


# Chargers

CHARGERS = "Chargers as servers"


def working(run):
    """Robots that do not charge, queue or rest, on average."""
    resting = sum(run.kpis[f"share_{state}"] for state in ("charging", "queueing", "idle"))
    return len(run.record.robots) * (1 - resting)


def charging(run):
    """Robots at chargers, on average."""
    return len(run.record.robots) * run.kpis["share_charging"]


def power(run):
    """Energy drawn a second, after the warm-up."""
    return run.kpis["energy"] / (run.record.end - run.model.run.warm_up)


def chargers():
    for robots, up, swap in ((1, 100.0, 50.0), (4, 100.0, 30.0)):
        busy = repairman(robots, up, swap)
        yield Case(
            CHARGERS,
            f"machine repairman M/D/1//{robots}: {count(robots, 'robot')}, one place to swap batteries",
            partial(models.fleet_with_one_charger, robots, up, swap, 500),
            (
                Quantity("part of the time that it is busy", busy, charging),
                Quantity("swaps per hour", 3600 * busy / swap, "throughput_per_hour"),
            ),
            runs=10,
            long=robots > 1,
        )
    for robots, spare, up, charge in ((4, 2, 100.0, 80.0), (2, 3, 100.0, 150.0)):
        yield Case(
            CHARGERS,
            f"machine repair with spares M/D/infinity: {count(robots, 'robot')}, {spare} spare batteries that charge",
            partial(models.fleet_with_spare_batteries, robots, spare, up, charge, 1000),
            (Quantity("swaps per hour", 3600 * repair_with_spares(robots, spare, up, charge), "throughput_per_hour"),),
            runs=10,
            long=True,
        )
    p, r = 0.5, 1.0  # power in is power out: robots at work draw p, a charger gives r
    for places, robots in ((1, 1), (4, 4), (3, 6), (2, 5), (1, 2)):
        at_work = robots * r / (p + r)
        yield Case(
            CHARGERS,
            f"{count(robots, 'robot')} with work at all times, {count(places, 'charger')}",
            partial(models.fleet_on, places, robots, p, r),
            (
                Quantity("robots at work", at_work, working),
                Quantity("power drawn", p * at_work, power),
                Quantity("robots at chargers", p * at_work / r, charging),
            ),
            runs=1,
        )
    load, robots = 0.4, 3
    yield Case(
        CHARGERS,
        "3 robots, random work, load 0.4 without charging",
        partial(models.work_at_random, load, robots, p, r),
        (
            Quantity("power drawn", load * robots * p, power),
            Quantity("robots at chargers", load * robots * p / r, charging),
        ),
        long=True,
    )


# Breakdowns and outages

FAILURES = "Breakdowns and outages"


def failures():
    for robots, every, repair, length in ((1, 400.0, 100.0, 6e4), (12, 200.0, 20.0, 1e4)):
        yield Case(
            FAILURES,
            f"{count(robots, 'robot')}, a breakdown every {every:g} s of operation, repair {repair:g} s",
            partial(models.crews_that_break_down, robots, every, repair, length),
            (Quantity("availability", every / (every + repair), "availability"),),
            long=robots > 1,
        )
    every, repair, service, load = 50.0, 20.0, 10.0, 0.25
    mean, square = completion(service, service**2, every, repair, 2 * repair**2)
    yield queue(
        "M/D/1 with breakdowns in the middle of a service, one robot that drives",
        partial(models.round_as_service, service, load, 12_000, every, repair),
        m_g_1_wait(load / service, mean, square),
        mean,
        long=True,
        section=FAILURES,
    )
    every, repair, service, load = 5000.0, 1000.0, 1000.0, 0.2
    mean, square = completion(service, 2 * service**2, every, repair, 2 * repair**2)
    desk = models.robots_that_serve(load, service, 1, 9000, unload_time={"exponential": service})
    # a breakdown that is due while it unloads is found as it sets off, so the next task waits for the repair
    yield queue(
        "M/M/1 with breakdowns, repaired at the end of a service, one robot that unloads",
        partial(models.breaks_down, desk, every, repair),
        m_g_1_wait(load / service, mean, square),
        models.ROUND + service,
        long=True,
        section=FAILURES,
    )
    every, repair, up, swap = 300.0, 100.0, 100.0, 50.0
    down = fmean(on_and_off(time, every, repair) for time in models.petal_times(up))
    cycle = up + down * repair + swap * (1 + repair / every)
    yield Case(
        FAILURES,
        "1 robot, one place to swap batteries, in order for 300 s and in repair for 100 s",
        partial(models.with_outages, models.fleet_with_one_charger(1, up, swap, 1000), every, repair),
        (
            Quantity("swaps per hour", 3600 / cycle, "throughput_per_hour"),
            Quantity("part of the time that it is in use", swap / cycle, charging),
        ),
        runs=20,
        long=True,
    )
    p, r, places, robots, every, repair = 0.5, 1.0, 2, 4, 400.0, 100.0
    at_chargers = robots * p / (p + r)  # 1.33; of the two 1.6 work
    yield Case(
        FAILURES,
        "4 robots with work at all times, 2 chargers in order for 400 s and in repair for 100 s",
        partial(models.with_outages, models.fleet_on(places, robots, p, r, 5e4), every, repair),
        (Quantity("robots at chargers", at_chargers, charging), Quantity("power drawn", at_chargers * r, power)),
        long=True,
    )


def passages(run):
    """How often the aisle with people is passed, in the counted time."""
    return next(row["passages"] for row in run.record.edges if row["edge"] == "B>C")


def people():
    """A robot before an aisle: people come at random and stay for exponential times."""
    rate, stay, away = 1 / 60, 40.0, 60.0
    held = Quantity(
        "passages before which it is held up",
        held_up(rate, stay, away),
        lambda run: sum(wait.end >= run.record.begin for wait in run.history.waits) / passages(run),
    )
    waited = Quantity(
        "mean wait before a passage, s",
        wait_until_empty(rate, stay, away),
        lambda run: run.kpis["waiting_person"] / passages(run),
    )
    model = partial(models.robot_before_people, rate, stay, away, 2500)
    yield Case("Queues", "M/M/infinity, a robot waits for an aisle without people", model, (held, waited), long=True)


# Hours and buffers

HOURS = "Opening hours, shifts and buffers"


def hours_and_buffers():
    for load, share, tasks in ((0.2, 0.5, 3000), (0.4, 0.8, 9000)):
        # As many are there on average as in M/M/1, also while it is closed, and fewer come: by Little's law
        wait = (m_m_c_wait(load / 1000, 1000.0, 1) + 1000) / share
        yield Case(
            HOURS,
            f"M/M/1 in open hours, {100 * share:g} % of the time, load {load}",
            partial(hours.queue_in_open_hours, load, share, tasks),
            (Quantity(CYCLE, wait, "cycle_time_mean"),),
            long=True,
        )
    for where in ("robots", "the station"):
        yield Case(
            HOURS,
            f"M/D/∞, {where} at work 60 % of the time",
            partial(hours.work_at_all_times, 0.6, 40, 1500, where),
            (Quantity(CYCLE, hours.SERVICE + hours.wait_for_hours(0.6), "cycle_time_mean"),),
            long=True,
        )
    for at_close, done in (("pause", 99.5), ("finish", 100)):
        yield Case(
            HOURS,
            f"busy station with 10 s service, open 995 of 2000 s, at_close: {at_close}",
            partial(hours.busy_station, 995.0, 10.0, at_close),
            (Quantity("tasks per hour", 3600 * done / hours.EVERY, "throughput_per_hour", 0.001),),
            runs=1,
        )
    for places, workers, unload, work in ((1, 1, 10.0, 10.0), (2, 1, 10.0, 10.0), (4, 2, 10.0, 25.0)):
        yield Case(
            HOURS,
            f"M/M/{workers}/{places}, buffer of {count(places, 'place')}, {count(workers, 'worker')}, always work",
            partial(hours.full_buffer, places, workers, unload, work, 1500),
            (
                Quantity(
                    "tasks per hour",
                    3600 * hours.through_a_buffer(places, workers, unload, work),
                    "throughput_per_hour",
                ),
            ),
            long=True,
        )


def pods():
    """Lines that a pod serves where few are open at a station; with more, those that are left are on fewer pods."""
    share = 0.15
    for lines, pod in ((1, "nearest"), (2, "random")):
        chosen = lines * share / (1 - (1 - share) ** lines)
        yield Case(
            "Goods to person",
            f"one robot, {count(lines, 'open line')}, an item on {100 * share:g} % of the pods, pod: {pod}",
            partial(models.hall_of_pods, lines, pod, share),
            (Quantity("lines picked at a visit", chosen / (1 - share), "pile_on"),),
            long=True,
        )


CASES = [*queues(), *lifts(), *pickers(), *people(), *roads(), *chargers(), *hours_and_buffers(), *failures(), *pods()]
