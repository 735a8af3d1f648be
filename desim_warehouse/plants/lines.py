"""Lanes drawn as lines in maps and drawings without a graph: lines become links, with points where they meet.

A floor is flat, so lines that cross or end on another are joined there. Corners are points; curves become chords that
are at most `CURVE` off, and keep their length. Marks beside a lane belong to its nearest point.

For the readers of DXF and GeoJSON.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Container, Iterable
from dataclasses import dataclass, field
from itertools import pairwise

from desim_warehouse.errors import ModelError
from desim_warehouse.plants.plant import Link, Location, Plant, Waypoint, claim, unique
from desim_warehouse.values.fields import LIMITS

JOIN = 0.05
"""Distance in metres up to which ends of lines are joined to each other, or to another line."""
GAP = 0.5
"""Distance in metres from another line up to which a loose end is doubtful: no robot fits between the two."""
CURVE = 0.25
"""Largest distance of a chord from its curve, in metres."""
NEAR = 2.0
"""Largest distance of a mark from its lane, in metres."""
_MOST_TESTS = 500_000  # pairs of segments to test, a limit of the cost of tangled lines
_CELLS = 50_000  # of the grid in which neighbours are searched
_WINDOW = 64  # points of a line after which a point is kept, a limit of the cost of curves
_FLAT = 1e-12

Spot = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Line:
    """A lane as drawn, in metres; `speed_back` is 0 if the lane is one-way, from its first to its last point."""

    name: str
    points: tuple[Spot, ...]
    speed: float = math.inf
    speed_back: float = math.inf
    position: str = ""


@dataclass(frozen=True, slots=True)
class Mark:
    """A mark beside a lane as drawn; its operations are the names of its layer or block, or its properties."""

    name: str
    at: Spot
    operations: tuple[str, ...] = ()
    position: str = ""


@dataclass(slots=True)
class _Piece:
    """A straight part of a line, with the points (and their positions, from 0 to 1) where others meet it."""

    line: int
    a: Spot
    b: Spot
    cuts: list[tuple[float, Spot]] = field(default_factory=list)


def join(plant: Plant, lines: Iterable[Line], marks: Iterable[Mark]) -> None:
    """Add lines and marks to a plant, as points, links and locations; changes are noted in the plant.

    Raises:
        ModelError: no lines, or too many of them.
    """
    lines = [line for line in lines if len(line.points) > 1]
    if not lines:
        raise ModelError([f"{plant.source}: no lines, expected lanes drawn as lines"])
    if sum(len(line.points) for line in lines) > LIMITS["nodes"][0]:
        raise ModelError([f"{plant.source}: too many points, expected {LIMITS['nodes'][0]:,} at most"])
    floor = _Floor(plant, lines)
    floor.cross()
    spots = floor.place(list(marks))
    floor.doubt_ends(spots)
    _Network(plant, lines, floor.chains(), spots)


class _Floor:
    """The pieces of all lines, in a grid of cells; ends that nearly meet are one spot."""

    def __init__(self, plant: Plant, lines: list[Line]) -> None:
        self.plant = plant
        self.lines = lines
        self.near: dict[tuple[int, int], list[Spot]] = defaultdict(list)
        self.moved: set[int] = set()
        self.pieces: list[_Piece] = []
        for rank, line in enumerate(lines):
            ends = {0, len(line.points) - 1}
            spots = [self.spot(point, rank if at_end in ends else None) for at_end, point in enumerate(line.points)]
            self.pieces += [_Piece(rank, a, b) for a, b in pairwise(spots) if a != b]
        xs = [x for piece in self.pieces for x in (piece.a[0], piece.b[0])] or [0.0]
        ys = [y for piece in self.pieces for y in (piece.a[1], piece.b[1])] or [0.0]
        extent = max(max(xs) - min(xs), max(ys) - min(ys), 1.0)
        total = sum(math.dist(piece.a, piece.b) for piece in self.pieces)
        self.side = max(total / max(len(self.pieces), 1), 2 * total / _CELLS, extent / 2000, 2 * NEAR)
        self.cells: dict[tuple[int, int], list[int]] = defaultdict(list)
        for rank, piece in enumerate(self.pieces):
            for cell in self.cells_of(piece):
                self.cells[cell].append(rank)

    def spot(self, point: Spot, line: int | None = None) -> Spot:
        """Snap a point to an earlier spot within `JOIN` metres, or keep it as a new spot."""
        cell = (math.floor(point[0] / JOIN), math.floor(point[1] / JOIN))
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                for other in self.near.get((cell[0] + i, cell[1] + j), ()):
                    if math.dist(point, other) <= JOIN:
                        if line is not None and other != point:
                            self.moved.add(line)
                        return other
        self.near[cell].append(point)
        return point

    def cells_of(self, piece: _Piece) -> set[tuple[int, int]]:
        """Return the cells through which a piece passes, with a margin."""
        steps = max(1, math.ceil(math.dist(piece.a, piece.b) / self.side * 2))
        stops = [_along(piece, step / steps) for step in range(steps + 1)]
        cells = set()
        for (ax, ay), (bx, by) in pairwise(stops):
            across = range(self.cell(min(ax, bx) - JOIN), self.cell(max(ax, bx) + JOIN) + 1)
            down = range(self.cell(min(ay, by) - JOIN), self.cell(max(ay, by) + JOIN) + 1)
            cells |= {(i, j) for i in across for j in down}
        return cells

    def cell(self, coordinate: float) -> int:
        return math.floor(coordinate / self.side)

    def cross(self) -> None:
        """Cut pieces where they meet."""
        tests = 0
        crossed: set[int] = set()
        for first, piece in enumerate(self.pieces):
            others = {other for cell in self.cells_of(piece) for other in self.cells[cell] if other > first}
            tests += len(others)
            if tests > _MOST_TESTS:
                text = "too many lines beside one another, expected lanes, not hatching or furniture"
                raise ModelError([f"{self.plant.source}: {text}; choose their layer"])
            for other in sorted(others):
                if self.meet(piece, self.pieces[other]):
                    crossed |= {piece.line, self.pieces[other].line}
        names = [self.lines[rank].name for rank in sorted(self.moved)]
        self.plant.note("changed", "line", names, f"ends up to {JOIN:g} m beside another's, so they are joined")
        names = [self.lines[rank].name for rank in sorted(crossed)]
        self.plant.note(
            "changed", "line", names, "where they cross, or one ends on the other, without a point, they get one"
        )

    def meet(self, first: _Piece, other: _Piece) -> bool:
        """Cut two pieces where they meet other than at their ends; return whether any was cut."""
        met = False
        for piece, ends in ((first, (other.a, other.b)), (other, (first.a, first.b))):
            for end in ends:
                part = _part(piece, end)
                if end not in (piece.a, piece.b) and 0 < part < 1 and math.dist(_along(piece, part), end) <= JOIN:
                    piece.cuts.append((part, end))
                    met = True
        if met or {first.a, first.b} & {other.a, other.b}:
            return met
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = first.a, first.b, other.a, other.b
        across = (bx - ax) * (dy - cy) - (by - ay) * (dx - cx)
        if abs(across) <= _FLAT * max(math.dist(first.a, first.b) * math.dist(other.a, other.b), _FLAT):
            return False
        s = ((cx - ax) * (dy - cy) - (cy - ay) * (dx - cx)) / across
        t = ((cx - ax) * (by - ay) - (cy - ay) * (bx - ax)) / across
        if not (0 < s < 1 and 0 < t < 1):
            return False
        spot = self.spot(_along(first, s))
        first.cuts.append((s, spot))
        other.cuts.append((t, spot))
        return True

    def place(self, marks: list[Mark]) -> dict[Spot, list[Mark]]:
        """Assign marks to the nearest spots on lanes, cut the lanes there, and return the marks by spot."""
        placed: dict[Spot, list[Mark]] = defaultdict(list)
        off, away = [], []
        for mark in marks:
            i, j = self.cell(mark.at[0]), self.cell(mark.at[1])
            around = [(i + di, j + dj) for di in (-1, 0, 1) for dj in (-1, 0, 1)]
            best: tuple[float, _Piece, float] | None = None
            for rank in sorted({rank for cell in around for rank in self.cells.get(cell, ())}):
                piece = self.pieces[rank]
                part = min(max(_part(piece, mark.at), 0.0), 1.0)
                far = math.dist(_along(piece, part), mark.at)
                if best is None or far < best[0]:
                    best = (far, piece, part)
            if best is None or best[0] > NEAR:
                away.append(mark)
                continue
            far, piece, part = best
            spot = self.spot(_along(piece, part))
            if spot not in (piece.a, piece.b):
                piece.cuts.append((part, spot))
            placed[spot].append(mark)
            if far > JOIN:
                off.append(mark)
        why = f"drawn up to {NEAR:g} m beside a lane, so it is at the nearest point of it"
        self.plant.note("changed", "place", [mark.name for mark in off], why, [mark.position for mark in off])
        why = f"more than {NEAR:g} m from any lane"
        self.plant.note("left out", "place", [mark.name for mark in away], why, [mark.position for mark in away])
        return placed

    def doubt_ends(self, marked: Container[Spot]) -> None:
        """Note lines whose end stops short of another line or of their other end, unless it has a mark.

        Lines of up to twice that distance are left alone, as they are near what they begin at.
        """
        meeting = Counter(spot for piece in self.pieces for spot in (piece.a, piece.b, *(cut for _, cut in piece.cuts)))
        loose = []
        for rank, line in enumerate(self.lines):
            length = sum(math.dist(a, b) for a, b in pairwise(line.points))
            ends = self.spot(line.points[0]), self.spot(line.points[-1])
            alone = [end for end in ends if meeting[end] == 1 and end not in marked]
            if length > 2 * GAP and alone and (math.dist(*ends) <= GAP or any(self.misses(end, rank) for end in alone)):
                loose.append(line)
        why = (
            f"ends up to {GAP:g} m from another end or line without touching it, so no robot goes from one to the other"
        )
        self.plant.note("doubtful", "line", [line.name for line in loose], why, [line.position for line in loose])

    def misses(self, end: Spot, line: int) -> bool:
        """Return whether an end of a line is near a piece of another line."""
        i, j = self.cell(end[0]), self.cell(end[1])
        around = [(i + di, j + dj) for di in (-1, 0, 1) for dj in (-1, 0, 1)]
        others = (self.pieces[rank] for cell in around for rank in self.cells.get(cell, ()))
        return any(other.line != line and _off(end, other.a, other.b) <= GAP for other in others)

    def chains(self) -> list[list[Spot]]:
        """Return the spots along every line, with the spots at which it is cut."""
        chains: list[list[Spot]] = [[] for _ in self.lines]
        for piece in self.pieces:
            chain = chains[piece.line]
            for spot in [piece.a, *(spot for _, spot in sorted(piece.cuts)), piece.b]:
                if not chain or chain[-1] != spot:
                    chain.append(spot)
        return chains


class _Network:
    """Maker of points, links and locations from the spots along lines and the marks at them."""

    def __init__(
        self, plant: Plant, lines: list[Line], chains: list[list[Spot]], marks: dict[Spot, list[Mark]]
    ) -> None:
        self.plant = plant
        self.marks = marks
        self.meeting: Counter[Spot] = Counter()
        for chain in chains:
            self.meeting.update(chain[:-1])
            self.meeting.update(chain[1:])
        self.named: dict[Spot, str] = {}
        self.taken: set[str] = set()
        for spot, here in marks.items():
            self.name(spot, here[0].name)
        curved = [line.name for line, chain in zip(lines, chains, strict=True) if chain and self.link(line, chain)]
        short = [line.name for line, chain in zip(lines, chains, strict=True) if not chain]
        why = f"a curve, driven as chords up to {CURVE:g} m beside it; its length counts"
        plant.note("changed", "line", list(dict.fromkeys(curved)), why)
        plant.note("left out", "line", short, "no longer than what is joined at the ends of lines")
        self.locations()

    def name(self, spot: Spot, wanted: str) -> str:
        """Give a spot a unique name."""
        name = self.named[spot] = claim(wanted, self.taken)
        return name

    def point(self, spot: Spot) -> str:
        """Return the name of the point at a spot; add the point if it is new."""
        name = self.named.get(spot) or self.name(spot, f"p{len(self.plant.points) + 1}")
        if name not in self.plant.points:
            self.plant.points[name] = Waypoint(name, *spot)
        return name

    def link(self, line: Line, chain: list[Spot]) -> bool:
        """Add links along a line between junctions, marks and bends; return whether a curve was replaced by chords."""
        kept = {0, len(chain) - 1, *range(0, len(chain), _WINDOW)}
        kept |= {rank for rank, spot in enumerate(chain) if self.meeting[spot] != 2 or spot in self.marks}  # noqa: PLR2004
        curved = False
        for begin, end in pairwise(sorted(kept)):
            for first, last in pairwise(_corners(chain, begin, end)):
                length = math.fsum(math.dist(*pair) for pair in pairwise(chain[first : last + 1]))
                curved = curved or last - first > 1
                ends = self.point(chain[first]), self.point(chain[last])
                link = Link(">".join(ends), *ends, length, line.speed, line.speed_back, position=line.position)
                self.plant.links.append(link)
        return curved

    def locations(self) -> None:
        """Add the marks with operations to the plant, as locations."""
        locations: dict[str, Location] = {}
        for spot, here in self.marks.items():
            for mark in here:
                if mark.operations:
                    name = unique(mark.name, locations)
                    locations[name] = Location(name, {self.point(spot): mark.operations}, mark.position)
        self.plant.locations += locations.values()


def _part(piece: _Piece, spot: Spot) -> float:
    """Return the fraction of the way along a piece, from 0 to 1 inside it, at which it is nearest to a point."""
    (ax, ay), (bx, by) = piece.a, piece.b
    return ((spot[0] - ax) * (bx - ax) + (spot[1] - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)


def _along(piece: _Piece, part: float) -> Spot:
    (ax, ay), (bx, by) = piece.a, piece.b
    return ax + part * (bx - ax), ay + part * (by - ay)


def _corners(chain: list[Spot], begin: int, end: int) -> list[int]:
    """Return the ranks from begin to end to keep, so that other spots are at most `CURVE` m off (Douglas-Peucker)."""
    kept, rest = {begin, end}, [(begin, end)]
    while rest:
        a, b = rest.pop()
        far, worst = 0.0, a
        for rank in range(a + 1, b):
            off = _off(chain[rank], chain[a], chain[b])
            if off > far:
                far, worst = off, rank
        if far > CURVE:
            kept.add(worst)
            rest += [(a, worst), (worst, b)]
    return sorted(kept)


def _off(spot: Spot, a: Spot, b: Spot) -> float:
    if a == b:
        return math.dist(spot, a)
    piece = _Piece(0, a, b)
    return math.dist(_along(piece, min(max(_part(piece, spot), 0.0), 1.0)), spot)
