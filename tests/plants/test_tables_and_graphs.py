"""Tables of nodes and edges, graphs of networkx and GraphML: a small plant, worked out by hand."""

import networkx as nx
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.layout import build
from desim_warehouse.plants import import_layout
from tests.plants.damage import one_message
from tests.plants.drawings import EDGES, GRAPHML, NODES, excel, graphml, tables


def lanes(model):
    return {
        (edge.source, edge.target): (edge.length, edge.speed, edge.two_way, edge.side_by_side)
        for edge in model.layout.edges
    }


def test_a_spreadsheet_with_semicolons_units_and_decimal_commas(tmp_path):
    made = import_layout(tables(tmp_path))
    model = made.model
    assert dict(model.layout.nodes) == {
        "A": (0, 0), "B": (10, 0), "C": (10, 8), "D": (0, 8), "pack": (14, 8), "plug": (-3, 8)
    }  # fmt: skip
    assert lanes(model) == {
        ("A", "B"): (None, 1, False, False),
        ("B", "C"): (9.5, 1, False, False),
        ("C", "D"): (None, 0.5, False, False),
        ("D", "A"): (None, None, False, False),
        ("C", "pack"): (None, None, True, False),
        ("plug", "D"): (None, None, True, False),
    }
    assert [place.node for place in model.layout.storage] == ["B"]
    assert {name: station.at for name, station in model.layout.stations.items()} == {"table 1": ("pack",)}
    assert model.layout.bays["chargers"].at == ("plug",)
    left = [remark for remark in made.remarks if remark.what == "left out"]
    assert [(remark.kind, remark.names) for remark in left] == [("column", ("Remark",))]


def test_a_folder_or_names_with_nodes_and_edges_in_them(tmp_path):
    whole = dw.read_layout(tables(tmp_path)).layout
    assert dw.read_layout(tmp_path).layout == whole
    for name in ("nodes", "edges"):
        (tmp_path / f"{name}.csv").rename(tmp_path / f"hall-{name}.csv")
    model = dw.read_layout(tmp_path / "hall-nodes.csv")
    assert (model.name, model.layout) == ("hall", whole)


def test_edges_that_do_not_say_may_lead_both_ways(tmp_path):
    model = dw.read_layout(tables(tmp_path), two_way=True)
    assert {edge: two_way for edge, (*_, two_way, _) in lanes(model).items() if not two_way} == {("B", "C"): False}


@pytest.mark.parametrize(("title", "yes", "no"), [("one_way", "no", "yes"), ("Oneway", "False", "True")])
def test_a_table_may_say_which_edges_are_one_way(tmp_path, title, yes, no):
    (tmp_path / "nodes.csv").write_text("name,x,y,role\nA,0,0,load\nB,20,0,unload\nC,20,12,\n")
    (tmp_path / "edges.csv").write_text(f"from,to,{title}\nA,B,{yes}\nB,C,{no}\nC,A,{no}\n")
    made = import_layout(tmp_path)
    assert {edge: two_way for edge, (*_, two_way, _) in lanes(made.model).items()} == {
        ("A", "B"): True, ("B", "C"): False, ("C", "A"): False
    }  # fmt: skip
    assert not [remark for remark in made.remarks if remark.what == "left out"]


def test_y_may_be_upwards(tmp_path):
    path = tables(tmp_path)
    path.write_text(NODES.replace("Y [m]", "north [mm]").replace(";8;", ";8000;"))
    assert dw.read_layout(path).layout.nodes["C"] == (10, -8)


def test_lanes_side_by_side_are_no_two_way_lane(tmp_path):
    (tmp_path / "nodes.csv").write_text("name,x,y,role\nA,0,0,load\nB,9,0,unload\nC,9,9,\n")
    (tmp_path / "edges.csv").write_text("from,to,side_by_side\nA,B,yes\nB,A,\nB,C,\nC,B,\n")
    layout = build(dw.read_layout(tmp_path).layout)
    assert layout.two_way == [("B", "C")]
    assert {*layout.graph.edges} == {("A", "B"), ("B", "A"), ("B", "C"), ("C", "B")}


