"""A plant that was imported, so storage stands at nodes, and edges have no places beside them."""

import numpy as np
import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.fleet_log.calibrate import calibrate
from desim_warehouse.fleet_log.measures import measured, parts_of
from desim_warehouse.fleet_log.ranks import LEVEL, ranked
from desim_warehouse.fleet_log.runs import from_run
from desim_warehouse.fleet_log.validate import validate

NODES = """\
name,x,y,role,station
A,0,0,,
B,10,0,load,rack B
C,20,0,load,rack C
D,20,8,,
E,0,8,park,
pack,24,8,unload,table
"""
EDGES = "from,to,two-way\nA,B,\nB,C,\nC,D,\nD,E,\nE,A,\nD,pack,yes\n"
OFTEN_AT_C = {"tasks.popularity": {"weights": [1.0, 5.0]}}


@pytest.fixture(scope="module")
def ring(tmp_path_factory):
    """The model file of a ring with racks at B and C."""
    folder = tmp_path_factory.mktemp("ring")
    (folder / "nodes.csv").write_text(NODES)
    (folder / "edges.csv").write_text(EDGES)
    out = folder / "ring.yaml"
    done = CliRunner().invoke(desim, ["import", str(folder / "nodes.csv"), "--fleet", "2", "-o", str(out)])
    assert done.exit_code == 0, done.output
    out.write_text(out.read_text().replace("{saturated: fleet}", "{poisson: 60}"))
    return out


@pytest.fixture(scope="module")
def day(ring):
    """A day of its fleet, which picks five times as often at C as at B."""
    return from_run(dw.simulate(dw.load(ring, {"run.length": 10800, "log": "all", **OFTEN_AT_C}), 5))


def test_storage_at_nodes_is_calibrated(ring, day):
    model = dw.load(ring)
    assert [place.edge for place in model.floor.storage] == [("B", "B"), ("C", "C")]
    calibration = calibrate(ring, [day])
    [popularity] = [one for one in calibration.estimates if one.key == "tasks.popularity"]
    at_b, at_c = popularity.value["weights"]
    assert at_c / at_b == pytest.approx(5, rel=0.35)
    assert calibration.model.floor.storage == model.floor.storage


def test_measures_of_a_day_with_storage_at_nodes_are_its_indicators(ring):
    model = dw.load(ring, {"run.length": 3600, "log": "all", **OFTEN_AT_C})
    run = dw.simulate(model, 5)
    one = from_run(run)
    measures = measured(model, one, parts_of(model, one)).figures
    for name in ("share_loading", "share_unloading"):
        assert measures[name] == pytest.approx(run.kpis[name], abs=0.005)
    assert sum(share for name, share in measures.items() if name.startswith("share_")) == pytest.approx(1)


@pytest.mark.long
def test_storage_at_nodes_is_validated(ring, day):
    assert not validate(dw.load(ring, OFTEN_AT_C), [day], runs=39).refuted


def test_a_place_at_a_node_is_where_the_node_is(ring):
    floor = dw.load(ring).floor
    assert [floor.position(place.edge, place.offset) for place in floor.storage] == [(10, 0), (20, 0)]


def figures(model, seeds):
    """A row of measures for each simulated hour."""
    days = (from_run(dw.simulate(model, seed), 2.0) for seed in seeds)
    return np.array([list(measured(model, one, parts_of(model, one)).figures.values()) for one in days])


@pytest.mark.long
def test_right_models_stay_unrefuted_and_wrong_ones_are_refuted(ring):
    """Of 20 hours of the fleet one refutes the right model, on average: more than three do once in 60 times."""
    true = {"run.length": 3600, "log": "all", **OFTEN_AT_C}
    real, right = figures(dw.load(ring, true), range(100, 120)), figures(dw.load(ring, true), range(39))
    wrong = figures(dw.load(ring, true | {"tasks.unload_time": 20}), range(39))  # for 15
    refuted = []
    for pool in (right, wrong):
        usable = np.isfinite(real).all(axis=0) & np.isfinite(pool).all(axis=0) & (pool.std(axis=0) > 0)
        refuted.append(sum(ranked(one[None, usable], pool[None][:, :, usable]).p_value <= LEVEL for one in real))
    assert refuted[0] <= 3
    assert refuted[1] >= 18
