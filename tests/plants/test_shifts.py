"""Plants of others drive a shift of 8 h with 4, 8 and 20 vehicles; every task is delivered, or open at the end."""

from pathlib import Path

import pytest

import desim_warehouse as dw
from desim_warehouse.errors import ModelError
from tests.auditor import audit
from tests.plants.foreign import FOLDER, needs_plants, with_enough_chargers

HOUR = 3600.0
FILES = sorted(
    path
    for kind in ("opentcs*/**/*.xml", "rmf/**/*.building.yaml")
    for path in (Path(FOLDER).glob(kind) if FOLDER else ())
)


@needs_plants
@pytest.mark.long
@pytest.mark.parametrize("robots", [4, 8, 20])
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_every_task_of_a_shift_is_delivered_or_open(file, robots):
    """An hour is audited, too: nobody overtakes, jumps, or meets another head-on."""
    try:
        model = dw.read_layout(file, robots=robots)
    except ModelError as error:
        pytest.skip(str(error).splitlines()[0])
    if model.run.length is None:
        pytest.skip("its orders end")
    model = with_enough_chargers(model)
    run = dw.simulate(model.replace({"run.length": 8 * HOUR, "log": "tasks"}))
    assert run.T == 8 * HOUR
    released, delivered = (len(list(run.history.rows(kind))) for kind in ("released", "delivered"))
    assert delivered > 0
    assert released - delivered == run.kpis["backlog"]
    assert audit(dw.simulate(model.replace({"run.length": HOUR}))) == []