SAID = [
    ("nodes", "X [m]", "Breadth", "nodes.csv:1: no column x (got Name, Y [m], Role, Station, Breadth and Remark)"),
    ("nodes", "X [m]", "X [furlong]", "nodes.csv:1: column 'X [furlong]': unit 'furlong' is not known"),
    ("nodes", "Remark", "role", "nodes.csv:1: column 'role' a second time"),
    ("nodes", "C;10;8", "C;ten;8", "nodes.csv:4: X [m]: not a length (got 'ten')"),
    ("nodes", "C;10;8", "C;;8", "nodes.csv:4: X [m]: empty, expected a number of metres"),
    ("nodes", "C;10;8", "C;nan;8", "nodes.csv:4: X [m]: not a length (got 'nan')"),
    ("nodes", "C;10;8", "C;1e308;8", "nodes.csv:4: X [m]: not a length (got '1e308')"),
    ("nodes", "C;10;8", ";10;8", "nodes.csv:4: Name: empty, expected a name"),
    ("nodes", "C;10;8", "A;10;8", "nodes.csv:4: Name: a node of this name stands before (got 'A')"),
    ("nodes", "C;10;8;;;", "C;10;8;;;;;x", "nodes.csv:4: 8 cells, expected at most 6"),
    (
        "nodes",
        "shelf 7",
        '"shelf 7',
        "nodes.csv: not a table (line 3: a cell that begins with a quote does not end with it (unexpected end of data)",
    ),
    ("nodes", "shelf 7", "caf\xe9", "nodes.csv:3: not UTF-8 text (got byte 0xe9)"),
    (
        "edges",
        "C;D;",
        "C;Dd;",
        "edges.csv:4: To: no such node (got 'Dd'), expected the name of a node; did you mean 'D'?",
    ),
    ("edges", "B;C;9,5", "B;C;-9,5", "edges.csv:3: Length: not above 0 (got '-9.5')"),
    ("edges", "B;C;9,5", "B;C;1e-9", "edges.csv:3: Length: too small (got '1e-9')"),
    ("edges", "B;C;9,5", "B;C;9 ells", "edges.csv:3: Length: not a length (got '9 ells')"),
    ("edges", "1000;no", "1000;maybe", "edges.csv:3: Two-way: neither yes nor no (got 'maybe')"),
    ("edges", "From", "Whence", "edges.csv:1: no column from (got"),
]


@pytest.mark.parametrize(("table", "before", "after", "message"), SAID, ids=[message for *_, message in SAID])
def test_what_is_wrong_is_said_with_row_and_column(tmp_path, table, before, after, message):
    tables(tmp_path)
    text = NODES if table == "nodes" else EDGES
    assert before in text
    (tmp_path / f"{table}.csv").write_bytes(text.replace(before, after).encode("latin-1"))
    assert one_message(tmp_path).removeprefix(f"{tmp_path}/").startswith(message)


def test_both_tables_must_be_there(tmp_path):
    path = tables(tmp_path)
    (tmp_path / "edges.csv").unlink()
    with pytest.raises(dw.ModelError, match=r"edges.csv: no such file, expected a table of edges \(CSV\)"):
        dw.read_layout(path)
    (tmp_path / "plan.csv").write_text(NODES)
    with pytest.raises(dw.ModelError, match=r"plan.csv: a table whose name does not say .* nodes.csv with edges.csv"):
        dw.read_layout(tmp_path / "plan.csv")


def test_graphml_with_defaults_and_edges_without_direction(tmp_path):
    made = import_layout(graphml(tmp_path))
    edges = lanes(made.model)
    assert edges["B", "C"] == (9.5, 1, False, False)
    assert edges["C", "D"] == (None, 0.5, False, False)
    assert edges["C", "pack"] == (None, 1, True, False)
    assert edges["D", "plug"] == (None, 1, True, False)
    assert set(made.model.layout.stations) == {"table 1"}
    assert [str(one) for one in made.remarks if one.what == "left out"] == [
        "left out: 1 attribute of nodes: nothing that a layout has: colour"
    ]


