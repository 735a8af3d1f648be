"""Distributions fitted to measured times."""

from __future__ import annotations

from desim_warehouse.study.fit.fitting import Candidate, Fitted, fit, fit_between

__all__ = ["Candidate", "Fitted", "fit", "fit_between"]
