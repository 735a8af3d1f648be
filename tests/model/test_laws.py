"""What holds for every model: it can be written and read back, and the order of overrides is no matter."""

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from desim_warehouse.model import load

pytestmark = pytest.mark.slow
BASE = load(Path(__file__).parents[2] / "models" / "multibots.yaml")
NODE = st.sampled_from("ABCDEFGHIJKLMNOPQR")
AMOUNT = st.floats(0, 1e12) | st.integers(0, 10**6) | st.just(-0.0)
POSITIVE = st.floats(1e-9, 1e12) | st.integers(1, 10**6)
GOOD = st.integers(0, 79)
SEEN = st.characters(exclude_categories=["C"])
PARAMETER = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(SEEN, max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(SEEN, max_size=5), inner, max_size=3),
    max_leaves=6,
)
TASK = GOOD | st.fixed_dictionaries({"good": GOOD}, optional={"release": AMOUNT, "priority": st.integers(-9, 9)})
PAIRS = st.fixed_dictionaries({"count": st.just(1)}, optional={"radius": POSITIVE, "speed": POSITIVE})
KEYS = {
    "name": st.text(SEEN, max_size=9),
    "fleet.size": st.integers(2, 9),
    "fleet.start": st.lists(NODE, min_size=6, max_size=6),
    "fleet.start.3": NODE,
    "fleet.robot": st.fixed_dictionaries({"radius": POSITIVE, "speed": POSITIVE}),
    "fleet.robot.margin": AMOUNT,
    "fleet.kinds": st.dictionaries(st.text(SEEN, min_size=1, max_size=3), PAIRS, max_size=2),
    "tasks.goods": st.lists(TASK, min_size=1, max_size=6) | st.fixed_dictionaries({"random": st.integers(1, 99)}),
    "tasks.unload_at": st.lists(NODE, min_size=1, max_size=1),
    "tasks.popularity": st.sampled_from(["uniform"])
    | st.lists(st.floats(0.1, 9), min_size=80, max_size=80).map(lambda weights: {"weights": weights}),
    "battery.consumption": AMOUNT
    | st.fixed_dictionaries(dict.fromkeys(("standing", "empty", "loaded", "handling"), AMOUNT)),
    "layout.bays.charging.places": st.none() | st.integers(1, 9),
    "layout.bays.spare.at": st.lists(NODE, min_size=1, max_size=3, unique=True),
    "layout.blocks.directions.rows.1": st.sampled_from(["east", "west"]),
    "policies.charging": st.sampled_from(["threshold", "early"]),
    "policies.charging.margin": PARAMETER,
    "policies.charging.levels": PARAMETER,
    "run.length": st.none() | st.floats(1, 1e9),
    "cost.time": AMOUNT,
}
OVERRIDES = st.fixed_dictionaries({}, optional=KEYS)
relaxed = settings(deadline=None, max_examples=max(30, settings.default.max_examples))


@relaxed
@given(OVERRIDES)
def test_a_model_read_back_from_its_content_is_the_same(overrides):
    model = BASE.replace(overrides)
    again = load(json.loads(json.dumps(model.content())))
    assert again == model
    assert again.digest() == model.digest()
    assert again.content() == model.content()


@relaxed
@given(st.data())
def test_the_order_of_overrides_is_no_matter(data):
    overrides = data.draw(OVERRIDES)
    order = data.draw(st.permutations(list(overrides)))
    first, other = BASE.replace(overrides), BASE.replace({key: overrides[key] for key in order})
    assert first == other
    assert first.digest() == other.digest()


@relaxed
@given(OVERRIDES)
def test_models_are_equal_just_when_their_digests_are(overrides):
    model = BASE.replace(overrides)
    assert (model == BASE) is (model.digest() == BASE.digest())


@relaxed
@given(OVERRIDES)
def test_overrides_at_reading_and_later_give_the_same_model(overrides):
    file = Path(__file__).parents[2] / "models" / "multibots.yaml"
    assert load(file, overrides) == BASE.replace(overrides)