def yard():
    graph = nx.DiGraph(name="yard")
    for node, at, role in (("A", (0, 0), "load"), ("B", (10, 0), "unload"), ("C", (10, 8), None)):
        graph.add_node(node, pos=at, **({"role": role} if role else {}))
    nx.add_cycle(graph, "ABC")
    return graph


def test_a_workbook_is_read_as_its_two_tables(tmp_path):
    book, csv = (import_layout(draw(tmp_path)) for draw in (excel, tables))
    assert book.model.layout == csv.model.layout
    assert "yard.xlsx (Excel)" in book.content["description"]


def test_of_several_sheets_of_nodes_the_one_called_so_is_read(tmp_path):
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, the extra excel, is not installed")
    book = openpyxl.load_workbook(path := excel(tmp_path))
    old = book.copy_worksheet(book["Nodes"])
    old["B2"], old.title = 99, "old nodes"
    book.move_sheet(old, -2)
    book.save(path)
    assert import_layout(path).model.layout == import_layout(tables(tmp_path)).model.layout
    book["Nodes"].title = "new nodes"
    book.save(path)
    with pytest.raises(
        dw.ModelError, match=r"several sheets of nodes \(got old nodes and new nodes\), expected sheets"
    ):
        import_layout(path)


def test_what_is_wrong_with_a_workbook_is_said_with_sheet_and_row(tmp_path):
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, the extra excel, is not installed")
    path, book = tmp_path / "hall.xlsx", openpyxl.Workbook()
    book.active.title = "nodes"
    book.active.append(["name", "x", "y"])
    book.active.append(["A", 0, "left"])
    book.save(path)
    with pytest.raises(
        dw.ModelError, match=r"hall\.xlsx: no sheet of edges \(got nodes\), expected sheets nodes and edges"
    ):
        import_layout(path)
    book.create_sheet("edges").append(["from", "to"])
    book.save(path)
    with pytest.raises(dw.ModelError, match=r"hall\.xlsx, nodes:2: y: "):
        import_layout(path)
    book["nodes"]["A2"] = '="A"'
    book.save(path)
    with pytest.raises(dw.ModelError, match=r"hall\.xlsx, nodes:2: name: no value \(got 'a formula without a stored"):
        import_layout(path)
    path.write_bytes(path.read_bytes()[:900])
    with pytest.raises(dw.ModelError, match=r"hall\.xlsx: cannot be read \(.*\), expected a workbook of Excel"):
        import_layout(path)


def test_a_graph_of_networkx_is_read():
    graph = yard()
    graph.edges["A", "B"].update(length=12, speed="1.5 m/s")
    model = dw.read_layout(graph, robots=2)
    assert (model.name, model.fleet.size) == ("yard", 2)
    assert lanes(model)["A", "B"] == (12, 1.5, False, False)
    assert {two_way for *_, two_way, _ in lanes(dw.read_layout(graph.to_undirected())).values()} == {True}
    # numbers of nodes are names, and so are pairs
    assert set(dw.read_layout(nx.relabel_nodes(graph, {"A": 1, "B": (2, 3)})).layout.nodes) == {"1", "(2, 3)", "C"}


def test_the_graph_of_a_layout_is_read_as_that_layout(tmp_path):
    layout = build(dw.read_layout(tables(tmp_path)).layout)
    graph = nx.DiGraph(layout.graph)
    graph.nodes["B"]["role"], graph.nodes["pack"]["role"] = "load", "unload"
    again = build(dw.read_layout(graph).layout)
    assert dict(again.graph.edges) == dict(layout.graph.edges)
    assert again.points == layout.points


