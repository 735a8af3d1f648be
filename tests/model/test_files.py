"""Models and overrides from elsewhere: which files they may name, and that no message shows what is in them."""

import json

import pytest
from ruamel.yaml import YAML

import desim_warehouse as dw

INSIDE = "root:x:0:0:very secret:/root"
POLICY = "from desim_warehouse.policies.parking import Home\n\nclass Mine(Home):\n    pass\n"
NAMED = {
    "tasks.popularity": lambda name: {"file": name, "column": "weight"},
    "tasks.load_time": lambda name: {"empirical": {"file": name, "column": "weight"}},
    "layout.storage": lambda name: {"file": name},
    "layout": lambda name: {"file": name},
    "tasks.flows": lambda name: {"in": {"from_to": {"file": name}, "arrivals": {"poisson": 1}}},
    "policies.parking": lambda name: f"{name}:Mine",
}
"""Every key that names files."""


@pytest.fixture
def at(tmp_path):
    """A model in a folder of its own, with files in it, beside it, and behind links that lead out of it."""
    folder = tmp_path / "model"
    (folder / "below").mkdir(parents=True)
    for place in (tmp_path, folder / "below"):
        (place / "secret.csv").write_text(f"{INSIDE}\n1,2\n")
        (place / "weights.csv").write_text("weight\n" + "1\n" * 8)
        (place / "mine.py").write_text(POLICY)
    (folder / "link.csv").symlink_to(tmp_path / "secret.csv")
    (folder / "link.py").symlink_to(tmp_path / "mine.py")
    (folder / "elsewhere").symlink_to(tmp_path)
    (folder / "back.csv").symlink_to(folder / "below" / "weights.csv")
    content = dw.load("models/multibots.yaml").content()
    (folder / "w.yaml").write_text(json.dumps(content))
    return folder


def refusal(at, overrides, **how):
    with pytest.raises(dw.ModelError) as refused:
        dw.load(at / "w.yaml", overrides, **how)
    return str(refused.value)


OUTSIDE = ["../secret.csv", "link.csv", "elsewhere/secret.csv", "below/../../secret.csv", "/etc/passwd", "no\0name"]


@pytest.mark.parametrize("key", NAMED)
@pytest.mark.parametrize("name", OUTSIDE)
def test_beside_reads_only_below_the_folder_of_the_model(at, key, name):
    name = name.replace(".csv", ".py") if key.startswith("policies") else name
    message = refusal(at, {key: NAMED[key](name)}, files="beside")
    assert "not a file below the folder of the model" in message
    assert "very secret" not in message
    assert "root:" not in message


@pytest.mark.parametrize("key", NAMED)
def test_none_reads_no_file_at_all(at, key):
    for name in ("below/weights.csv", "below/mine.py", "../secret.csv"):
        message = refusal(at, {key: NAMED[key](name)}, files="none")
        assert "expected none here (files: none)" in message


def test_beside_and_none_refuse_modules_too(at):
    for files in ("beside", "none"):
        assert "files" in refusal(at, {"policies.parking": "os.path:Mine"}, files=files)


def test_orders_are_files_too(at):
    (at / "orders.csv").write_text("release\n1\n")
    (at.parent / "orders.csv").write_text("release\n1\n")

    def flows(name):
        return {"tasks": {"flows": {"in": {"from": "storage", "to": ["A"], "arrivals": {"orders": {"file": name}}}}}}

    assert "below the folder" in refusal(at, flows("../orders.csv"), files="beside")
    assert "files: none" in refusal(at, flows("orders.csv"), files="none")


@pytest.mark.parametrize("name", ["below/weights.csv", "back.csv"])
def test_beside_reads_what_lies_there(at, name):
    count = len(dw.load(at / "w.yaml").floor.storage)
    (at / "below" / "weights.csv").write_text("weight\n" + "2\n" * count)
    assert dw.load(at / "w.yaml", {"tasks.popularity": {"file": name, "column": "weight"}}, files="beside")
    assert dw.load(at / "w.yaml", {"policies.parking": "below/mine.py:Mine"}, files="beside").policies.own()


def test_content_without_a_folder_names_no_file_beside_it(at):
    content = YAML(typ="safe").load((at / "w.yaml").read_text())
    with pytest.raises(dw.ModelError, match="files: none"):
        dw.load(content, {"tasks.popularity": {"file": "w.csv"}}, files="beside")


@pytest.mark.parametrize("key", [key for key in NAMED if not key.startswith("policies")])
def test_no_message_shows_a_line_of_a_file_that_is_no_table(at, key):
    message = refusal(at, {key: NAMED[key]("../secret.csv")})
    assert "secret.csv" in message
    assert "very secret" not in message


def test_another_word_is_refused(at):
    assert "expected one of any, beside or none" in refusal(at, {}, files="all")
