"""Which values of a model file are guesses: those with a mark, until it is taken away or the value is set anew."""

import pytest

from desim_warehouse.draft import Draft, draft
from desim_warehouse.model.guesses import guesses

pytestmark = pytest.mark.usefixtures("brief_probes")

MARKED = """\
# A draft: correct what is marked with (!).
layout:
  edges:
    - {from: A, to: B, speed: 0.2}   # (!) a lift
fleet:
  robot:        # (!) all of it
    speed: 1.5
  size: 3       # not a guess (!)
tasks:
  goods: {poisson: 60}
  load_time: 10 # (!)
  # (!) of a packer,
  # with breaks
  unload_time: 20
"""


def test_a_mark_is_of_the_outermost_key_on_its_line_or_of_the_key_below(tmp_path):
    file = tmp_path / "m.yaml"
    file.write_text(MARKED, encoding="utf-8")
    assert guesses(file) == ("layout.edges.0", "fleet.robot", "tasks.load_time", "tasks.unload_time")


def test_what_is_set_anew_is_no_guess(tmp_path):
    file = tmp_path / "m.yaml"
    file.write_text(MARKED, encoding="utf-8")
    left = guesses(file, ["tasks.load_time", "fleet", "layout.edges.1"])
    assert left == ("layout.edges.0", "tasks.unload_time")


def test_a_draft_says_what_it_guessed(tmp_path):
    file = tmp_path / "w.yaml"
    file.write_text(draft(Draft(size=(16, 14))), encoding="utf-8")
    listed = guesses(file)
    assert {"fleet.robot", "tasks.load_time", "tasks.unload_time", "battery"} <= set(listed)
    file.write_text(file.read_text(encoding="utf-8").replace("# (!)", "# measured:"), encoding="utf-8")
    assert guesses(file) == ()
