"""Keys that are removed: `--unset KEY`, in Python `UNSET`."""

import pytest
from click.testing import CliRunner

import desim_warehouse as dw
from desim_warehouse.cli import desim
from desim_warehouse.cli.options import load_model

pytestmark = pytest.mark.usefixtures("brief_probes")

MODEL = "models/multibots.yaml"
FLOWS = {"shelf": {"from": "storage", "to": ["A"], "arrivals": {"poisson": 20}}}


def test_a_key_is_as_if_the_file_never_said_it():
    one = dw.load(MODEL, {"traffic.node_time": 3})
    assert one.replace({"traffic.node_time": dw.UNSET}) == dw.load(MODEL, {"traffic.node_time": dw.UNSET})
    assert one.replace({"traffic": dw.UNSET}).traffic == type(one.traffic)()


def test_goods_become_flows():
    changes = {"tasks.goods": dw.UNSET, "tasks.unload_at": dw.UNSET, "tasks.flows": FLOWS, "run.length": 600}
    changed = dw.load(MODEL, {**changes, "tasks.station_choice": dw.UNSET})
    assert changed.tasks.goods is None
    assert list(changed.tasks.flows) == ["shelf"]


def test_sections_are_removed_before_what_is_set_in_them():
    fresh = dw.load(MODEL, {"traffic.node_time": 3, "traffic": dw.UNSET})
    assert fresh.traffic == type(fresh.traffic)(node_time=3)


def test_a_key_that_is_not_there_may_be_removed_and_makes_no_section():
    model = dw.load(MODEL, {"prices.robot": dw.UNSET, "people.x.per_hour": dw.UNSET})
    assert model == dw.load(MODEL)


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("layout", "missing"),
        ("fleet.sizes", "did you mean 'fleet.size'"),
        ("fleet.start.0", "an entry of a list, which cannot be left out"),
    ],
)
def test_required_unknown_and_list_keys_cannot_be_removed(key, message):
    with pytest.raises(dw.ModelError, match=message):
        dw.load(MODEL, {key: dw.UNSET})


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("layout.storage", "--set layout.storage: should be a list (got nothing); write one, or leave the key out"),
        ("fleet.size", "--set fleet.size: should be a whole number (got nothing); write one"),
        ("fleet.start.0", "--set fleet.start.0: should be text (got nothing); write one"),
        ("policies.allocation", "section with name and parameters (got nothing); write one, or leave the key out"),
    ],
)
def test_nothing_is_a_value_that_few_keys_have_and_the_message_says_what_to_do(key, message):
    with pytest.raises(dw.ModelError) as refused:
        load_model(MODEL, (f"{key}=null", "prices=null"))
    assert str(refused.value).endswith(message)


def test_a_factor_has_values():
    with pytest.raises(dw.ModelError, match="not a value a model file can have"):
        dw.Study(MODEL, {"traffic.node_time": [1, dw.UNSET]})


def test_a_study_removes_keys_for_all_runs():
    made = dw.Study(MODEL, changes={"traffic": dw.UNSET})
    assert made.plan.base.traffic == type(made.plan.base.traffic)()


def test_the_command_line_removes_keys_and_says_so_in_its_commands(tmp_path):
    runner = CliRunner()
    one = runner.invoke(desim, ["run", MODEL, "--unset", "traffic", "--set", "fleet.size=1", "--json"])
    other = runner.invoke(desim, ["run", MODEL, "--set", "traffic={}", "--set", "fleet.size=1", "--json"])
    assert one.exit_code == 0
    assert one.stdout == other.stdout
    bad = runner.invoke(desim, ["check", MODEL, "--unset", "layout"])
    assert isinstance(bad.exception, dw.ModelError)
    page = tmp_path / "page.html"
    vary = ["what-if", MODEL, "--unset", "traffic.node_time", "--vary", "fleet.size=1,2", "--set", "tasks.goods=[11]"]
    done = runner.invoke(desim, [*vary, "--page", str(page), "--quiet"])
    assert done.exit_code == 0, done.exception
    assert "--unset traffic.node_time" in page.read_text()
