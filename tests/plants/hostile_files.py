"""Files that would lead a careless reader astray, of all formats: `python -m tests.plants.hostile_files FOLDER`.

Writes them to the folder, reads each with limits on memory and processor time, and prints a line of JSON for each: its
name, the seconds it took, and the problems with it, or none if it was read.
"""

import json
import random
import resource
import sys
import time
from pathlib import Path

from benchmarks.memory import peak

BOMB = '<!DOCTYPE {0} [<!ENTITY a "aaaaaaaaaa">{1}]>\n<{0} version="7.0.0" name="&h;"/>'
LAUGHS = "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefg", "bcdefgh", strict=True))
OUTSIDE = '<!DOCTYPE {0} [<!ENTITY f SYSTEM "file:///etc/passwd">]>\n<{0} version="7.0.0" name="&f;"/>'
GRAPH = '<graphml><key id="x" for="node" attr.name="x"/>{}<graph edgedefault="directed">{}</graph></graphml>'
YAML_BOMB = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{b}: &{b} [{', '.join([f'*{a}'] * 9)}]\n" for a, b in zip("abcdefgh", "bcdefghi", strict=True)
)
EDGES = "from,to\nA,B\nB,A\n"


def line(spots, **properties):
    return {"type": "Feature", "properties": properties, "geometry": {"type": "LineString", "coordinates": spots}}


def collection(*features):
    return json.dumps({"type": "FeatureCollection", "features": features})


def drawing(*entities):
    """A DXF file of entities, each a list of group codes and values."""
    pairs = [(0, "SECTION"), (2, "ENTITIES"), *(pair for each in entities for pair in each), (0, "ENDSEC"), (0, "EOF")]
    return "".join(f"{code}\n{value}\n" for code, value in pairs)


def files():
    """Name and content of every file; beside a table of nodes stands one of edges."""
    yield from documents()
    yield from numbers()
    yield from tables()
    yield from lines()
    yield from drawings()
    yield from noise()


def documents():
    """XML, JSON and YAML."""
    for suffix, tag in (("xml", "model"), ("graphml", "graphml")):
        yield f"bomb.{suffix}", BOMB.format(tag, LAUGHS)
        yield f"outside.{suffix}", OUTSIDE.format(tag)
        yield f"deep.{suffix}", f"<{tag}>" + "<graph><node id='a'>" * 200_000
        yield f"attributes.{suffix}", f"<{tag} " + " ".join(f'a{i}=""' for i in range(200_000)) + "/>"
        yield f"lines.{suffix}", f"<{tag}>" + "<!---->\n" * 400_000 + f"</{tag}>"
    yield "flat.graphml", "<graphml>" + "<a/>" * 1_010_000 + "</graphml>"
    yield "keys.graphml", GRAPH.format("<key/>", "")
    yield "data.graphml", GRAPH.format("", '<node id="a">' + '<data key="x">1</data>' * 300_000 + "</node>")
    yield "unknown.graphml", GRAPH.format("", '<node id="a"><data key="y">1</data></node>')
    yield (
        "loops.graphml",
        GRAPH.format("", "".join(f'<node id="{i}"><data key="x">{i}</data></node>' for i in range(9))),
    )
    yield "deep.lif.json", '{"layouts":' + "[" * 2_000_000
    yield "numbers.lif.json", '{"metaInformation": {}, "layouts": [' + "1," * 2_000_000 + "1]}"
    yield "bomb.building.yaml", YAML_BOMB
    yield "deep.building.yaml", "levels: " + "[" * 100_000


def numbers():
    """What is no number, or none of a plant."""
    for value in ("NaN", "inf", "1e308", "-1e400", "9" * 5000, "0x10", "1_000", "\u0661"):
        yield f"{value[:9]}.graphml", GRAPH.format("", f'<node id="a"><data key="x">{value}</data></node>')
        yield f"{value[:9]}/nodes.csv", f"name,x,y\nA,{value},0\nB,1,1\n", EDGES
        yield f"{value[:9]}/lengths/nodes.csv", "name,x,y\nA,0,0\nB,1,1\n", f"from,to,length\nA,B,{value}\n"
        yield f"{value[:9]}.geojson", collection(line([[0, 0], [1, 1]])).replace("[1, 1]", f"[{value}, 1]")
        yield f"{value[:9]}.dxf", drawing([(0, "LINE"), (8, "0"), (10, value), (20, 0), (11, 1), (21, 1)])
        yield f"{value[:9]} wide.dxf", drawing([(0, "CIRCLE"), (8, "0"), (10, 0), (20, 0), (40, value)])


