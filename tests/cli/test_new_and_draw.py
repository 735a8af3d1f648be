"""A first model from a few words, and the picture of a floor."""

import json
import shlex
from xml.etree import ElementTree as ET

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.draft import Draft, draft, read_size
from desim_warehouse.folders import gallery
from desim_warehouse.model.parse import read_yaml
from desim_warehouse.plot import floor
from desim_warehouse.questions.check import check
from tests.docs import pages

pytestmark = pytest.mark.usefixtures("brief_probes")


def call(*arguments, **options):
    return CliRunner().invoke(desim, arguments, catch_exceptions=False, **options)


def model_of(words):
    return dw.Model.model_validate(read_yaml(draft(words), "draft").data)


def test_a_few_words_make_a_model_that_works(tmp_path):
    file = str(tmp_path / "w.yaml")
    done = call("new", file, *shlex.split("--aisles 8 --stations 3 --robots 12 --orders 200/h --chargers 4"))
    assert done.exit_code == 0
    counts = "8 aisles, 3 packing stations, 12 robots, 4 chargers"
    assert done.stdout.startswith(f"60 x 40 m, {counts}, 200 orders an hour = 4,800 orders a day, due in 15 min.")
    model = dw.load(file)
    blocks = model.layout.blocks
    assert (blocks.columns + 1, model.fleet.size, model.tasks.goods.poisson) == (8, 12, 200)
    # storage and aisles fill the floor: 7 x 2 places and 8 aisles, 2 x 12 places and 3 cross aisles
    assert 14 * 1.2 + 8 * blocks.aisle_width == pytest.approx(60)
    assert 24 * 1.2 + 3 * blocks.cross_aisle_width == pytest.approx(40, abs=0.01)
    report = check(model)
    assert not report.findings
    assert report.calculation.power.chargers == 4
    kpis = dw.simulate(model.replace({"run": {"length": 7200}, "fleet.start_energy": 1})).kpis
    assert kpis["on_time"] > 0.95
    assert model.tasks.goods.due_within == 900


def test_a_draft_of_two_floors_has_shelves_on_both_and_works(tmp_path):
    file = str(tmp_path / "mezz.yaml")
    output = call("new", file, *shlex.split("--size 30x20 --floors 2 --lifts 1 --orders 90/h")).stdout
    assert output.startswith("2 floors of 30 x 20 m, 5 aisles on each, 1 lift, 1 packing station, 6 robots, ")
    model = dw.load(file)
    floor = model.floor
    assert floor.floor_titles == {0: "ground floor", 1: "floor 1"}
    # blocks on both floors, all work but the fetching on the ground floor
    assert [floor.floors[place.edge[0]] for place in floor.storage] == [0] * 88 + [1] * 88
    assert {floor.floors[node] for node in (*floor.bays, *floor.stations)} == {0}
    assert not check(model).findings
    run = dw.simulate(model.replace({"run": {"length": 7200}, "fleet.start_energy": 1}))
    assert run.kpis["on_time"] > 0.9
    assert run.kpis["share_in_lift"] > 0.05
    assert "drawn side by side: A1 is above A\n" in (tmp_path / "mezz.yaml").read_text()


@pytest.mark.parametrize(
    ("words", "cabins"),
    [
        ("--floors 2 --orders 20/h", {"goods": 1}),  # as many as the orders need
        pytest.param("--floors 2 --lifts 2 --robots 5", {"goods1": 1, "goods2": 1}, marks=pytest.mark.long),
        ("--floors 3 --size 20x12 --aisles 2 --lifts 3 --robots 4 --orders 30/h", {"goods": 3}),  # one end is left
    ],
)
def test_lifts_of_a_draft_stand_apart_while_there_are_ends_of_aisles(tmp_path, words, cabins):
    file = str(tmp_path / "w.yaml")
    assert call("new", file, *shlex.split(words), "--chargers", "2").exit_code == 0
    model = dw.load(file)
    assert {name: lift.cabins for name, lift in model.layout.lifts.items()} == cabins
    assert (model.policies.routing.name == "congestion-aware") == (sum(cabins.values()) > 1)
    assert not check(model).errors


