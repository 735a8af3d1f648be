"""A small plant in every format that can be read, drawn for these tests.

A one-way loop A-B-C-D of 10 by 8 m; two-way spurs to a packing table, 4 m from C, and to a charger, 3 m from D. Robots
load at B and unload at the table.
"""

import json
import math
import shutil
from itertools import pairwise
from pathlib import Path

import pytest

from tests.plants import drawn_lif, grids

HERE = Path(__file__).parent

NODES = """\
Name;X [m];Y [m];Role;Station;Remark
A;0;0;;;
B;10;0;load;rack;shelf 7
C;10;8;;;
D;0;8;;;
pack;14,0;8;unload;table 1;
plug;-3;8;charge + park;;
"""
EDGES = """\
From;To;Length;Max speed [mm/s];Two-way
A;B;;1000;
B;C;9,5;1000;no
C;D;;500;
D;A;;;
C;pack;4;;yes
plug;D;;;yes
"""


def tables(folder):
    """Two tables, as a spreadsheet in much of Europe writes them."""
    (folder / "nodes.csv").write_text(NODES, encoding="utf-8-sig")
    (folder / "edges.csv").write_text(EDGES, encoding="utf-8-sig")
    return folder / "nodes.csv"


GRAPHML = """\
<?xml version="1.0" encoding="UTF-8"?>
<graphml xmlns="http://graphml.graphdrawing.org/xmlns">
  <key id="d0" for="node" attr.name="x" attr.type="double"/>
  <key id="d1" for="node" attr.name="y" attr.type="double"/>
  <key id="d2" for="node" attr.name="role" attr.type="string"/>
  <key id="d3" for="node" attr.name="station" attr.type="string"/>
  <key id="d4" for="edge" attr.name="length" attr.type="double"/>
  <key id="d5" for="edge" attr.name="speed" attr.type="double"><default>1</default></key>
  <key id="d6" for="node" attr.name="colour" attr.type="string"/>
  <graph id="yard" edgedefault="directed">
    <node id="A"><data key="d0">0</data><data key="d1">0</data></node>
    <node id="B"><data key="d0">10</data><data key="d1">0</data><data key="d2">load</data>
      <data key="d6">red</data></node>
    <node id="C"><data key="d0">10</data><data key="d1">8</data></node>
    <node id="D"><data key="d0">0</data><data key="d1">8</data></node>
    <node id="pack"><data key="d0">14</data><data key="d1">8</data><data key="d2">unload</data>
      <data key="d3">table 1</data></node>
    <node id="plug"><data key="d0">-3</data><data key="d1">8</data><data key="d2">charge</data></node>
    <edge source="A" target="B"/>
    <edge source="B" target="C"><data key="d4">9.5</data></edge>
    <edge source="C" target="D"><data key="d5">0.5</data></edge>
    <edge source="D" target="A"/>
    <edge source="C" target="pack" directed="false"/>
    <edge source="D" target="plug"/>
    <edge source="plug" target="D"/>
  </graph>
</graphml>
"""


def graphml(folder):
    path = folder / "yard.graphml"
    path.write_text(GRAPHML)
    return path


LOOP = [[0, 0], [10, 0], [10, -8], [0, -8], [0, 0]]
SPUR, BRANCH = [[10, -8], [14, -8]], [[0, -8], [-3, -8]]
PLACES = {"B": ([10, 0], "load"), "table 1": ([14, -8.5], "unload"), "plug": ([-3, -8], "charge")}


def features(to=lambda at: at):
    """The plant as lines, with another kind of coordinates perhaps; y is upwards."""
    lanes = [(LOOP, {"oneway": "yes", "speed": 1, "layer": "lanes"}), (SPUR, {"layer": "lanes"}), (BRANCH, None)]
    lines = [
        {
            "type": "Feature",
            "properties": properties,
            "geometry": {"type": "LineString", "coordinates": [to(at) for at in line]},
        }
        for line, properties in lanes
    ]
    points = [
        {
            "type": "Feature",
            "properties": {"name": name, "role": role},
            "geometry": {"type": "Point", "coordinates": to(at)},
        }
        for name, (at, role) in PLACES.items()
    ]
    return {"type": "FeatureCollection", "features": [*lines, *points]}


def excel(folder):
    """The two tables as sheets of a workbook."""
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, the extra excel, is not installed")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, text in (("Nodes", NODES), ("Edges", EDGES)):
        sheet = book.create_sheet(name)
        for line in text.splitlines():
            sheet.append([_as_number(cell.replace(",", ".")) for cell in line.split(";")])
    book.save(folder / "yard.xlsx")
    return folder / "yard.xlsx"


def _as_number(cell):
    try:
        return float(cell)
    except ValueError:
        return cell or None


