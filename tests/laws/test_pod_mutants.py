"""The auditor of pods detects each of these mutants in a few random models, or their work never ends."""

import pytest

from desim_warehouse.world.orders.pods import Pod, Pods, Shelves
from tests.laws.faults import faults_of
from tests.laws.features import warehouse

MODELS = 60


def stays_free(self, pod, place):
    pod.place = place


def stands_all_the_time(self, pod):
    if not self.keep:
        self.free[pod.place] = None


def all_there_is(self, item):
    return self.stock.get(item, 0)


def one_order_more(self):
    self.spec = self.spec.model_copy(update={"orders": self.spec.orders and self.spec.orders + 1})
    opened(self)
    self.spec = self.spec.model_copy(update={"orders": self.spec.orders and self.spec.orders - 1})


def bound_for_ever(self, pod, node, stop):
    chosen(self, pod, node, stop)
    pod.bound = node


opened, chosen = Pods._open_orders, Pods._choose_place
MUTANTS = {
    "two pods may be bound for a place": (Shelves, "reserve", stays_free),
    "a pod on its way back may be called": (Shelves, "lift", stands_all_the_time),
    "units are promised twice": (Pod, "left", all_there_is),
    "a station has an order more than it may": (Pods, "_open_orders", one_order_more),
    "lines join a pod that is done": (Pods, "_choose_place", bound_for_ever),
}


@pytest.mark.parametrize("mutant", MUTANTS)
def test_a_mutant_is_detected(monkeypatch, mutant):
    place, name, wrong = MUTANTS[mutant]
    monkeypatch.setattr(place, name, wrong)
    assert any(faults_of(warehouse(number, "pods"), number) for number in range(MODELS))