SOME = settings(max_examples=max(settings.default.max_examples // 10, 2))
"""What check tries of a night takes a second."""


@pytest.mark.long
def test_a_draft_of_a_very_large_hall_passes_the_check_without_errors():
    assert not check(model_of(Draft(size=(150, 150), orders=600))).errors


@SOME
@given(
    width=st.integers(8, 60),
    height=st.integers(8, 60),
    orders=st.integers(1, 300),
    robots=st.none() | st.integers(1, 60),
    chargers=st.none() | st.integers(1, 30),
)
def test_every_draft_passes_the_check_without_errors(width, height, orders, robots, chargers):
    model = model_of(Draft(size=(width, height), orders=orders, robots=robots, chargers=chargers))
    assert not check(model).errors


@SOME
@given(orders=st.integers(10, 300))
def test_what_is_not_given_suffices_by_hand(orders):
    calculation = check(model_of(Draft(size=(30, 20), orders=orders))).calculation
    assert calculation.robots >= calculation.robots_busy
    assert calculation.station_capacity >= calculation.rate
    assert not calculation.power.short


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("--size 60", "--size 60: not a floor, expected width x height such as 60x40 (metres) or 200x130ft"),
        ("--orders 5/x", "--orders 5/x: not a rate, expected orders an hour such as 200/h, or a day such as 1600/d"),
        ("--orders 0", "--orders 0: not a rate, expected orders an hour such as 200/h, or a day such as 1600/d"),
        ("--aisles 90", "--aisles 90: too many for 60 m (each would be -1.7 m wide), expected at most 18"),
        ("--aisles 1", "--aisles 1: too few, expected at least 2: robots go up one and down another"),
        ("--size 20x5", "--size 20x5: too small, expected at least 4.4 x 7.2 m"),
        ("--size 2x2", "--size 2x2: too small, expected at least 4.4 x 7.2 m"),
        ("--size 4.3x40 --aisles 2", "--size 4.3x40: too small, expected at least 4.4 x 7.2 m"),
        ("--robots 0", "--robots 0: out of range, expected 1 to 1000"),
        ("--stations 9 --aisles 8", "--stations 9: out of range, expected 1 to 8"),
        ("--lifts 1", "--lifts 1: one floor has no lift, expected --floors 2 or more beside it"),
        ("--floors 0", "--floors 0: out of range, expected 1 to 20"),
        ("--floors 2 --lifts 0", "--lifts 0: out of range, expected 1 to 8"),
        ("--floors 2 --lifts 9", "--lifts 9: out of range, expected 1 to 8"),
        (
            "--floors 4 --orders 3000/h",
            "--orders 3000/h: takes 62 lifts, expected fewer orders, or --lifts, at most 8",
        ),
        (
            "--floors 2 --size 20x12 --aisles 2 --orders 30/h --inbound 10/h",
            "--aisles 2: no end of an aisle is left for lifts, expected more aisles",
        ),
        ("--packers 1000000000 --stations 2", "--packers 1000000000: out of range, expected 1 to 20000"),
        ("--orders 200000/h", "--orders 200000/h: too many, expected at most 100000/h"),
        ("--inbound 4000/min", "--inbound 4000/min: too many, expected at most 100000/h"),
        (
            "--size 3000x3000",
            (
                "desim new:14:18: layout.blocks.block_depth: too large (got 2224440), expected at most 1,000,000 "
                "(storage places)"
            ),
        ),
        (
            "--orders 20000/h --peak 10-11x20 --shifts 06-22",
            (
                "desim new:37:20: tasks.goods.poisson: too large (got 400000), expected at most 100,000 (tasks "
                "arriving per hour (poisson))"
            ),
        ),
    ],
)
def test_what_cannot_be_is_said_at_its_option(tmp_path, words, expected):
    status, _, message = pages.run_desim(f"desim new {tmp_path / 'w.yaml'} {words}")
    assert (status, message.strip()) == (2, expected)
    assert not (tmp_path / "w.yaml").exists()


@pytest.mark.parametrize(("due", "seconds"), [("20", 1200), ("20min", 1200), ("0.5 h", 1800), ("90s", 90)])
def test_due_is_in_minutes_or_in_the_unit_that_stands_there(tmp_path, due, seconds):
    file = tmp_path / "w.yaml"
    assert call("new", str(file), "--robots", "2", "--chargers", "1", "--due", due).exit_code == 0
    assert dw.load(file).tasks.goods.due_within == seconds
    assert "not above 0" in pages.run_desim(f"desim new {file} --force --due 0")[2]
    assert "not a time (got '20 kg')" in pages.run_desim(f"desim new {file} --force --due '20 kg'")[2]