def tables():
    yield "columns/nodes.csv", ",".join(f"c{i}" for i in range(1_000_000)) + "\n", EDGES
    yield "commas/nodes.csv", "name,x,y\n" + "," * 9_000_000, EDGES
    yield "brackets/nodes.csv", "(" * 130_000 + ",x,y\n", EDGES
    yield "quote/nodes.csv", 'name,x,y\n"' + "A,0,0\n" * 1_000_000, EDGES
    yield "cell/nodes.csv", "name,x,y\n" + "A" * 5_000_000 + ",0,0\n", EDGES
    yield "rows/nodes.csv", "name,x,y\n" + "".join(f"n{i},{i},0\n" for i in range(401_000)), EDGES
    yield "same/nodes.csv", "name,x,y\n" + "".join(f"n{i},0,0\n" for i in range(90_000)), EDGES
    yield "nul/nodes.csv", "name,x,y\nA\0,0,0\n", EDGES
    yield "blank/nodes.csv", "\n" * 1_000_000, EDGES
    yield "parallel/nodes.csv", "name,x,y\nA,0,0\nB,1,1\n", "from,to\n" + "A,B\n" * 100_000


def lines():
    yield "deep.geojson", "[" * 5_000_000
    yield "deeper.geojson", '{"type":"FeatureCollection","features":' + "[" * 100_000 + "]" * 100_000 + "}"
    yield "twice.geojson", '{"type":"FeatureCollection","type":"x","features":[]}'
    yield "hatching.geojson", collection(*(line([[i / 100, 0], [i / 100, 90]]) for i in range(2_500)))
    zigzag = [[i / 100, 30 * (i % 2)] for i in range(20_000)]
    yield "zigzag.geojson", collection(line(zigzag))
    yield "tiny.geojson", collection(*(line([[0, 0], [1e-9, 1e-9]]) for _ in range(5_000)))
    yield "spread.geojson", collection(line([[0, 0], [1e12, 1e12]]), *(line([[i, 0], [i, 1]]) for i in range(1500)))
    yield "one spot.geojson", collection(*(line([[i % 7 / 100, 0], [i, 50]]) for i in range(1, 2500)))


def drawings():
    yield "codes.dxf", "x\ny\n" * 100_000
    yield "odd.dxf", drawing([(0, "LINE"), (8, "0"), (10, "a lot")])
    yield (
        "spline.dxf",
        drawing([(0, "SPLINE"), (8, "0"), (71, 3), (72, 9), (73, 5), *[(40, 0)] * 9, *[(10, 1e12), (20, -1e12)] * 5]),
    )
    yield "polyline.dxf", drawing([(0, "LWPOLYLINE"), (8, "0"), (90, 10**9), (10, 0), (20, 0)])
    yield "bulges.dxf", drawing([(0, "LWPOLYLINE"), (8, "0"), (90, 2), *[(10, 0), (20, 0), (42, 1e300)] * 500])
    yield (
        "names.dxf",
        drawing(*([(0, "LINE"), (8, f"layer {i}"), (10, i), (20, 0), (11, i), (21, 9)] for i in range(4_000))),
    )


def noise():
    draw = random.Random(11)
    for suffix in ("xml", "graphml", "geojson", "dxf", "lif.json", "building.yaml"):
        yield f"noise.{suffix}", draw.randbytes(100_000)
        yield f"large.{suffix}", " " * 10_000_001
        yield f"empty.{suffix}", ""
        yield f"mark.{suffix}", "\ufeff"
    yield "noise/nodes.csv", draw.randbytes(100_000), EDGES
    yield "empty/nodes.csv", "", EDGES


def main(folder):
    from desim_warehouse.errors import ModelError
    from desim_warehouse.plants import import_layout

    resource.setrlimit(resource.RLIMIT_AS, (3 * 2**30, 3 * 2**30))
    for name, content, *edges in files():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        for text in edges:
            path.with_name("edges.csv").write_text(text)
        begin = time.process_time()
        try:
            assert import_layout(path).model is not None
            problems = None
        except ModelError as error:
            problems = error.problems
        path.unlink()
        sys.stdout.write(json.dumps([name, time.process_time() - begin, peak(), problems]) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
