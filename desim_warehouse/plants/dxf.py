"""DXF drawings for `desim import`: lanes are lines of some layers, marks are blocks and points by their names.

- This needs ezdxf (the extra `dxf`) and a drawing saved as DXF, not DWG. Units are those of the drawing ($INSUNITS), y
is upwards. Layers that are off or frozen are left out.
- Lines, polylines, arcs, circles, ellipses and splines of the model space are read. Those inside inserted blocks, and
points there, are read only if they are on a layer of lanes, or if nothing else has lines. Without `--lanes`, layers of
lanes are those with lane, path, route, track, aisle or AGV in their names.
- Lines on a layer called one-way lead from their first point to the last; all others lead both ways.
- The names of blocks or layers tell the kind of places: CHARGER, `pick`, `drop`, or the words of `--operation`.
"""

from __future__ import annotations

import io
import logging
import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from desim_warehouse.errors import ModelError, did_you_mean, got, reason, spoken
from desim_warehouse.plants.lines import CURVE, Line, Mark, Spot, join
from desim_warehouse.plants.plant import Plant
from desim_warehouse.values.fields import LIMITS

EXPECTED = "a drawing (DXF)"
_LINES = {"LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE"}
_LANES = re.compile(r"lane|path|route|track|aisle|highway|agv|amr|fahrweg|gasse", re.IGNORECASE)
_ONE_WAY = re.compile(r"one[ _-]?way|einbahn", re.IGNORECASE)
_WIDE = 5000.0  # units: a wider drawing that names no unit is in mm, others in m
_BROKEN = 50  # damaged entities to leave out at most: each costs another reading
_FAULTS, _LONGEST = 1000, 100  # faults to name, and letters of each, at most
_FINE = 1000  # parts of a curve's size: no chord is finer


def looks(path: Path, start: bytes) -> bool:
    """Return whether a file may be a drawing, by its ending or its first bytes."""
    return path.suffix.lower() in {".dxf", ".dwg"} or start.startswith(b"AutoCAD Binary DXF")


def read(path: Path, content: bytes, *, lanes: str | tuple[str, ...] = ()) -> Plant:
    """Read a plant from a DXF drawing.

    Args:
        path: the file.
        content: its bytes.
        lanes: layers whose lines are lanes; default: layers with such names, or the only layer with lines.

    Raises:
        ModelError: the file cannot be read, or it is unclear which lines are lanes.
    """
    plant = Plant(path.stem, f"{path.name} (DXF)")
    document = _document(path, content, plant)
    try:
        asked = (lanes,) if isinstance(lanes, str) else lanes
        entities = [(layer, entity) for layer, entity in _visible(document, plant) if _is_flat(entity)]
        entities += _inside(path, entities, asked)
        layers = Counter(layer for layer, entity in entities if entity.dxftype() in _LINES)
        chosen = _chosen(path, layers, asked)
        drawn = [entity for layer, entity in entities if layer in chosen and entity.dxftype() in _LINES]
        scale = _scale(document, plant, drawn)
        join(plant, list(_lines(path, plant, entities, chosen, scale)), _marks(path, entities, scale))
    except ModelError:
        raise
    except Exception as error:  # noqa: BLE001 - whatever a damaged drawing makes the library raise
        raise ModelError([f"{path}: damaged ({type(error).__name__}: {reason(error)}), expected {EXPECTED}"]) from None
    others = [layer for layer in layers if layer not in chosen]
    plant.note("left out", "layer", others, "its lines are no lanes; choose layers with lanes (--lanes)")
    return plant


def _document(path: Path, content: bytes, plant: Plant) -> Any:
    """Read the drawing with ezdxf, even if it is slightly damaged; repairs are noted in the plant."""
    if content.startswith((b"AC10", b"AutoCAD Binary DXF")):
        raise ModelError([f"{path}: a binary drawing (DWG or binary DXF), expected it saved as DXF in text (ASCII)"])
    try:
        from ezdxf import recover
    except ImportError:
        cure = "install it: pip install 'desim-warehouse[dxf]'"
        raise ModelError([f"{path}: a DXF drawing, which needs the package ezdxf; {cure}"]) from None
    heard = _Faults()
    logger = logging.getLogger("ezdxf")
    logger.addHandler(heard)
    broken: list[str] = []
    try:
        while True:
            try:
                document, auditor = recover.read(io.BytesIO(content))
                break
            except Exception as error:  # noqa: BLE001 - whatever a damaged drawing makes the library raise
                problem = " ".join(str(error).split())[:100] or type(error).__name__
                fewer = _without(content, problem) if len(broken) < _BROKEN else content
                if len(fewer) == len(content):
                    raise ModelError([f"{path}: not a drawing ({problem}), expected {EXPECTED}"]) from None
                broken.append(problem)
                content = fewer
    finally:
        logger.removeHandler(heard)
    plant.note("left out", "entity", broken, "damaged, and the rest can be read without it")
    heard.faults += [entry.message for entry in (*auditor.errors, *auditor.fixes)]
    plant.note(
        "changed",
        "fault",
        dict.fromkeys(fault[:_LONGEST] for fault in heard.faults),
        "of the drawing, repaired as it is read",
    )
    return document


