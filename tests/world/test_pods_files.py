"""Goods to person from files: what pods hold, where they stand, and items of orders; on the ring of test_pods."""

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import ModelError
from desim_warehouse.model.sections.pods import PodsSpec
from desim_warehouse.orders.day import order_day
from desim_warehouse.questions.check import check
from desim_warehouse.values.streams import Streams
from desim_warehouse.world.orders.pods import Shelves
from tests.audit_pods import audit_pods
from tests.world.test_pods import RING

pytestmark = pytest.mark.usefixtures("brief_probes")

HOLDS = "pod,place,item,units\nA,0,tea,2\nA,0,milk,1\nB,2,tea,1\n"
ORDERS = "release,order,item\n0,1,milk\n0,1,tea\n200,2,tea\n200,3,tea\n"


@pytest.fixture
def files(tmp_path):
    """A model of files: `files(holds=..., orders=..., **changes)`."""

    def made(holds=HOLDS, orders=ORDERS, **changes):
        (tmp_path / "pods.csv").write_text(holds)
        (tmp_path / "orders.csv").write_text(orders)
        pods = {"count": 2, "items": 2, "orders": 0, "change_time": 0, "holds": {"file": str(tmp_path / "pods.csv")}}
        arrivals = {"orders": {"file": str(tmp_path / "orders.csv")}}
        named = {key.replace("__", "."): value for key, value in changes.items()}
        return dw.load(RING, {"pods": pods, "tasks.flows.picks.arrivals": arrivals, **named})

    return made


def delivered(run):
    assert audit_pods(run) == []
    return [(row.time, row.task, row.other) for row in run.history.rows("delivered")]


def test_lines_are_picked_from_the_pods_of_the_file(files):
    run = dw.simulate(files(), seed=5)
    item = {row.task: row.other for row in run.history.rows("released")}
    assert item == {0: 1, 1: 0, 2: 0, 3: 0}  # tea is 0, as the file names it first
    # pod A at 5 m has both: lifted at 8, docked 33. Of its two of tea one is left; the next is on B at 15 m.
    assert delivered(run)[:2] == [(43, 0, 0), (53, 1, 0)]
    assert sorted(pod for _, _, pod in delivered(run)[2:]) == [0, 1]
    assert next((row.other, row.value) for row in run.history.rows("lifted")) == (0, 0)


def test_nothing_is_drawn_where_files_say_all(files):
    """Another seed is the same run."""
    first, second = (dw.simulate(files(), seed).history for seed in (1, 2))
    assert list(first.rows("delivered", "lifted", "stored")) == list(second.rows("delivered", "lifted", "stored"))


def test_what_a_file_does_not_say_is_as_without_it(files):
    bare = files("pod,item\nA,tea\nA,milk\nB,tea\n", "release\n0\n0\n0\n0\n0\n0\n")
    runs = [dw.simulate(bare, seed) for seed in range(9)]
    assert all(len(delivered(run)) == 6 for run in runs)  # stock without end
    assert len({row.other for run in runs for row in run.history.rows("lifted")}) == 3  # places are drawn
    assert {row.other for run in runs for row in run.history.rows("released")} == {0, 1}  # and items
    with pytest.raises(dw.StallError, match=r"3 of 6 tasks .* no pod has any left \(pods.stock\): tea, milk"):
        dw.simulate(bare.replace({"pods.stock": 1}))
    assert out_of_stock(bare.replace({"pods.stock": 1})) == "in this run 3 units of item milk are picked"


def out_of_stock(model):
    """The beginning of the warning that an item runs out; empty if none does."""
    texts = [finding.text for finding in check(model).findings if finding.code == "STOCK_RUNS_OUT"]
    return texts[0].partition(" beyond ")[0] if texts else ""


