"""Speeds of robots, slow edges and times at nodes, from positions a second apart.

Times at nodes come from positions, not from when the node in a message changes: that is up to a second late, and the
bias of a trial was many times its interval. Of messages near a node not the last before it and the first after it
count, but one further away on either side: which is the last before a margin depends on the noise of its position.
With 3 cm and a message a second that made slow edges up to 0.4 % too slow.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from desim_warehouse.fleet_log.estimates import FEWEST, KeyEstimate, densest, short, t_quantile, undisturbed, unknown
from desim_warehouse.fleet_log.floor import Tracks
from desim_warehouse.fleet_log.table import NOTHING
from desim_warehouse.values.arrays import Flags, Floats, Ints

MARGIN = 0.3
"""Of an edge its ends are left out, this multiple of D: there robots brake, turn, or are taken for elsewhere."""
SLOW = 0.93
"""An edge is slow where robots drive below this share of what they drive elsewhere."""
_ALIKE = 1.08
"""Slow edges whose speeds differ by less are one zone."""
_ROUNDS = 8
_STRAIGHT, _CORNER = 15.0, 90.0
_CLOCK = 0.005
"""Standard error of a time at a node that no number of passages takes away, as a share of the step between messages:
stamps are rounded, and robots are held up for less than a message shows."""
_SEEN = 2.5
"""Standard errors from 0 beyond which a turn takes time of its own."""


class DrivingTimes:
    """Estimates of speeds, slow edges and times at nodes of the robots in some tracks."""

    def __init__(self, tracks: Tracks) -> None:
        self.tracks = tracks
        robot = tracks.model.fleet.robot
        braking = 0.0 if robot.acceleration is None else robot.speed**2 / (2 * robot.acceleration)
        self.margin = MARGIN * tracks.model.fleet.contact + braking
        self.limits = np.array([limit for _, _, limit, _ in tracks.model.floor.edges])
        for zone in tracks.model.traffic.slow.values():
            if zone.hours is None:
                self._lower(zone)
        on = (tracks.edge >= 0) & (tracks.action == NOTHING) & ~tracks.fault
        length = tracks.lengths[tracks.edge]
        self.clear = on & (tracks.along > self.margin) & (tracks.along < length - self.margin)
        self._stretches()
        self.sigma = 1e-9
        self.speeds = [self._speed(loaded) for loaded in (False, True)]
        self.sigma = self._noise()
        self.slow = self._slow_edges()
        if self.slow:  # slow edges say nothing of the speed elsewhere
            self.speeds = [self._speed(loaded) for loaded in (False, True)]

    def _lower(self, zone: Any) -> None:
        from desim_warehouse.layout.zones import edges_of

        for edge in edges_of(self.tracks.model.floor, zone.members):
            number = self.tracks.edges.index(edge)
            self.limits[number] = min(self.limits[number], zone.speed)

    def _stretches(self) -> None:
        """Find stretches on one edge, driven without a stop: edge, loaded, way and time of each."""
        tracks = self.tracks
        free = self.clear & tracks.driving
        follows = free[1:] & free[:-1] & tracks.joined[1:]
        follows &= (tracks.edge[1:] == tracks.edge[:-1]) & (tracks.load[1:] == tracks.load[:-1])
        begins = free & ~np.concatenate([[False], follows])
        ends = free & ~np.concatenate([follows, [False]])
        first, last = np.flatnonzero(begins), np.flatnonzero(ends)
        first, last = first + 1, last - 1  # noise decides which position is first past the margin
        long = last - first >= 2  # noqa: PLR2004 - three messages: a stop in between would show
        first, last = first[long], last[long]
        self.edge, self.loaded = tracks.edge[first], tracks.load[first]
        self.way = tracks.along[last] - tracks.along[first]
        self.time = tracks.time[last] - tracks.time[first]

    def _usual(self, loaded: bool) -> Flags:
        """Whether each stretch is free of speed limits and slow edges, for loaded or empty robots."""
        slow = {number for numbers, _ in getattr(self, "slow", ()) for number in numbers}
        free = np.isinf(self.limits)
        free[list(slow)] = False
        return np.asarray(free[self.edge] & (self.loaded == loaded) & (self.way > 0))

    def _speed(self, loaded: bool) -> tuple[float, float, int]:
        """Return speed, half-width of its interval, and number of stretches; nan where they are too few."""
        return (
            _steady(self.way[use], self.time[use], self.edge[use], self.sigma)
            if (use := self._usual(loaded)).sum() >= FEWEST
            else (math.nan, math.nan, int(use.sum()))
        )

    def _noise(self) -> float:
        """Return the standard deviation of a way measured between two positions, from ways too long for the speed."""
        own = np.array([speed for speed, _, _ in self.speeds])[self.loaded.astype(int)]
        off = (self.way - own * self.time)[self._usual(False) | self._usual(True)]
        off = off[np.isfinite(off)]
        return undisturbed(off, 1)[1] if len(off) else 1e-9

    def _slow_edges(self) -> list[tuple[list[int], tuple[float, float, int]]]:
        """Return edges slower than the model's limits and the speed elsewhere, grouped by like speeds."""
        speeds: dict[int, float] = {}
        for number in np.unique(self.edge):
            for loaded, (usual, _, _) in enumerate(self.speeds):
                use = (self.edge == number) & (self.loaded == bool(loaded)) & (self.way > 0)
                if use.sum() < FEWEST or math.isnan(usual):
                    continue
                speed, half, _ = _steady(self.way[use], self.time[use], self.edge[use], self.sigma)
                if speed + half < SLOW * min(usual, self.limits[number]):
                    speeds[int(number)] = max(speed, speeds.get(int(number), 0.0))
        zones: list[list[int]] = []
        for number in sorted(speeds, key=lambda edge: speeds[edge]):
            if zones and speeds[number] < _ALIKE * speeds[zones[-1][0]]:
                zones[-1].append(number)
            else:
                zones.append([number])
        return [(sorted(zone), self._on(zone)) for zone in zones]

    def _on(self, zone: list[int]) -> tuple[float, float, int]:
        use = np.isin(self.edge, zone) & (self.way > 0)
        return _steady(self.way[use], self.time[use], self.edge[use], self.sigma)

    # What comes out

    def estimates(self) -> list[KeyEstimate]:
        """Speed, speed with a load, slow edges, and times at nodes."""
        return [*self._speed_keys(), *self._slow_keys(), *self._node_keys()]

    def _speed_keys(self) -> list[KeyEstimate]:
        estimates = []
        for key, (speed, half, n) in zip(("speed", "speed_loaded"), self.speeds, strict=True):
            name = f"fleet.robot.{key}"
            if math.isnan(speed):
                estimates.append(
                    unknown(name, f"{n} stretches of three messages on an edge are too few", n, "stretches")
                )
            else:
                estimates.append(
                    KeyEstimate(name, short(speed), speed, speed - half, speed + half, n, "stretches on an edge")
                )
        gathering = "a second between messages hides how robots gather speed"
        return [
            *estimates,
            unknown("fleet.robot.acceleration", gathering),
            unknown("fleet.robot.delays", "they look like waits"),
        ]

    def _slow_keys(self) -> list[KeyEstimate]:
        estimates = []
        for rank, (zone, (speed, half, n)) in enumerate(self.slow, 1):
            edges = [list(self.tracks.edges[number]) for number in zone]
            value = {"members": edges, "speed": short(speed)}
            key = f"traffic.slow.found_{rank}"
            why = f"{len(edges)} edges that the model has no such limit for"
            estimates.append(
                KeyEstimate(key, value, speed, speed - half, speed + half, n, "stretches on them", why, f"{key}.speed")
            )
        return estimates

    def _node_keys(self) -> list[KeyEstimate]:
        keys = "traffic.node_time", "traffic.turn_time"
        if self.tracks.model.fleet.robot.acceleration is not None:
            return [unknown(key, "braking for a node takes time, too, which the log cannot tell apart") for key in keys]
        excess, angle, kind = self._passages()
        groups = [
            (degrees / _CORNER, *_centre(excess[near], kind[near]))
            for degrees in (0.0, _CORNER)
            if (near := np.abs(angle - degrees) < _STRAIGHT).sum() >= 4 * FEWEST
        ]
        if not groups:
            return [unknown(key, f"{len(excess)} nodes passed without a stop are too few") for key in keys]
        n = sum(group[3] for group in groups)
        part = np.array([group[0] for group in groups])
        mean = np.array([group[1] for group in groups])
        error = np.hypot([group[2] for group in groups], _CLOCK * self.tracks.step)
        turn, turn_error = self.tracks.model.traffic.turn_time, 0.0
        corner = unknown(keys[1], "robots passed nodes only straight on, or only turning", n, "nodes passed")
        if len(groups) == 2:  # noqa: PLR2004 - straight on, and corners
            turn, turn_error = float(mean[1] - mean[0]), float(np.hypot(*error))
            if turn < _SEEN * turn_error and not self.tracks.model.traffic.turn_time:
                turn, turn_error = 0.0, 0.0
            value = short(max(turn, 0.0))
            half = t_quantile(n) * max(turn_error, float(np.hypot(*error)))
            corner = KeyEstimate(keys[1], value, turn, max(turn - half, 0.0), turn + half, n, "nodes passed")
        if len(groups) == 1 and part[0]:  # only corners: times of the node and of the turn cannot be separated
            both, half = float(mean[0]), t_quantile(n) * float(error[0])
            why = "all of them turned: with the time of the turn"
            return [
                KeyEstimate(keys[0], short(max(both - turn, 0.0)), both, 0.0, both + half, n, "nodes passed", why),
                corner,
            ]
        weight = error**-2 / (error**-2).sum()
        if turn_error:
            weight = np.array([1.0, 0.0])
        node = float((weight * (mean - part * turn)).sum())
        half = t_quantile(n) * float(np.sqrt((weight**2 * error**2).sum()))
        low, high = max(node - half, 0.0), max(node, 0.0) + half
        return [KeyEstimate(keys[0], short(max(node, 0.0)), max(node, 0.0), low, high, n, "nodes passed"), corner]

    def _passages(self) -> tuple[Floats, Floats, Ints]:
        """Return the time that each node took beyond the drive, the turn in degrees, and the pair of edges by number.

        From one message before it to one after, but not from the last before and the first after: which these are
        depends on the noise of their positions.
        """
        tracks = self.tracks
        here = np.flatnonzero(self.clear & tracks.driving)
        before, last, first, after = (here[shift : shift - 3 or None] for shift in range(4))
        stops = np.cumsum(tracks.fault | (tracks.action != NOTHING) | ~tracks.joined | ~tracks.driving)
        follows = (tracks.robot[before] == tracks.robot[after]) & (tracks.load[before] == tracks.load[after])
        follows &= (tracks.edge[before] == tracks.edge[last]) & (tracks.edge[first] == tracks.edge[after])
        follows &= (tracks.onto[last] == tracks.node[first]) & (stops[before] == stops[after])
        before, after = before[follows], after[follows]
        rest = tracks.lengths[tracks.edge[before]] - tracks.along[before]
        drive = rest / self._speed_at(before) + tracks.along[after] / self._speed_at(after)
        heading = np.array([tracks.model.floor.headings[edge] for edge in tracks.edges])
        turned = np.degrees(np.abs(np.angle(np.exp(1j * (heading[tracks.edge[after]] - heading[tracks.edge[before]])))))
        excess = tracks.time[after] - tracks.time[before] - drive
        finite = np.isfinite(excess)
        kind = tracks.edge[before] * len(tracks.edges) + tracks.edge[after]
        return excess[finite], turned[finite], kind[finite]

    def _speed_at(self, rows: Ints) -> Floats:
        """Return the speed of the robots in some messages: their own, or the limit of the edge."""
        limits = self.limits.copy()
        for zone, (speed, _, _) in self.slow:
            limits[zone] = speed
        own = np.array([speed for speed, _, _ in self.speeds])
        speeds: Floats = np.minimum(own[self.tracks.load[rows].astype(int)], limits[self.tracks.edge[rows]])
        return speeds


