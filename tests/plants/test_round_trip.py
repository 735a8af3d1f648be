"""What `desim export` writes of a model, `desim import` reads as the same, as far as the format can carry it."""

from functools import cache

import pytest
from hypothesis import given, settings

import desim_warehouse as dw
from desim_warehouse.plants import import_layout
from tests.daily import some
from tests.plants.foreign import needs_plants, plant_file
from tests.plants.round_trip import FORMATS, carried, models

in_each_form = pytest.mark.parametrize("form", FORMATS)
fewer = settings(max_examples=settings.default.max_examples // 2)


def there_and_back(model, folder, form):
    path = folder / FORMATS[form]
    remarks = dw.write_layout(model, path, form)
    return remarks, import_layout(path)


def same(one, other):
    """Whether both are the same, places, lengths and speeds to a millimetre or so."""
    lanes, nodes = ([plan.pop(key) for plan in (one, other)] for key in ("lanes", "nodes"))
    assert one == other
    assert nodes[1] == {name: pytest.approx(at, abs=0.0011) for name, at in nodes[0].items()}
    assert lanes[0].keys() == lanes[1].keys()
    for edge, (length, speed, two_way) in lanes[0].items():
        assert lanes[1][edge] == (pytest.approx(length, abs=0.011), pytest.approx(speed, abs=1e-3), two_way)


@in_each_form
@fewer
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
    after.pop("joined")
    for plan in (before, after):
        plan["lanes"] = {(a, b): lane for (a, b), lane in plan["lanes"].items() if f"{a}>{b}" not in joined}
    same(before, after)


@in_each_form
@fewer
@given(model=models(in_lanes=True))
def test_a_second_trip_changes_nothing(model, form, tmp_path_factory):
    folder = tmp_path_factory.mktemp(form)
    _, first = there_and_back(model, folder, form)
    _, second = there_and_back(first.model, folder, form)
    before, after = carried(first.model, form), carried(second.model, form)
    assert (before.pop("joined"), after.pop("joined")) == (set(), set()) or form in {"csv", "graphml"}
    same(before, after)


FOREIGN = (
    "opentcs/Demo-01_v7.xml",
    "opentcs-touchmii/labmodel.xml",
    "opentcs-touchmii/tsh.xml",
    "opentcs-touchmii/xxx.xml",
    "opentcs-touchmii/zhaoqin.xml",
    "lif-vdma/10_13_Battery_Charging_Station.json",
    "lif-vdma/10_14_Two_Levels_of_a_Facility_in_One_LIF_File.json",
    "lif-vdma/10_17_Edge_with_Trajectory_Definition.json",
    "rmf/battle_royale.building.yaml",
    "rmf/office.building.yaml",
    "rmf/triple_H.building.yaml",
    "ggo/kiva_small_r_mode_alternate_baseline_bi-directed.json",
)


@cache
def foreign(name):
    return dw.read_layout(plant_file(name))


@needs_plants
@pytest.mark.parametrize("trip", some([(name, form) for name in FOREIGN for form in FORMATS], 3), ids="-".join)
def test_plants_of_others_come_back_from_every_format(trip, tmp_path):
    name, form = trip
    model = foreign(name)
    _, made = there_and_back(model, tmp_path, form)
    before, after = carried(model, form), carried(made.model, form)
    assert (before.pop("joined"), after.pop("joined")) == (set(), set())
    same(before, after)
