"""Whatever is put into a model, the answer is a model or a ModelError, never another exception."""

import copy
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from desim_warehouse.errors import ModelError
from desim_warehouse.model import load, parse_assignment
from desim_warehouse.model.schema import Model

pytestmark = pytest.mark.slow
MULTIBOTS = Path(__file__).parents[2] / "models" / "multibots.yaml"
DRAWN = {
    "nodes": {"a": [0, 0], "b": [9, 0], "c": [9, 9]},
    "edges": [["a", "b"], ["b", "c"], {"from": "c", "to": "a", "length": 20}],
    "storage": [{"edge": ["a", "b"], "offset": 4}],
    "bays": {"home": {"at": ["a"]}},
}
BLOCKS = load(MULTIBOTS, {"battery.taper": {"start": 0.8}, "policies.charging.level": 2}).content()
EXPLICIT = load(
    {**BLOCKS, "layout": DRAWN}, {"fleet.start": ["a"], "tasks.unload_at": ["c"], "tasks.goods": [0]}
).content()
JUNK = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4) | st.sampled_from("ABac"),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["size", "at", "good", "random", "file", "name", "rows"]), inner)
        | st.dictionaries(st.text(max_size=3) | st.integers(), inner, max_size=2)
    ),
    max_leaves=5,
)
relaxed = settings(deadline=None, max_examples=max(100, settings.default.max_examples))


def paths(value, at=()):
    yield at
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from paths(item, (*at, key))


@st.composite
def spoilt(draw):
    """A good model with junk in some places, and some keys taken out."""
    data = copy.deepcopy(draw(st.sampled_from([BLOCKS, EXPLICIT])))
    for _ in range(draw(st.integers(1, 3))):
        *parents, last = draw(st.sampled_from([path for path in paths(data) if path]))
        section = data
        for key in parents:
            section = section[key]
        if draw(st.booleans()):
            section[last] = draw(JUNK)
        elif isinstance(section, dict):
            del section[last]
    return data


def answer(source, overrides=None):
    try:
        return load(source, overrides)
    except ModelError as refused:
        return refused.problems


def assigned(text):
    try:
        return parse_assignment(text)[0]
    except ModelError as refused:
        return str(refused)


@relaxed
@given(spoilt())
def test_a_spoilt_model_is_read_or_refused_in_single_lines(data):
    outcome = answer(data)
    assert isinstance(outcome, Model) or all(
        line.startswith("<mapping>: ") and "\n" not in line and ("expected" in line or "should" in line or "?" in line)
        for line in outcome
    )


@relaxed
@given(st.dictionaries(st.sampled_from([".".join(map(str, path)) for path in paths(BLOCKS) if path]), JUNK, max_size=3))
def test_junk_in_overrides_is_read_or_refused(overrides):
    outcome = answer(BLOCKS, overrides)
    assert isinstance(outcome, Model) or outcome


@relaxed
@given(st.data())
def test_a_damaged_file_is_read_or_refused_with_its_place(tmp_path_factory, data):
    text = MULTIBOTS.read_bytes()
    start = data.draw(st.integers(0, len(text)))
    cut = text[:start] + data.draw(st.binary(max_size=3)) + text[start + data.draw(st.integers(0, 40)) :]
    file = tmp_path_factory.mktemp("damaged") / "model.yaml"
    file.write_bytes(cut)
    outcome = answer(file)
    assert isinstance(outcome, Model) or all(line.startswith(f"{file}:") for line in outcome)


@relaxed
@given(st.text(max_size=20))
def test_an_assignment_is_read_or_refused(text):
    outcome = assigned(text)
    assert outcome == text.partition("=")[0].strip() or outcome.startswith("--set ")