def _without(content: bytes, message: str) -> bytes:
    """Return the drawing without the entity `KIND(#HANDLE)` that a message of ezdxf blames; unchanged without one."""
    named = re.search(r"\b([A-Z]+)\(#([0-9A-F]+)\)", message)
    if named is None:
        return content
    begin = rf"(?m)^[ \t]*0\r?\n{named[1]}\r?\n[ \t]*5\r?\n{named[2]}\r?\n"
    tags = r"(?:[ \t]*[1-9]\d*\r?\n[^\n]*\n)*"
    return re.sub((begin + tags).encode(), b"", content, count=1)


class _Faults(logging.Handler):
    """The faults that ezdxf reports while it reads a drawing."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.faults: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        if len(self.faults) < _FAULTS:
            self.faults.append(record.getMessage())


def _is_flat(entity: Any) -> bool:
    """Return whether an entity can be a lane or a mark, as polylines also represent meshes."""
    return not (entity.dxftype() == "POLYLINE" and entity.get_mode() in {"AcDbPolygonMesh", "AcDbPolyFaceMesh"})


def _visible(document: Any, plant: Plant) -> Iterator[tuple[str, Any]]:
    """Yield the entities of the model space with their layers, except for layers that are off or frozen."""
    hidden: dict[str, None] = {}
    off = {layer.dxf.name.casefold() for layer in document.layers if layer.is_off() or layer.is_frozen()}
    for entity in document.modelspace():
        layer = str(entity.dxf.get("layer", "0"))
        if layer.casefold() in off:
            hidden[layer] = None
        else:
            yield layer, entity
    plant.note("left out", "layer", list(hidden), "off or frozen")


def _inside(path: Path, entities: list[tuple[str, Any]], layers: tuple[str, ...]) -> list[tuple[str, Any]]:
    """Return the lines and points inside inserted blocks with lanes, at any depth, each with its layer."""
    from ezdxf.disassemble import recursive_decompose

    inserts = [entity for _, entity in entities if entity.dxftype() == "INSERT"]
    sizes: dict[str, int] = {}
    if sum(_drawn(insert, sizes) for insert in inserts) > LIMITS["nodes"][0]:
        raise ModelError([f"{path}: too many entities in blocks, expected {LIMITS['nodes'][0]:,} at most"])
    asked = {layer.casefold() for layer in layers}
    alone = not any(entity.dxftype() in _LINES for _, entity in entities)
    inside = []
    for layer, insert in entities:
        if insert.dxftype() != "INSERT":
            continue
        parts = []
        for part in recursive_decompose([insert]):
            own = str(part.dxf.get("layer", "0"))
            parts.append((layer if own == "0" else own, part))
        lines = {own for own, part in parts if part.dxftype() in _LINES and _is_flat(part)}
        if any(alone or own.casefold() in asked or _LANES.search(own) for own in lines):
            inside += [(own, part) for own, part in parts if part.dxftype() in _LINES | {"POINT"} and _is_flat(part)]
    return inside


def _drawn(insert: Any, sizes: dict[str, int]) -> int:
    """Return the number of entities in an inserted block taken apart; `sizes`: numbers of blocks counted before."""
    block = insert.block()
    name = str(insert.dxf.get("name", ""))
    if block is not None and name not in sizes:
        sizes[name] = 1  # for a block inside itself, which ezdxf refuses
        sizes[name] = sum(_drawn(part, sizes) if part.dxftype() == "INSERT" else 1 for part in block)
    return int(insert.mcount) * sizes.get(name, 1)


def _chosen(path: Path, layers: Counter[str], asked: tuple[str, ...]) -> set[str]:
    """Return the layers whose lines are lanes.

    Raises:
        ModelError: an unknown layer, no lines, or no way to tell which lines are lanes.
    """
    counts = [f"{layer} ({number:,} lines)" for layer, number in layers.most_common(12)]
    have = spoken(counts) if counts else "none"
    chosen = set()
    for name in asked:
        same = {layer for layer in layers if layer.casefold() == name.casefold()}
        if not same:
            text = f"{path}: no lines on a layer {got(name)}, expected one of {have}"
            raise ModelError([text + did_you_mean(name, layers)])
        chosen |= same
    if not layers:
        raise ModelError([f"{path}: no lines in the model space, nor in its blocks, expected lanes drawn as lines"])
    chosen = chosen or {layer for layer in layers if _LANES.search(layer)} or {*layers}
    if not asked and chosen == {*layers} and len(layers) > 1 and not all(map(_LANES.search, layers)):
        raise ModelError([f"{path}: which lines are lanes? Choose layers with --lanes, of {have}"])
    return chosen


def _scale(document: Any, plant: Plant, entities: list[Any]) -> float:
    """Return the number of metres in a unit of the drawing."""
    from ezdxf import units

    if document.units:
        return float(units.conversion_factor(document.units, units.M))
    spots = [spot for entity in entities for spot in _ends(entity)]
    wide = max((max(axis) - min(axis) for axis in zip(*spots, strict=True)), default=0.0)
    unit, scale = ("mm", 0.001) if wide > _WIDE else ("m", 1.0)
    plant.assume("units.length", f"m; the drawing does not name its unit ($INSUNITS), taken for {unit}")
    return scale


def _ends(entity: Any) -> Iterable[Spot]:
    from ezdxf import path as paths

    return [(corner.x, corner.y) for corner in paths.make_path(entity).control_vertices()]


def _lines(path: Path, plant: Plant, entities: list[tuple[str, Any]], chosen: set[str], scale: float) -> Iterator[Line]:
    """Yield the lines of the chosen layers, in metres."""
    from ezdxf import path as paths

    others: Counter[str] = Counter()
    for rank, (layer, entity) in enumerate(entities):
        if layer not in chosen or entity.dxftype() in {"INSERT", "POINT"}:
            continue
        if entity.dxftype() not in _LINES:
            others[f"{entity.dxftype()} on {layer}"] += 1
            continue
        position = f"entity {entity.dxf.get('handle', rank)}"
        drawn = paths.make_path(entity)
        corners = [_spot(path, position, corner, scale) for corner in drawn.control_vertices()]
        if drawn.has_curves:
            size = max((math.dist(corners[0], corner) for corner in corners), default=0.0)
            chord = max(CURVE / 4, size / _FINE) / scale
            corners = [_spot(path, position, corner, scale) for corner in drawn.flattening(chord, segments=4)]
        name = f"{layer} {entity.dxf.get('handle', rank)}"
        yield Line(name, tuple(corners), speed_back=0.0 if _ONE_WAY.search(layer) else math.inf, position=position)
    names = [f"{number} {kind}" for kind, number in others.items()]
    plant.note("left out", "kind of entity", names, "on a layer of lanes, but no line")


def _marks(path: Path, entities: list[tuple[str, Any]], scale: float) -> list[Mark]:
    """Return blocks and points as marks, with the names of their blocks and layers as operations."""
    marks, numbers = [], Counter[str]()
    for rank, (layer, entity) in enumerate(entities):
        if entity.dxftype() not in {"INSERT", "POINT"}:
            continue
        position = f"entity {entity.dxf.get('handle', rank)}"
        block = str(entity.dxf.name) if entity.dxftype() == "INSERT" else ""
        spot = _spot(path, position, entity.dxf.insert if block else entity.dxf.location, scale)
        texts = [str(item.dxf.text).strip() for item in entity.attribs] if block else []
        kind = block if block and not block.startswith("*") else layer
        numbers[kind] += 1
        name = next(filter(None, texts), f"{kind} {numbers[kind]}")
        marks.append(Mark(name, spot, tuple(dict.fromkeys(filter(None, (kind, layer)))), position))
    return marks


def _spot(path: Path, position: str, corner: Any, scale: float) -> Spot:
    """Return a point of the drawing in metres, y downwards, to a tenth of a millimetre."""
    if not max(abs(corner.x), abs(corner.y)) * scale <= LIMITS["number"][0]:
        raise ModelError(
            [f"{path}: {position}: beyond any plant (got {got([corner.x, corner.y])}), expected coordinates"]
        )
    return round(corner.x * scale, 4) + 0.0, round(-corner.y * scale, 4) + 0.0