def node_link(folder):
    """The loop with its spurs as `networkx.node_link_data` writes it, with lengths that are called weight."""
    spots = [*LOOP[:4], SPUR[1], BRANCH[1]]
    work = {1: "load", 4: "unload", 5: "charge"}
    nodes = [
        {"id": rank, "x": at[0], "y": at[1], **({"role": work[rank]} if rank in work else {})}
        for rank, at in enumerate(spots)
    ]
    ends = [(0, 1), (1, 2), (2, 3), (3, 0), (2, 4), (4, 2), (3, 5), (5, 3)]
    links = [{"source": a, "target": b, "weight": math.dist(spots[a], spots[b])} for a, b in ends]
    path = folder / "yard.json"
    path.write_text(json.dumps({"directed": True, "multigraph": False, "graph": {}, "nodes": nodes, "links": links}))
    return path


def degrees(at):
    """Near Graz, 47 degrees north."""
    radius = 6_371_008.8
    return [15.44 + math.degrees(at[0] / radius / math.cos(math.radians(47.07))), 47.07 + math.degrees(at[1] / radius)]


def geojson(folder, to=lambda at: at):
    path = folder / "yard.geojson"
    path.write_text(json.dumps(features(to)))
    return path


def dxf(folder, unit=4, scale=1000):
    """A drawing in mm."""
    ezdxf = pytest.importorskip("ezdxf", reason="ezdxf, the extra dxf, is not installed")
    document = ezdxf.new(units=unit)
    space = document.modelspace()

    def line(layer, *spots):
        if layer not in document.layers:
            document.layers.add(layer)
        for a, b in pairwise(spots):
            space.add_line([v * scale for v in a], [v * scale for v in b], dxfattribs={"layer": layer})

    line("Lanes one-way", *LOOP)
    line("Lanes", *SPUR)
    line("Lanes", *BRANCH)
    line("Walls", [-5, 2], [16, 2], [16, -10], [-5, -10])
    block = document.blocks.new("CHARGER")
    block.add_circle((0, 0), 300)
    space.add_blockref("CHARGER", (-3 * scale, -8 * scale), dxfattribs={"layer": "equipment"})
    space.add_point((10 * scale, 0), dxfattribs={"layer": "pick"})
    space.add_point((14 * scale, -8.5 * scale), dxfattribs={"layer": "drop"})
    document.saveas(folder / "yard.dxf")
    return folder / "yard.dxf"


def opentcs(folder):
    return Path(shutil.copy(HERE / "yard.xml", folder))


def lif(folder):
    return drawn_lif.write(folder / "dock.lif.json", drawn_lif.dock())


def rmf(folder):
    return Path(shutil.copy(HERE / "clinic.building.yaml", folder))


def rmf_site(folder):
    """The loop with its spurs, as the site editor writes it."""
    anchors = {"1": LOOP[0], "2": LOOP[1], "3": LOOP[2], "4": LOOP[3], "5": SPUR[1], "6": BRANCH[1]}
    lanes = {str(7 + rank): {"anchors": [1 + rank, 1 + (rank + 1) % 4], "reverse": "Disable"} for rank in range(4)}
    lanes |= {"11": {"anchors": [3, 5]}, "12": {"anchors": [4, 6], "reverse": "Same"}}
    places = {"13": {"anchor": 2, "name": "pick", "tags": []}, "14": {"anchor": 5, "name": "drop", "tags": []}}
    places["15"] = {"anchor": 6, "name": "plug", "tags": ["Charger", "ParkingSpot"]}
    level = {"properties": {"name": "L1"}, "anchors": {key: {"Translate2D": at} for key, at in anchors.items()}}
    guided = {"graphs": {"20": {"name": "carts"}}, "ranking": [20], "lanes": lanes, "locations": places}
    site = {"format_version": "0.1", "anchors": {}, "levels": {"0": level}, "navigation": {"guided": guided}}
    path = folder / "yard.site.json"
    path.write_text(json.dumps(site))
    return path


def movingai(folder):
    return grids.written(folder, "yard.map", grids.MAP)


def kiva(folder):
    return grids.written(folder, "small.map", grids.KIVA)


def ggo(folder):
    return grids.written(folder, "shelves.json", grids.GGO)


def lorr(folder):
    return grids.problem(folder)


def rhcr(folder):
    return grids.written(folder, "round.grid", grids.ROUND)


_ALL = (tables, excel, graphml, node_link, geojson, dxf, opentcs, lif, rmf, rmf_site, movingai, kiva, ggo, lorr, rhcr)
DRAWN = {one.__name__: one for one in _ALL}
"""What writes a small plant into a folder and gives its path, for every format that can be read."""