def test_stock_is_compared_with_the_items_that_rows_name(files):
    """Pods hold 3 of tea and 1 of milk: just enough for 3 and 1, and too little for 2 of milk."""
    enough = files(orders="release,order,item,quantity\n0,1,tea,3\n0,2,milk,1\n")
    assert out_of_stock(enough) == ""
    assert len(delivered(dw.simulate(enough))) == 4
    short = files(orders="release,order,item,quantity\n0,1,milk,2\n")
    assert out_of_stock(short) == "in this run 2 units of item milk are picked"
    with pytest.raises(dw.StallError, match=r"1 of 2 tasks .* no pod has any left \(pods.stock\): milk$"):
        dw.simulate(short)


def test_rows_without_an_item_count_by_popularity(files):
    """A line of milk, and two lines of which one is expected to be milk: 2 of milk, of which pods hold 1."""
    assert out_of_stock(files(orders="release,item\n0,milk\n0,\n0,\n")) == "in this run 2 units of item milk are picked"


def test_bundles_of_a_file_bring_the_items_that_it_names(files, tmp_path):
    """Two lines of milk, of which pods hold 1: a bundle of milk makes up for it, and one of tea does not."""
    for item, shortage in (("milk", ""), ("tea", "in this run 2 units of item milk are picked")):
        (tmp_path / "bundles.csv").write_text(f"release,item\n0,{item}\n")
        arrivals = {"orders": {"file": str(tmp_path / "bundles.csv")}}
        bundles = {"from": "pick", "to": "storage", "arrivals": arrivals, "stop_time": 5}
        orders = "release,order,item,quantity\n0,1,milk,2\n"
        assert out_of_stock(files(orders=orders, tasks__flows__bundles=bundles)) == shortage


def test_check_reads_the_due_times_and_releases_of_a_file_with_pods(files):
    """Orders are due, so that a late one costs something, and some are released after 100 s, when the run ends."""
    orders = "release,order,item,due\n0,1,milk,90\n200,2,tea,300\n"
    model = files(orders=orders, prices={"late_order": 5, "hours": 4000}, run__length=100)
    texts = {finding.place: finding.text for finding in check(model).findings}
    assert texts["run.length"] == "orders are released until 200 s, and the run ends at 100 s"
    assert "prices.late_order" not in texts
    assert "tasks.flows.picks.arrivals.schedule" not in texts


def test_a_row_may_name_its_station(files):
    stations = {"pick": {"at": ["C"], "places": 5}, "other": {"at": ["D"], "places": 5}}
    orders = "release,item,to\n0,tea,other\n0,milk,pick\n300,tea,storage\n"
    both = {"layout__stations": stations, "tasks__flows__picks__to": ["pick", "other"]}
    run = dw.simulate(files(orders=orders, **both))
    assert delivered(run)
    at = {row.task: row.node for row in run.history.rows("delivered")}
    assert (at[0], at[1]) == ("D", "C")


def test_a_model_of_files_is_complete_by_itself(files, tmp_path):
    model = files()
    (tmp_path / "pods.csv").unlink()
    assert dw.load(model.content()).pods.holds.names == ("tea", "milk")
    assert dw.load(model.content()).digest() == model.digest()


def test_bundles_go_to_the_emptiest_pod_with_those_on_their_way():
    bundles = {"from": "pick", "to": "storage", "arrivals": {"schedule": [{"at": 0, "tasks": 3}]}, "stop_time": 5}
    holds = {"names": ["tea"], "pod": [0, 1], "item": [0, 0], "units": [5, 1]}
    pods = {"count": 2, "items": 1, "bundle": 2, "holds": holds}
    run = dw.simulate(dw.load(RING, {"tasks.flows": {"bundles": bundles}, "pods": pods}))
    # pod 1 holds 1, then 3, then 5 as pod 0: the last is for that with the smaller number
    assert sorted((task, pod) for _, task, pod in delivered(run)) == [(0, 1), (1, 1), (2, 0)]


