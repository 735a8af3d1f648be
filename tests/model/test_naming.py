"""Node names of block layouts."""

from desim_warehouse.layout.naming import block_nodes


def test_up_to_26_nodes_are_letters_row_by_row():
    assert block_nodes(5, 2) == (tuple("ABCDEF"), tuple("GHIJKL"), tuple("MNOPQR"))
    assert block_nodes(12, 1)[1][-1] == "Z"


def test_more_nodes_are_named_by_row_and_column():
    names = block_nodes(8, 2)
    assert (names[0][0], names[2][8]) == ("r0c0", "r2c8")
    assert len({name for row in names for name in row}) == 27
