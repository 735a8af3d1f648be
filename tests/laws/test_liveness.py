"""Whatever the layout and however many robots: work ends, and nothing impossible happens on the way."""

from __future__ import annotations

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import desim_warehouse as dw
from tests.auditor import audit
from tests.laws.worlds import models

relaxed = settings(
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
)


@given(models(), st.integers(0, 3))
@relaxed
def test_every_task_ends_and_the_log_is_sound(mapping, seed):
    model = dw.load(mapping)
    run = dw.simulate(model, seed)
    assert run.kpis["tasks"] == len(model.tasks.goods)
    assert audit(run) == []
