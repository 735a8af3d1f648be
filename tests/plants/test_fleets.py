"""Another fleet on an imported plant: the floor stays the same, and every robot finds a slot."""

import contextlib
from collections import Counter
from pathlib import Path

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.plants import import_layout
from desim_warehouse.questions.check import check
from desim_warehouse.questions.run.warehouse import work
from desim_warehouse.study.fleet.designs import Designs
from desim_warehouse.study.possible import refused
from tests.auditor import audit
from tests.plants.drawings import DRAWN
from tests.plants.foreign import FOLDER, needs_plants, with_enough_chargers

pytestmark = pytest.mark.usefixtures("brief_probes")

FLEETS = (2, 8, 20)


@pytest.mark.parametrize("name", ["opentcs", "lif", "rmf", "tables", "kiva"])
def test_a_plant_imported_for_another_fleet_differs_in_the_fleet_alone(name, tmp_path):
    """Its work, too: with as many open tasks as robots, 20 of them find goods near by more often than 2."""
    path = DRAWN[name](tmp_path)
    drawn = import_layout(path).model
    for robots in FLEETS:
        asked = import_layout(path, robots=robots).model
        assert (asked.layout, asked.tasks) == (drawn.layout, drawn.tasks)


def test_as_many_tasks_are_open_as_there_are_robots(tmp_path):
    model = import_layout(DRAWN["kiva"](tmp_path)).model.replace({"run.length": 600, "log": "all"})
    for robots in (2, 5):
        run = dw.simulate(model.replace({"fleet.size": robots}))
        assert (
            run.record.rows
            == dw.simulate(model.replace({"fleet.size": robots, "tasks.goods.saturated": robots})).record.rows
        )
        released = [task.released for task in run.history.tasks.values()]
        assert released.count(0) == 2 * robots  # one for each robot, and as many again in place of those taken
        assert f"{robots} tasks always open, without end" in work(run.model)


@pytest.mark.parametrize("name", ["opentcs", pytest.param("rmf", marks=pytest.mark.long), "kiva"])
def test_another_fleet_needs_no_other_import(name, tmp_path):
    model = import_layout(DRAWN[name](tmp_path)).model
    for robots in FLEETS:
        run = dw.simulate(model.replace({"fleet.size": robots, "run.length": 1800, "fleet.start_energy": 0.9}))
        assert run.kpis["tasks"] > 0
        assert audit(run) == []
        slots = Counter(model.replace({"fleet.size": robots}).fleet.homes(model.floor.bays))
        assert sum(slots.values()) == robots


def test_bays_grow_where_they_are_told_to(tmp_path):
    model = import_layout(DRAWN["opentcs"](tmp_path)).model
    bay = next(iter(model.layout.bays))
    grown = model.replace({"fleet.size": 5})
    assert not [finding for finding in check(grown).findings if finding.level == "error"]
    fixed = model.replace({"fleet.size": 5, **{f"layout.bays.{name}.grows": False for name in model.layout.bays}})
    assert "TOO_FEW_PLACES" in {finding.code for finding in check(fixed).findings}
    with pytest.raises(dw.ModelError, match="the node itself, expected grows only off the lane"):
        model.replace({f"layout.bays.{bay}.in_lane": True})


def test_plan_searches_robots_and_chargers_of_an_imported_plant(tmp_path):
    model = import_layout(DRAWN["opentcs"](tmp_path)).model.replace({"run.length": 1800, "fleet.kinds": {}})
    designs = Designs(model, [2, 3], [1, 2, 3])
    for design in ((2, 1), (3, 3), (8, 2)):
        assert refused(model, designs.overrides(design)) is None


def test_batteries_of_an_imported_plant_start_settled_as_full_ones_would_fall(tmp_path):
    model = import_layout(DRAWN["opentcs"](tmp_path)).model
    assert model.fleet.start_energy == "settled"
    full = dw.simulate(model.replace({"fleet.kinds": {}, "fleet.size": 4, "run.length": 7200, "fleet.start_energy": 1}))
    assert "NOT_SETTLED" in {verdict.code for verdict in full.verdicts}


