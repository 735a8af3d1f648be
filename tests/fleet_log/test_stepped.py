"""A log that another simulator wrote: the stepped reference of the paper, which shares no code with the package."""

import json

import pytest

from desim_warehouse.fleet_log.calibrate import calibrate
from tests.reference import stepped


def doing(warehouse, robot, was):
    """What a robot does in this step, from what can be seen of it: where it stands, and whether it has a load."""
    standing, loaded, since, action = was
    moved = robot.point != standing
    since = 0 if moved else since + 1
    good = robot.good
    if moved or robot.inside:
        action = ""
    if robot.inside and not robot.idle and robot.battery < warehouse.setting.capacity and not robot.awake:
        action = "startCharging"
    at_good = good is not None and robot.point == stepped.place_of(good)[2]
    if not robot.inside and not moved and at_good and not robot.waits_for:
        action = "pick"
        loaded = True
    return robot.point, loaded, since, action


def log_of(setting, path):
    """The messages of a run of the reference, one a step of 50 ms, as the model of the paper has it."""
    warehouse = stepped.Warehouse(setting)
    letters = {point: letter for letter, point in stepped.PLACES.items()}
    last = [robot.home for robot in warehouse.robots]
    seen = [((0.0, 0.0), False, 0, "")] * setting.robots
    lines = []
    while warehouse.delivered < len(setting.goods) or not all(robot.inside for robot in warehouse.robots):
        warehouse.step()
        for n, robot in enumerate(warehouse.robots):
            seen[n] = doing(warehouse, robot, seen[n])
            at = stepped.PLACES[robot.home] if robot.inside else robot.point
            last[n] = letters.get(at, last[n])
            now, action = warehouse.now, seen[n][3]
            lines.append({
                "timestamp": now / 20, "serialNumber": str(n), "lastNodeId": last[n], "loads": [],
                "driving": not robot.inside and not robot.waits_for and not action, "errors": [],
                "agvPosition": {"x": at[0], "y": at[1]},
                "batteryState": {"batteryCharge": 10 * robot.battery, "charging": action == "startCharging"},
                "actionStates": [{"actionId": "1", "actionType": action, "actionStatus": "RUNNING"}] if action else [],
            })  # fmt: skip
    path.write_text("\n".join(map(json.dumps, lines)))


def test_the_figures_of_the_paper_are_found_again(tmp_path):
    goods = tuple((7 * n) % 80 for n in range(24))
    log_of(stepped.Setting(robots=3, goods=goods, consumption=0.006), tmp_path / "log.jsonl")
    estimates = {one.key: one for one in calibrate("models/multibots.yaml", [tmp_path / "log.jsonl"]).estimates}
    assert estimates["fleet.robot.speed"].mean == pytest.approx(4, rel=0.001)
    node = estimates["traffic.node_time"]  # what drives are rounded up by, in whole steps, is spent at nodes, too
    assert node.mean == pytest.approx(stepped.TURN_STEPS + stepped.ROUNDED, abs=0.1)
    assert estimates["tasks.load_time"].mean == pytest.approx(10, abs=0.1)
    assert not estimates["battery.charge_rate"].identified  # there they are full at once
    assert not estimates["tasks.unload_time"].identified  # nothing that can be seen tells it from waiting
