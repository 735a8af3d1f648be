"""Decisions of goods to person by hand: along a line of nodes, a metre and a second apart from each other."""

from types import SimpleNamespace

import pytest

from desim_warehouse.policies import pods
from desim_warehouse.policies.pods import OrderCall, PlaceView, PodCall, PodView, PutCall, StationView, StorageCall

TRAVEL = SimpleNamespace(time=lambda a, b: abs(int(b) - int(a)))


def pod(number, at, lines=0, *, home=0, units=0.0, rank=0.0):
    return PodView(number, home, (str(at), str(at + 1)), 0.5, units, rank, range(lines))


def brought(policy, *some, robots=("0",), draw=0.0):
    return policy.choose(PodCall(0.0, "20", some, robots, TRAVEL, draw))


def test_the_nearest_pod_is_the_one_that_is_there_soonest():
    # from the robot to it, and on to the station at 20: with a robot behind it, a pod past the station is worth it
    assert brought(pods.NearestPod(), pod(1, 9, 5), pod(2, 4), robots=("9",)) == 1
    assert brought(pods.NearestPod(), pod(1, 22, 5), pod(2, 4), robots=("0", "4")) == 2
    assert brought(pods.NearestPod(), pod(1, 22, 5), pod(2, 4), robots=("0", "22")) == 1
    assert brought(pods.NearestPod(), pod(2, 4), pod(1, 4)) == 1  # ties by number


def test_most_lines_and_of_these_the_soonest():
    assert brought(pods.MostLines(), pod(1, 9, 2), pod(2, 30, 3), pod(3, 4, 3)) == 3
    assert brought(pods.MostLines(), pod(1, 9, 2), pod(2, 30, 3), pod(3, 4, 1)) == 2


@pytest.mark.parametrize(("draw", "number"), [(0.0, 7), (0.34, 5), (0.66, 5), (0.67, 3), (0.99, 3)])
def test_any_pod_is_as_likely(draw, number):
    some = pod(7, 1), pod(5, 2), pod(3, 3)
    assert brought(pods.RandomPod(), *some, draw=draw) == number
    assert pods.AnyPod().choose(PutCall(0.0, "20", 0, some, draw)) == number
    places = [PlaceView(one.number, one.edge, 0.0) for one in some]
    assert pods.RandomPlace().choose(StorageCall(0.0, "20", some[0], places, TRAVEL, draw)) == number


PLACES = [PlaceView(0, ("29", "30"), 0.0), PlaceView(1, ("22", "23"), 0.9), PlaceView(2, ("22", "23"), 0.1)]


@pytest.mark.parametrize(
    ("policy", "rank", "number"),
    [
        (pods.NearestPlace(), 0.9, 2),
        (pods.OwnPlace(), 0.0, 1),
        (pods.ByTurnover(), 0.0, 2),
        (pods.ByTurnover(), 0.34, 1),
        (pods.ByTurnover(), 0.99, 0),
        (pods.ByTurnover(), 1.0, 0),
    ],
)
def test_where_a_pod_is_put_down(policy, rank, number):
    assert policy.choose(StorageCall(0.0, "20", pod(4, 1, home=1, rank=rank), PLACES, TRAVEL, 0.0)) == number


def lines(*items):
    return [SimpleNamespace(item=item) for item in items]


def test_which_station_an_order_goes_to():
    stations = [StationView("20", 3, {1: 2, 2: 1}), StationView("30", 1, {5: 1}), StationView("40", 1, {})]
    assert pods.FewestOrders().choose(OrderCall(0.0, lines(1, 2), stations, 0.0)) == "30"
    assert pods.MostLinesInCommon().choose(OrderCall(0.0, lines(1, 2, 5), stations, 0.0)) == "20"
    assert pods.MostLinesInCommon().choose(OrderCall(0.0, lines(1, 5), stations, 0.0)) == "30"  # as many, fewer orders
    assert pods.MostLinesInCommon().choose(OrderCall(0.0, lines(8), stations, 0.0)) == "30"


def test_the_emptiest_pod_is_chosen():
    some = pod(4, 1, units=3), pod(2, 1, units=3), pod(1, 1, units=5)
    assert pods.Emptiest().choose(PutCall(0.0, "20", 0, some, 0.0)) == 2