@pytest.mark.long  # that they start so is seen every day, and what plan makes of it in tests/study
def test_batteries_of_an_imported_plant_are_settled_so_that_plan_names_a_fleet(tmp_path):
    model = import_layout(DRAWN["opentcs"](tmp_path)).model.replace({"fleet.kinds": {}, "fleet.size": 4})
    plan = dw.plan(
        model, target="throughput_per_hour >= 100", robots=[4], chargers=[1], search=dw.Search(first=2, cap=3)
    )
    assert (plan.today.best.robots, plan.today.best.chargers) == (4, 1)


def test_a_robot_that_never_rests_does_not_keep_the_only_charger(tmp_path):
    """Lanes are two-way, so robots under way keep a slot. Two of them work all the time, and one slot has a charger."""
    changes = {"fleet.kinds": {}, "fleet.size": 2, "policies.charging": "threshold"}
    changes |= {"run.length": 4 * 3600, "fleet.start_energy": 0.5}
    run = dw.simulate(import_layout(DRAWN["opentcs"](tmp_path)).model.replace(changes))
    assert audit(run) == []
    assert (run.robots["recharged"] > 0).all()
    assert run.robots["idle"].max() < 100


def foreign():
    """All files of plants that lie there, but schemas, orders, and a problem of 400 robots."""
    if FOLDER is None:
        return []
    files = (one for one in sorted(Path(FOLDER).rglob("*")) if one.suffix in {".xml", ".json", ".yaml", ".map"})
    return [
        one for one in files if "schema" not in one.name and one.stem not in {"transport-orders", "random-example_400"}
    ]


def test_chargers_that_check_asks_for_fit_into_a_bay_that_grows(tmp_path):
    model = import_layout(DRAWN["opentcs"](tmp_path)).model
    short = model.replace({"fleet.size": 8, "battery.charge_rate": model.battery.charge_rate / 8})
    assert "CHARGERS_SHORT" in {finding.code for finding in check(short).findings}
    enough = with_enough_chargers(short)
    bay = next(bay for bay in enough.floor.bays.values() if bay.zone == "chargers")
    assert bay.slots(homes=0) == bay.chargers > 1
    assert "CHARGERS_SHORT" not in {finding.code for finding in check(enough).findings}


def test_size_of_a_plant_with_too_few_chargers_names_them_and_not_the_range(tmp_path):
    """A wider range would do no good: the more robots, the faster their batteries fall."""
    plant = import_layout(DRAWN["opentcs"](tmp_path))
    (tmp_path / "yard.yaml").write_text(plant.text())
    slow = f"battery.charge_rate={plant.model.battery.charge_rate / 20:g}"
    asked = ["yard.yaml", "--range", "3..5", "--target", "throughput_per_hour >= 20", "--set", "fleet.kinds={}"]
    short = ["--set", slow, "--set", "run.length=20min", "--first", "4", "--cap", "4", "--search", "scan", "--quiet"]
    with contextlib.chdir(tmp_path):
        output = CliRunner().invoke(desim, ["size", *asked, *short]).output
    assert output.count("cannot last") == 3
    assert "3 robots  batteries fall by " in output
    assert "within --range 3..5: more chargers, which desim plan looks for, too, or ask for less" in output


@needs_plants
@pytest.mark.long
@pytest.mark.parametrize("path", foreign(), ids=lambda path: path.name)
def test_a_shift_on_every_plant_with_other_fleets(path):
    try:
        model = import_layout(path).model
    except dw.ModelError as error:
        pytest.skip(str(error)[:200])
    model = model.replace({"run.length": 8 * 3600, "log": "tasks"})
    done = []
    for robots in FLEETS:
        run = dw.simulate(with_enough_chargers(model.replace({"fleet.size": robots})))
        done.append(run.kpis["tasks"])
        assert done[-1] > 0
    assert max(done) > done[0] * 0.9
