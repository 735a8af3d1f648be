"""What is written as YAML is read back as it was."""

from hypothesis import given
from hypothesis import strategies as st

from desim_warehouse.model.parse import read_yaml
from desim_warehouse.plants.write import written

NAMES = st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=12)
WORDS = st.sampled_from(
    ["yes", "No", "null", "1e3", "0x1F", "12", "a: b", "- a", "# a", " a", "a ", "2026-01-01", "<<"]
)
TEXT = NAMES | WORDS
NUMBERS = st.integers(-(10**9), 10**9) | st.floats(allow_nan=False, allow_infinity=False).map(lambda x: round(x, 4))
VALUES = TEXT | NUMBERS | st.booleans()
PARTS = st.recursive(
    VALUES,
    lambda inner: st.lists(inner, min_size=1, max_size=4) | st.dictionaries(TEXT, inner, min_size=1, max_size=4),
    max_leaves=20,
)


@given(st.dictionaries(TEXT, PARTS, min_size=1, max_size=5), TEXT)
def test_any_content_with_any_names(content, words):
    keys = [(key,) for key in content] + [(key, 0) for key in content]
    document = read_yaml(written(content, dict.fromkeys(keys, words), [words]), "file")
    assert not document.problems
    assert document.data == content


def test_parts_stand_in_one_line_and_sections_in_several():
    content = {
        "name": "small",
        "layout": {"nodes": {"A": [0, 1.5]}, "edges": [{"from": "A", "to": "B", "two_way": True}]},
    }
    text = written(content, {("layout", "edges", 0): "a spur", ("battery",): "none"}, ["drawn by hand"])
    assert text.splitlines() == [
        "# drawn by hand",
        "name: small",
        "",
        "layout:",
        "  nodes: {A: [0, 1.5]}",
        "  edges:",
        "    - {from: A, to: B, two_way: true}  # a spur",
        "",
        "# battery: none",
    ]