def test_a_file_that_is_there_stays_as_it_is(tmp_path):
    file = tmp_path / "w.yaml"
    file.write_text("mine", encoding="utf-8")
    status, _, message = pages.run_desim(f"desim new {file}")
    assert (status, file.read_text(encoding="utf-8")) == (2, "mine")
    assert message == f"{file}: the file exists; choose another name, or overwrite it with --force\n"
    assert pages.run_desim(f"desim new {file} --force")[0] == 0
    assert dw.load(file).fleet.size > 1


def test_bare_in_a_terminal_it_asks(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert call("new").exit_code == 2
    monkeypatch.setattr("click.testing._NamedTextIOWrapper.isatty", lambda _: True, raising=False)
    done = call("new", input="mine.yaml\n30x20\n60/h\n10\n\n\n\n\n\n4\n1\nmany\n5\n\n")
    assert done.exit_code == 0, done.output
    assert "many: not a number" in done.output
    model = dw.load("mine.yaml")
    assert (model.layout.blocks.columns, model.fleet.size) == (3, 5)
    assert (model.tasks.goods.poisson, model.tasks.goods.due_within) == (60, 600)


def test_an_answer_that_cannot_be_is_asked_again_at_once(tmp_path, monkeypatch):
    """Each wrong answer stands before the right one; at the end, the lanes of the floor do not hold 900 robots."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text("mine")
    monkeypatch.setattr("click.testing._NamedTextIOWrapper.isatty", lambda _: True, raising=False)
    answers = [
        ("mine.yaml", "none/new.yaml", "new.yaml"),
        ("40", "2x2", "30x20"),
        ("60/x", "60/h"),
        ("soon", "10"),
        ("26", "always"),
        ("1x1", "none"),
        ("0", "2"),
        ("0/h", "none"),
        ("0", "one"),
        ("90", "4"),
        ("9", "2"),
        ("900",),  # robots
        ("1",),
        ("5",),  # robots, again
    ]
    asked = call("new", input="".join(f"{reply}\n" for replies in answers for reply in replies))
    assert asked.exit_code == 0, asked.output
    problems = [line for line in asked.output.splitlines() if line.startswith("Error: ")]
    assert [problem.split(": ")[1].split(" ")[0] for problem in problems] == [
        "mine.yaml", "none/new.yaml", "size", "size", "orders", "not", "shifts", "peak", "packers", "inbound", "floors",
        "aisles", "stations", "robots",
    ]  # fmt: skip
    model = dw.load("new.yaml")
    assert (model.layout.blocks.columns, model.fleet.size) == (3, 5)


def test_asked_for_it_takes_a_working_day(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("click.testing._NamedTextIOWrapper.isatty", lambda _: True, raising=False)
    done = call("new", input="day.yaml\n30x20\n60/h\n10\n07-19\n11-12x2\n2\n20/h\n\n4\n1\n5\n\n")
    assert done.exit_code == 0, done.output
    assert "2 packers" in done.output
    assert (
        "60 orders an hour from 07:00 to 19:00 with 2 times as many from 11:00 to 12:00 = 780 orders a day"
        in done.output
    )
    assert set(dw.load("day.yaml").tasks.flows) == {"orders", "inbound"}


@pytest.mark.long  # every day one that a stranger's folder has, in test_strangers.py
def test_a_floor_is_drawn_as_a_picture_of_dots(tmp_path):
    assert call("draw", "models/mir250.yaml", "-o", str(tmp_path / "floor.png")).exit_code == 0
    assert (tmp_path / "floor.png").read_bytes().startswith(b"\x89PNG")


def test_a_floor_is_drawn_with_all_its_names(tmp_path):
    assert call("draw", "models/mir250.yaml", "-o", str(tmp_path / "floor.svg")).exit_code == 0
    tree = ET.parse(tmp_path / "floor.svg")  # noqa: S314 - our own file
    words = {text.text for text in tree.iter("{http://www.w3.org/2000/svg}text")}
    model = dw.load("models/mir250.yaml")
    from desim_warehouse.layout import build

    assert set(build(model.layout).graph) <= words
    assert {"MiR250", "charging", "parking", "packing", "charger", "bay", "station"} <= words


@pytest.mark.parametrize(("columns", "named"), [(40, True), (90, False)])
def test_nodes_have_names_where_they_can_be_read(tmp_path, columns, named):
    goal = {"layout.stations.packing.at": ["r1c1"], "tasks.unload_at": ["packing"]}
    model = dw.load("models/tutorial.yaml").replace({"layout.blocks.columns": columns, **goal})
    path = tmp_path / "floor.svg"
    floor.save(model, path)
    words = {text.text for text in ET.parse(path).iter("{http://www.w3.org/2000/svg}text")}  # noqa: S314 - our own
    assert (set(model.floor.graph) <= words) == named
    assert set(model.layout.bays) <= words


def test_a_picture_of_no_known_kind_is_refused(tmp_path):
    status, _, message = pages.run_desim(f"desim draw models/tutorial.yaml -o {tmp_path / 'floor.jpg'}")
    assert status == 2
    assert message.endswith("floor.jpg: a picture of which kind? Expected a name that ends in .png, .svg or .pdf\n")
    status, _, message = pages.run_desim(f"desim draw models/tutorial.yaml -o {tmp_path / 'no' / 'floor.svg'}")
    assert (status, "cannot be written (No such file or directory)" in message) == (2, True)


@pytest.mark.parametrize("name", gallery())
def test_a_warehouse_of_the_gallery_is_copied_and_small_enough_to_be_read(name, tmp_path):
    file = tmp_path / "mine.yaml"
    done = call("new", str(file), "--like", name)
    assert done.exit_code == 0
    assert done.stdout.endswith(f"{file} is written; next: desim check {file}\n")
    assert file.read_text(encoding="utf-8") == gallery()[name].read_text(encoding="utf-8")
    assert len(file.read_text(encoding="utf-8").splitlines()) <= 60
    assert "(!)" in file.read_text(encoding="utf-8")
    with pytest.raises(dw.ModelError, match="the file exists"):
        call("new", str(file), "--like", name)
    page = (pages.ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    assert f"--like {name}\n" in page
    assert f"pictures/gallery-{name}.png" in page


def test_words_beside_a_warehouse_of_the_gallery_are_refused(tmp_path):
    done = CliRunner().invoke(
        desim, ["new", str(tmp_path / "x.yaml"), "--like", "pallets", "--due", "3", "--robots", "4"]
    )
    assert done.exit_code == 2
    assert "--robots and --due: not with --like" in done.output
    assert not list(tmp_path.iterdir())


def test_a_new_model_brings_its_schema_and_the_line_that_editors_read(tmp_path):
    file, schema = tmp_path / "w.yaml", tmp_path / "w.schema.json"
    assert call("new", str(file), "--schema").exit_code == 0
    assert file.read_text().splitlines()[0] == f"# yaml-language-server: $schema={schema.name}"
    assert json.loads(schema.read_text()) == dw.schema()
    assert dw.load(file) == dw.Model.model_validate(read_yaml(file.read_text(), "w").data)
    file.unlink()
    with pytest.raises(dw.ModelError, match=r"w\.schema\.json: the file exists"):
        call("new", str(file), "--schema")
    assert not file.exists()
    assert call("new", str(file), "--schema", "--force").exit_code == 0


@pytest.mark.parametrize(
    ("text", "sides"),
    [
        ("240x160ft", (73.152, 48.768)),
        ("240 ft x 160 ft", (73.152, 48.768)),
        ("60x40", (60, 40)),
        ("60 × 40.5 m", (60, 40.5)),
        ("0.06kmX4000cm", (60, 40)),
        ("2880*1920in", (73.152, 48.768)),
    ],
)
def test_a_floor_is_in_metres_or_in_the_unit_that_is_said(text, sides):
    assert read_size(text) == pytest.approx(sides, rel=1e-15)


@pytest.mark.parametrize("text", ["240ftx160", "240x160 yards", "0x40", "-60x40", "60x40x20"])
def test_what_is_no_floor_is_refused(text):
    with pytest.raises(dw.ModelError, match="not a floor"):
        read_size(text)