def _steady(way: Floats, time: Floats, edge: Ints, sigma: float) -> tuple[float, float, int]:
    """Return a robust speed, without stretches where robots were held up: mean, half-width of its interval, number."""
    speed = densest(way / time)
    use = np.ones(len(way), bool)
    for _ in range(_ROUNDS):
        off = way - speed * time
        use, _ = undisturbed(off, 1, sigma)
        speed = float(way[use].sum() / time[use].sum())
    n = int(use.sum())
    spread = max(_spread((way - speed * time)[use], edge[use]), sigma * math.sqrt(n))
    return speed, t_quantile(n - 1) * spread / float(time[use].sum()), n


def _centre(excess: Floats, kind: Ints) -> tuple[float, float, int]:
    """Return the centre of most of the excess times, its standard error, and their number; longer ones were held up."""
    centre = densest(excess)
    use = np.ones(len(excess), bool)
    for _ in range(_ROUNDS):
        use, _ = undisturbed(excess - centre, -1)
        centre = float(excess[use].mean())
    n = int(use.sum())
    held_up = centre - float(np.median(excess[use]))  # for less than a message shows
    return centre, math.hypot(_spread(excess[use] - centre, kind[use]) / n, held_up), n


def _spread(off: Floats, kind: Ints) -> float:
    """Return the standard deviation of the sum of residuals; residuals of one kind may have an error in common.

    An edge that is drawn too long shifts all that is measured on it. Of few kinds that does not show.
    """
    apart = float((off**2).sum())
    sums = np.bincount(np.unique(kind, return_inverse=True)[1], off)
    kinds = len(sums)
    together = float((sums**2).sum()) * kinds / max(kinds - 1, 1) if kinds >= FEWEST else 0.0
    return math.sqrt(max(apart, together))
