"""What a model can say of policies is tried with invented ones: their names and parameters are not asked about here."""

import pytest


@pytest.fixture(scope="module", autouse=True)
def _any_policy():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("desim_warehouse.policies.catalogue.problems", lambda *_: [])
        yield
