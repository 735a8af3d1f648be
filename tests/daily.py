"""Some of many cases run every day, the others in the long run."""

import pytest


def some(cases, every):
    """Mark all cases as proofs but the first of each `every`: where many of a kind are alike one tells the day."""
    return [pytest.param(case, marks=[pytest.mark.long] if rank % every else []) for rank, case in enumerate(cases)]
