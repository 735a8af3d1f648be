"""A model calibrated from the messages of a fleet with other figures: what is found, and what is not."""

import json
import math
from collections import Counter

import numpy as np
import pytest
from ruamel.yaml import YAML

import desim_warehouse as dw
from desim_warehouse.errors import ReportError
from desim_warehouse.fleet_log.calibrate import calibrate
from desim_warehouse.fleet_log.handling import mean_interval
from desim_warehouse.report.example import example
from desim_warehouse.study.fit import fit_between
from tests.fleet_log import plants
from tests.fleet_log.conftest import plant
from tests.fleet_log.test_reading import message


@pytest.fixture(scope="module")
def calibration(a_plant):
    return calibrate(a_plant.sheet, [a_plant.log])


def by_key(calibration):
    return {one.key: one for one in calibration.estimates}


def test_figures_are_those_of_the_fleet_not_of_the_sheet(calibration, a_plant):
    estimates, truth = by_key(calibration), plants.known(a_plant.truth)
    for key, near in (("fleet.robot.speed", 0.003), ("fleet.robot.speed_loaded", 0.003), ("traffic.node_time", 0.03)):
        assert estimates[key].mean == pytest.approx(truth[key], rel=near, abs=0.02), key
    for key in ("tasks.load_time", "tasks.unload_time", "battery.charge_rate", "battery.consumption.loaded"):
        assert estimates[key].mean == pytest.approx(truth[key], rel=0.2), key
        assert estimates[key].low < estimates[key].mean < estimates[key].high


def test_slow_edges_are_found_edge_for_edge(tmp_path):
    there = plant(tmp_path, 0, hours=0.5)
    members = there.truth["traffic.slow"]["somewhere"]["members"]
    zones = [one for one in calibrate(there.sheet, [there.log]).estimates if one.key.startswith("traffic.slow")]
    assert sorted(edge for zone in zones for edge in zone.value["members"]) == sorted(members)


def test_what_a_second_between_messages_hides_is_said(calibration):
    estimates = by_key(calibration)
    for key in ("fleet.robot.acceleration", "fleet.robot.delays", "battery.taper"):
        assert not estimates[key].identified
        assert estimates[key].why
        assert key not in calibration.overrides


def test_the_file_says_where_each_figure_comes_from(calibration, a_plant):
    out = a_plant.sheet.with_name("calibrated.yaml")
    files = calibration.files(out)
    for path, text in files.items():
        path.write_text(text, encoding="utf-8")
    assert dw.load(out).digest() == calibration.model.digest()
    text = files[out]
    assert "# robots" in text  # the comments of the file stay
    assert "stretches on an edge" in text
    assert "# fleet.robot.acceleration: a second between messages" in text
    ranges = YAML(typ="safe").load(files[out.with_name("calibrated.ranges.yaml")])
    assert set(ranges["fleet.robot.speed"]) == {"low", "high", "confidence", "n"}
    for key in ranges:
        assert dw.load(out, {key: ranges[key]["low"]}), key  # every range is of a key that can be set


def test_estimates_print_as_lines_and_as_a_table(calibration):
    lines = str(calibration).splitlines()
    assert "day.jsonl: 8 robots" in lines[0]
    head = lines.index(next(line for line in lines if line.startswith("figure")))
    assert lines[head].split("  ")[-1] == "from"
    assert lines[head + 1].startswith("Speed (m per s)")
    assert lines[head + 1].endswith(" stretches on an edge")
    assert lines[-1].startswith("a log does not show who is sent where")
    identified = sum(one.identified for one in calibration.estimates)
    share = f"{identified} of {len(calibration.estimates)} figures identified"
    assert repr(calibration) == f"Calibration({calibration.base.name}: {share})"
    assert list(calibration.table["key"]) == [one.key for one in calibration.estimates]
    assert calibration.table["mean"].notna().sum() >= identified


def test_a_model_in_memory_is_calibrated_as_a_file_is(tmp_path):
    """200 trips that begin half a minute after each other: 120 loads an hour."""
    trips = tmp_path / "trips.csv"
    trips.write_text("robot,pick,drop,start,end\n" + "".join(f"R1,A,G,{30 * n},{30 * n + 20}\n" for n in range(200)))
    calibration = calibrate(example(), [trips])
    out = tmp_path / "calibrated.yaml"
    out.write_text(calibration.files(out)[out], encoding="utf-8")
    assert "Calibrated by desim calibrate" in out.read_text(encoding="utf-8")
    assert dw.load(out).tasks.goods.poisson == pytest.approx(120, rel=0.01)
    assert dw.load(out).digest() == calibration.model.digest()