def test_a_bundle_is_not_for_a_pod_that_another_station_has():
    holds = {"names": ["tea", "milk"], "pod": [0, 1], "item": [0, 1], "units": [1, 9]}
    pods = {"count": 2, "items": 2, "bundle": 2, "holds": holds, "popularity": {"weights": [1, 0]}}
    flows = {
        "picks": {"from": "storage", "to": "pick", "arrivals": {"schedule": [{"at": 0}]}, "stop_time": 10},
        "bundles": {"from": "other", "to": "storage", "arrivals": {"schedule": [{"at": 10}]}, "stop_time": 5},
    }
    stations = {"pick": {"at": ["C"], "places": 5}, "other": {"at": ["D"], "places": 5}}
    changes = {"layout.stations": stations, "tasks.flows": flows, "pods": pods, "fleet.size": 2}
    run = dw.simulate(dw.load(RING, changes))
    assert {task: pod for _, task, pod in delivered(run)} == {0: 0, 1: 1}  # though pod 0 is the emptiest


def test_what_policies_see_of_a_pod():
    holds = {"names": ["milk", "tea"], "pod": [0, 1], "item": [0, 1], "units": [9, 1]}
    spec = PodsSpec(count=2, items=2, holds=holds, popularity={"weights": [1, 5]})
    shelves = Shelves(spec, dw.load(RING).floor.storage, Streams(0), keep=False)
    assert [shelves.view(pod).rank for pod in shelves.pods] == [0.5, 0]  # tea is asked for more often
    first = shelves.pods[0]
    first.coming = 2
    assert shelves.view(first).units == 11
    shelves.put(first, 1, 2)
    assert (shelves.view(first).units, first.left(1)) == (11, 2)
    assert list(shelves.holding(1)) == [shelves.pods[1], first]


def test_orders_of_a_wms_keep_their_items(files, tmp_path):
    (tmp_path / "day.csv").write_text("created_at,order,sku\n2026-03-02 08:00,1,tea\n2026-03-02 08:01,2,milk\n")
    day = order_day(tmp_path / "day.csv", files(), columns={"item": "sku"})
    assert day.table()["item"].tolist() == ["tea", "milk"]


WRONG = {
    "more pods": ({"holds": HOLDS + "C,1,tea,1\n"}, "pods.count: pods.holds has 3 pods, expected count: 3"),
    "fewer items": ({"holds": "pod,item\nA,tea\nB,tea\n"}, "pods.items: pods.holds has 1 item, expected items: 1"),
    "no column": ({"holds": "pod,sku\nA,tea\n"}, "no column 'item'"),
    "two places": ({"holds": HOLDS + "B,1,milk,1\n"}, "pod 'B' is on two places"),
    "one place for two": ({"holds": HOLDS.replace("B,2", "B,0")}, "two pods on place 0, expected a place for each"),
    "no such place": ({"holds": HOLDS.replace("B,2", "B,7")}, "no such place (got 7), expected numbers from 0 to 2"),
    "units are no number": (
        {"holds": HOLDS.replace("A,0,tea,2", "A,0,tea,two")},
        "pods.csv:2:9: pods.holds.units.0: should be a whole number",
    ),
    "units twice": ({"pods__stock": 3}, "pods.stock: units stand in the file, too"),
    "no such item": (
        {"orders": "release,item\n0,te\n"},
        "item: no such item (got 'te'), expected an item that a pod holds",
    ),
    "a place": (
        {"orders": "release,item,to\n0,tea,1\n"},
        "to: no such place (got '1'), expected a station, or 'storage'",
    ),
    "a node in the lane": ({"orders": "release,item,to\n0,tea,B\n"}, "with pods a row names an item"),
    "a stop": ({"orders": "release,item,via\n0,tea,C\n"}, "via: a stop on the way (got 'C'), expected none"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_cannot_be_is_refused(files, what):
    changes, message = WRONG[what]
    with pytest.raises(ModelError) as error:
        dw.simulate(files(**changes))
    assert message in str(error.value)


def test_without_a_file_items_are_numbers(files):
    model = files(pods__holds=None, pods__count=2, pods__per_pod=2, orders="release,item\n0,1\n0,0\n")
    assert [row.other for row in dw.simulate(model).history.rows("released")] == [1, 0]
    with pytest.raises(ModelError, match=r"no such item \(got 'tea'\), expected a number from 0 to 1"):
        dw.simulate(files(pods__holds=None, pods__per_pod=2, orders="release,item\n0,tea\n"))
