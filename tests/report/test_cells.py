"""A floor of many cells is a map: aisles light, shelves dark, places coloured; arrows where lanes are one-way."""

import pytest
from matplotlib.collections import PolyCollection
from matplotlib.quiver import Quiver

import desim_warehouse as dw
from desim_warehouse.layout import build
from desim_warehouse.look import palette
from desim_warehouse.plants import import_layout
from desim_warehouse.plot import cells, floor

ROWS = [
    "." * 25,
    *(row for _ in range(6) for row in ("r" + ".eeeeeee" * 3, "." + ".@@@@@@@" * 3, "." + ".eeeeeee" * 3, "." * 25)),
]


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    path = tmp_path_factory.mktemp("grid") / "shelves.map"
    text = "".join(ROWS)
    path.write_text("\n".join([f"25 25\n{text.count('e')}\n{text.count('r')}\n100", *ROWS]))
    return import_layout(path).model


def drawn(ax):
    """Colour of each group of squares -> the middles of the squares."""
    by_colour = {}
    for squares in ax.collections:
        if isinstance(squares, PolyCollection):
            colour = tuple(squares.get_facecolor()[0]) if len(squares.get_facecolor()) else None
            middles = {tuple(path.vertices[:4].mean(axis=0).round(6).tolist()) for path in squares.get_paths()}
            by_colour.setdefault(colour, set()).update(middles)
    return by_colour


def rgba(colour):
    from matplotlib.colors import to_rgba

    return tuple(to_rgba(colour))


def at(letter):
    return {(column, row) for row, line in enumerate(ROWS) for column, here in enumerate(line) if here == letter}


def test_cells_have_the_colour_of_what_they_are_for(model):
    ax = floor.layout(model)
    by_colour = drawn(ax)
    assert by_colour[rgba(cells.GOODS)] == at("e")
    assert by_colour[rgba(palette.BAY)] == at("r")
    assert by_colour[rgba(cells.AISLE)] == at("e") | at("r") | at(".")
    assert rgba(ax.get_facecolor()) == rgba(cells.SHELF)  # which is what is left of a shelf
    assert not ax.texts
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        "shelf or wall",
        "aisle",
        "storage place",
        "bay",
    ]
    assert not any(isinstance(one, Quiver) for one in ax.collections)


def test_one_way_lanes_have_arrows(model):
    content = model.content()
    content["layout"]["edges"][0].pop("two_way")
    content["layout"]["edges"][7].pop("two_way")
    (arrows,) = (one for one in floor.layout(dw.load(content)).collections if isinstance(one, Quiver))
    ends = [(edge["from"], edge["to"]) for edge in (content["layout"]["edges"][0], content["layout"]["edges"][7])]
    nodes = content["layout"]["nodes"]
    expected = {tuple((nodes[a][axis] + nodes[b][axis]) / 2 for axis in (0, 1)) for a, b in ends}
    assert {tuple(offset) for offset in arrows.get_offsets().tolist()} == expected


def test_small_floors_and_those_with_room_on_their_edges_are_drawn_as_ever(model):
    assert cells.is_map(model, build(model.layout))
    thin = model.replace({"fleet.robot.radius": 0.1})
    assert not cells.is_map(thin, build(thin.layout))
    blocks = dw.load("models/multibots.yaml")
    assert not cells.is_map(blocks, build(blocks.layout))


def test_a_picture_has_room_for_every_cell(model, tmp_path):
    from PIL import Image

    path = floor.save(model, tmp_path / "grid.png")
    with Image.open(path) as image:
        assert image.size[0] > 25 * 5