def test_orders_are_taken_as_they_are(a_plant, tmp_path):
    orders = tmp_path / "orders.csv"
    orders.write_text("release,from\n0,1\n60,2\n")
    log = tmp_path / "short.jsonl"
    log.write_text("\n".join(a_plant.log.read_text(encoding="utf-8").splitlines()[:2000]))
    calibration = calibrate(a_plant.sheet, [log], orders=orders)
    assert list(calibration.model.tasks.flows) == ["orders"]
    assert calibration.model.tasks.flows["orders"].when.orders.file == str(orders)
    out = a_plant.sheet.with_name("with_orders.yaml")
    out.write_text(calibration.files(out)[out], encoding="utf-8")
    assert "file: ../" in out.read_text(encoding="utf-8")  # named from the folder of the model
    written = dw.load(out).tasks.flows["orders"].when.orders
    assert written.sha256 == calibration.model.tasks.flows["orders"].when.orders.sha256


def test_trips_alone_give_the_demand(a_plant, tmp_path):
    trips = tmp_path / "trips.csv"
    rows = [f"R1,A,G,{30 * n},{30 * n + 20}" for n in range(200)]
    trips.write_text("\n".join(["robot,pick,drop,start,end", *rows]))
    calibration = calibrate(a_plant.sheet, [trips])
    assert list(calibration.overrides) == ["tasks.goods.poisson"]
    assert calibration.overrides["tasks.goods.poisson"] == pytest.approx(120, rel=0.01)


def test_demand_that_changes_by_the_hour_becomes_a_profile(a_plant, tmp_path):
    trips = tmp_path / "trips.csv"
    starts = [*np.linspace(0, 3599, 30), *np.linspace(3600, 7199, 120)]
    trips.write_text("\n".join(["robot,pick,drop,start,end", *(f"R1,A,G,{start},{start + 1}" for start in starts)]))
    model = calibrate(a_plant.sheet, [trips]).model
    assert model.tasks.flows["orders"].arrivals.profile.per_hour == pytest.approx((30, 120), rel=0.05)


def test_another_floor_is_refused(a_plant, tmp_path):
    log = tmp_path / "strange.jsonl"
    lines = a_plant.log.read_text(encoding="utf-8").splitlines()[:2000]
    log.write_text("\n".join(lines).replace('"lastNodeId": "', '"lastNodeId": "X-'))
    with pytest.raises(ReportError, match=r"nodes that the model does not have.*X-"):
        calibrate(a_plant.sheet, [log])


def test_a_rare_breakdown_keeps_its_interval(tmp_path):
    lines = []
    for second in range(1200):
        fault = [{"errorType": "x", "errorLevel": "FATAL"}] if 600 <= second < 660 else []
        lines.append(message(second, node="AB"[second // 10 % 2], errors=fault))
    (tmp_path / "log.jsonl").write_text("\n".join(map(json.dumps, lines)))
    (tmp_path / "sheet.yaml").write_text(plants.sheet(np.random.default_rng(0)))
    estimates = by_key(calibrate(tmp_path / "sheet.yaml", [tmp_path / "log.jsonl"]))
    every, repair = estimates["fleet.robot.breakdowns.every"], estimates["fleet.robot.breakdowns.repair"]
    assert every.n == repair.n == 1
    assert every.mean == pytest.approx(1139, abs=2)  # in operation
    assert every.low == pytest.approx(2 * 1139 / 11.14, rel=0.01)  # chi-square with 4 degrees of freedom
    assert every.high == pytest.approx(2 * 1139 / 0.0506, rel=0.01)  # with 2
    assert repair.mean == pytest.approx(60)
    assert math.isfinite(repair.high)


def test_times_between_messages_have_the_right_mean_and_family():
    rng = np.random.default_rng(3)
    kinds = Counter()
    for _ in range(2):
        times = rng.lognormal(np.log(3) - 0.18, 0.6, 800)
        start = rng.uniform(0, 1, 800)
        begun = np.stack([np.zeros(800), np.ones(800)], axis=1)
        end = np.floor(start + times)
        fitted = fit_between(begun, np.stack([end, end + 1], axis=1))
        assert fitted.mean == pytest.approx(3, rel=0.06)
        kinds[fitted.kind] += 1
    assert kinds["lognormal"] == 2


def test_the_interval_of_a_few_skewed_times_covers_their_mean():
    rng = np.random.default_rng(1)
    hits = 0
    for _ in range(400):
        low, high = mean_interval(rng.lognormal(-0.125, 0.5, 6))
        hits += low <= 1 <= high
    assert 0.93 <= hits / 400 <= 0.99
