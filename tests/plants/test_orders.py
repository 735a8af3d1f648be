"""Tasks beside a plant: transport orders of openTCS; the fleet and its battery from a file."""

from pathlib import Path

import pytest

import desim_warehouse as dw
from desim_warehouse.model.facts.charging import chargers_at
from desim_warehouse.plants import import_layout
from tests.auditor import audit
from tests.plants.damage import one_message
from tests.plants.foreign import needs_plants, plant_file

YARD = Path(__file__).parent / "yard.xml"
ORDERS = Path(__file__).with_name("orders.xml").read_text()


@pytest.fixture
def orders(tmp_path):
    path = tmp_path / "orders.xml"
    path.write_text(ORDERS)
    return path


WEIGH = '<driveOrder locationName="scales" vehicleOperation="Weigh"/>'


def test_transport_orders_are_tasks(orders):
    orders.write_text(ORDERS.replace(WEIGH, ""))
    model = dw.read_layout(YARD, tasks=orders)
    tasks = [(task.good, task.to, task.due) for task in model.tasks.goods]
    assert [place.node for place in model.layout.storage] == ["B", "D"]
    assert tasks == [(0, "table 1", 3600), (1, "table 1", 3600), (1, "table 1", None)]
    assert model.run.length is None
    run = dw.simulate(model)
    assert run.kpis["tasks"] == 3
    assert audit(run) == []


def test_a_stop_between_is_on_the_way(orders):
    made = import_layout(YARD, tasks=orders)
    rows = [line.split(",") for line in made.orders.splitlines()]
    assert rows[0] == ["order", "release", "from", "via", "to", "due"]
    assert [row[2:5] for row in rows[1:]] == [["B", "", "pack"], ["D", "A", "pack"], ["D", "", "pack"]]
    assert set(made.model.traffic.zones) == {"crossing"}
    run = dw.simulate(made.model)
    assert run.kpis["tasks"] == 3
    assert audit(run) == []


def test_what_an_order_says_and_a_task_cannot_is_said(orders):
    made = import_layout(YARD, tasks=orders)
    remarks = {(remark.kind, remark.names, remark.positions) for remark in made.remarks if "order" in remark.kind}
    assert remarks == {
        ("transport order", ("order 1",), ("orders.xml, line 3",)),  # two tasks
        ("transport order", ("order 3",), ("orders.xml, line 14",)),  # out of reach
        ("transport order", ("order 3", "order 4"), ("orders.xml, line 14", "orders.xml, line 18")),  # nothing to do
        ("transport order", ("order 5",), ()),  # no such location
        ("stop of an order", ("Unload cargo at table 1", "CHARGE at charger 1"), ()),
    }
    assert ("intended vehicle", ("order 1",)) in {(remark.kind, remark.names) for remark in made.remarks}
    assert "tasks.goods" not in {remark.kind for remark in made.remarks}


def test_operations_of_orders_mean_what_they_are_mapped_to(orders):
    model = dw.read_layout(YARD, tasks=orders, operations={"Weigh": "unload"})
    assert [task.to for task in model.tasks.goods] == ["table 1", "scales", "table 1"]  # and what follows is left out


DAMAGED = [
    (("<transportOrders>", "<orders>"), ("</transportOrders>", "</orders>"), "not transport orders"),
    (("PLUS_ONE_HOUR", "TOMORROW"), "deadline: not known (got TOMORROW)"),
    (('locationName="scales" ', ""), "no locationName"),
    (("table 1", "table 9"), "no transport order in which a load is fetched"),
    (("</transportOrders>", ""), "not XML"),
]


@pytest.mark.parametrize("case", DAMAGED, ids=[case[-1] for case in DAMAGED])
def test_damaged_orders_are_one_message(orders, case):
    *changes, expected = case
    text = ORDERS
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    orders.write_text(text)
    assert expected in one_message(YARD, tasks=orders).replace("'TOMORROW'", "TOMORROW")