def test_what_networkx_writes_is_read(tmp_path):
    graph = yard()
    for node, data in graph.nodes(data=True):
        data["x"], data["y"] = data.pop("pos")
        assert node
    nx.write_graphml(graph, tmp_path / "graph.graphml")
    assert dw.read_layout(tmp_path / "graph.graphml").layout == dw.read_layout(graph).layout


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda graph: graph.nodes["B"].clear(), "node 'B': x: empty, expected a number of metres"),
        (lambda graph: [data.clear() for _, data in graph.nodes(data=True)], "no column x"),
        (lambda graph: graph.edges["A", "B"].update(length=float("nan")), "edge 'A' to 'B': length: not a length"),
        (lambda graph: graph.edges["A", "B"].update(speed=-1), "edge 'A' to 'B': speed: not above 0 (got -1)"),
        (lambda graph: graph.edges["A", "B"].update(length=10**400), "edge 'A' to 'B': length: not a length"),
        (lambda graph: graph.graph.update(crs="epsg:4326"), "coordinates on the globe (crs), expected metres"),
        (lambda graph: graph.add_edge(1, "1"), "node '1': x: empty"),
        (nx.Graph.clear, "no column x"),
    ],
)
def test_what_is_wrong_with_a_graph_is_one_message(change, message):
    graph = yard()
    change(graph)
    assert message in one_message(graph)


def test_a_graph_with_two_edges_of_one_label_is_refused_before_a_model_is_written(tmp_path):
    """Edges from A to B>C and from A>B to C are both A>B>C in tables."""
    drawn, model = tmp_path / "ring.graphml", tmp_path / "ring.yaml"
    graph = nx.DiGraph([("A", "B>C"), ("B>C", "A>B"), ("A>B", "C"), ("C", "A")])
    for node, x, y in (("A", 0, 0), ("B>C", 9, 0), ("A>B", 9, 9), ("C", 0, 9)):
        graph.add_node(node, x=x, y=y)
    nx.write_graphml(graph, drawn)
    refused = CliRunner().invoke(desim, ["import", str(drawn), "-o", str(model)]).exception
    assert str(refused) == one_message(drawn)
    assert "ring.graphml (GraphML): layout: edges [A, B>C] and [A>B, C] have one name" in str(refused)
    assert not model.exists()


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('key="d4">9.5', 'key="d9">9.5', "yard.graphml:20: data: of a key that the file does not have (got 'd9')"),
        ('key="d4">9.5', 'key="d4">long', "yard.graphml:20: edge 'B' to 'C': length: not a length (got 'long')"),
        ('target="D"', 'target="E"', "no such node (got 'E')"),
        ('<node id="A">', "<node>", "yard.graphml:11: node: no id, expected one"),
        ("<graph ", "<graf ", "not XML"),
        ("<graphml xm", '<!DOCTYPE graphml [<!ENTITY a "b">]><graphml xm', "a document type"),
    ],
)
def test_what_is_wrong_with_graphml_is_said_with_its_line(tmp_path, before, after, message):
    path = graphml(tmp_path)
    path.write_text(GRAPHML.replace(before, after, 1))
    assert message in one_message(path)


YED = """\
<graphml xmlns:y="http://www.yworks.com/xml/graphml">
  <key for="node" id="d6" yfiles.type="nodegraphics"/>
  <key attr.name="role" attr.type="string" for="node" id="d4"/>
  <graph edgedefault="directed" id="G">
    <node id="n0"><data key="d4">load</data>
      <data key="d6"><y:ShapeNode><y:Geometry height="2" width="2" x="-1" y="-1"/></y:ShapeNode></data></node>
    <node id="n1"><data key="d4">unload</data>
      <data key="d6"><y:ShapeNode><y:Geometry height="2" width="4" x="8" y="-1"/></y:ShapeNode></data></node>
    <edge id="e0" source="n0" target="n1"/>
    <edge id="e1" source="n1" target="n0"/>
  </graph>
</graphml>
"""


def test_nodes_lie_where_yed_draws_them(tmp_path):
    (tmp_path / "drawn.graphml").write_text(YED)
    assert dict(dw.read_layout(tmp_path / "drawn.graphml").layout.nodes) == {"n0": (0, 0), "n1": (10, 0)}
