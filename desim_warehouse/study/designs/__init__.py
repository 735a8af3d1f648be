"""Searches over designs: for the best of more than can be raced, and for the value at which a target is missed.

For `desim best`, `desim orient` and `desim plan --uncertain`.

The chosen design is judged on fresh days, which the search did not use, so that its value is not biased by selection.
"""
