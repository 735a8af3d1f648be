"""What `desim export` writes of a model, `desim import` reads as the same, as far as the format can carry it."""

import pytest
from hypothesis import given

import desim_warehouse as dw
from desim_warehouse.plants import import_layout
from tests.plants.round_trip import FORMATS, carried, models

pytestmark = pytest.mark.parametrize("form", FORMATS)


def there_and_back(model, folder, form):
    path = folder / FORMATS[form]
    remarks = dw.write_layout(model, path, form)
    return remarks, import_layout(path)


def same(one, other):
    """Whether both are the same, lengths and speeds to a millimetre (a second)."""
    lanes = one.pop("lanes"), other.pop("lanes")
    assert one == other
    assert lanes[0].keys() == lanes[1].keys()
    for edge, (length, speed, two_way) in lanes[0].items():
        assert lanes[1][edge] == (pytest.approx(length, abs=0.011), pytest.approx(speed, abs=1e-3), two_way)


@given(model=models())
def test_what_a_format_can_carry_comes_back(model, form, tmp_path_factory):
    remarks, made = there_and_back(model, tmp_path_factory.mktemp(form), form)
    before, after = carried(model, form), carried(made.model, form)
    lost = {
        name for remark in made.remarks if (remark.what, remark.kind) == ("left out", "block") for name in remark.names
    }
    if lost:
        before["zones"] = set()
    # lanes side by side that became one are said, by name
    joined = {name for remark in remarks if remark.kind == "lane" and "two-way" in remark.why for name in remark.names}
    assert {f"{a}>{b}" for a, b in before.pop("joined")} >= joined
    drop = {tuple(name.split(">")) for name in joined}
    after.pop("joined")
    before["lanes"] = {edge: lane for edge, lane in before["lanes"].items() if edge not in drop}
    after["lanes"] = {edge: lane for edge, lane in after["lanes"].items() if edge not in drop}
    same(before, after)


@given(model=models(in_lanes=True))
def test_a_second_trip_changes_nothing(model, form, tmp_path_factory):
    folder = tmp_path_factory.mktemp(form)
    _, first = there_and_back(model, folder, form)
    _, second = there_and_back(first.model, folder, form)
    before, after = carried(first.model, form), carried(second.model, form)
    assert (before.pop("joined"), after.pop("joined")) == (set(), set()) or form in {"csv", "graphml"}
    same(before, after)
