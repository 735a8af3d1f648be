"""A total of chargers over the nodes of a zone."""

import pytest

import desim_warehouse as dw
from desim_warehouse import LayoutError, ModelError
from desim_warehouse.layout import build

BAYS = {"charging": {"along": "north", "places": 2}}


def chargers(total, **more):
    bays = {"charging": {**BAYS["charging"], "total_chargers": total, **more}}
    model = dw.load("models/tutorial.yaml", {"layout.bays": bays})
    return [bay.chargers for bay in build(model.layout).bays.values()]


@pytest.mark.parametrize(("total", "each"), [(0, [0, 0, 0]), (1, [1, 0, 0]), (4, [2, 1, 1]), (6, [2, 2, 2])])
def test_a_total_goes_round_the_nodes(total, each):
    assert chargers(total) == each


def test_more_than_there_are_places_is_refused():
    with pytest.raises(
        LayoutError, match=r"layout.bays.charging.total_chargers: too many \(got 7\); 3 nodes with 2 places each"
    ):
        chargers(7)


def test_total_chargers_and_chargers_together_are_refused():
    with pytest.raises(ModelError, match=r"layout.bays.charging.total_chargers: given together with chargers"):
        chargers(3, chargers=1)


def test_a_study_varies_the_total():
    changes = {"layout.bays": BAYS, "tasks.goods": {"random": 30}}
    study = dw.Study(dw.load("models/tutorial.yaml"), {"layout.bays.charging.total_chargers": [1, 3]}, changes=changes)
    study.run()
    assert study.table["tasks"].tolist() == [30, 30]
