"""Quantiles of Student's t."""

from __future__ import annotations


def t_quantile(df: int, probability: float) -> float:
    """The `probability` quantile of Student's t with `df` degrees of freedom (scipy.special: loads fast)."""
    from scipy.special import stdtrit

    return float(stdtrit(df, probability))