def test_a_model_is_no_list_of_tasks(tmp_path):
    path = tmp_path / "tasks.txt"
    path.write_text("1 2 3")
    with pytest.raises(dw.ModelError, match="not tasks that can be read, expected transport orders"):
        dw.read_layout(YARD, tasks=path)


@needs_plants
def test_transport_orders_of_other_projects_are_read():
    demo, orders = plant_file("opentcs/Demo-01_v7.xml"), plant_file("opentcs-touchmii/transport-orders.xml")
    model = dw.read_layout(demo, tasks=orders)
    assert len(model.tasks.goods) == 6  # four orders: of two loads, one, two and one
    run = dw.simulate(model)
    assert run.kpis["tasks"] == 6
    assert audit(run) == []
    with pytest.raises(dw.ModelError, match="order 1 is to 'Goods in north 01'"):
        dw.read_layout(plant_file("opentcs-touchmii/tsh.xml"), tasks=orders)


# The robots

ROBOT = """
robot: {radius: 400 mm, speed: 1.2 m/s, margin: 0.1}
battery:
  capacity: 480
  threshold: 96
  consumption: {standing: 0.01, empty: 0.02, loaded: 0.03, handling: 0.02}
  charge_rate: 0.1
"""


def test_the_robots_are_as_a_file_says(tmp_path):
    path = tmp_path / "robot.yaml"
    path.write_text(ROBOT)
    made = import_layout(YARD, robot=path)
    fleet, battery = made.model.fleet, made.model.battery
    assert (fleet.size, fleet.robot.radius, fleet.robot.speed, fleet.robot.margin) == (3, 0.4, 1.2, 0.1)
    assert not fleet.kinds
    assert (battery.capacity, battery.threshold, battery.consumption.loaded) == (480, 96, 0.03)
    assumed = {remark.kind for remark in made.remarks if remark.what == "assumed"}
    assert not any(kind.startswith(("fleet.robot", "battery")) for kind in assumed)
    path.write_text("robot: {radius: 0.4, speed: 1}")
    assert dw.read_layout(YARD, robot=path).battery == dw.read_layout(YARD).battery


def test_where_no_charger_is_drawn_every_slot_has_one(tmp_path):
    path, plain = tmp_path / "robot.yaml", tmp_path / "plain.xml"
    path.write_text(ROBOT)
    text = YARD.read_text()
    plain.write_text(text.replace('name="CHARGE"', 'name="Wash"'))
    made = import_layout(plain, robot=path)
    assert made.model.layout.bays["parking"].chargers is None
    assert sum(chargers_at(made.model, made.model.floor).values()) == made.model.fleet.size == 3
    assert "layout.bays.parking.chargers" in {remark.kind for remark in made.remarks}
    assert dw.simulate(made.model.replace({"run.length": 3600, "fleet.start_energy": 0.9})).kpis["tasks"] > 20


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("robot: {radius: 0.4}", "robot.yaml:1:1: robot.speed: missing"),
        ("robot:\n  radius: wide\n  speed: 1", "robot.yaml:2:11: robot.radius: should be a number"),
        ("robot: {radius: 0.4, speed: 1, wheels: 4}", "robot.wheels: unknown key"),
        ("robott: {radius: 0.4, speed: 1}", "did you mean 'robot'?"),
        ("battery: {capacity: 5, threshold: 9, consumption: 1, charge_rate: 1}", "battery.threshold: too large"),
        ("fleet: {size: 3}", "unknown key"),
        ("", "nothing in the file, expected a robot with robot or battery"),
        ("5", "not a mapping"),
    ],
)
def test_a_robot_that_is_none_is_said_with_its_line(tmp_path, text, message):
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    assert message in one_message(YARD, robot=path)


def test_options_that_a_format_does_not_have_are_refused():
    with pytest.raises(dw.ModelError, match="option 'layout': there is none for a plant model of openTCS"):
        dw.read_layout(YARD, layout="ground")
