"""Search for the best of more designs than can be raced, for `desim best` and `desim orient`.

The chosen design is judged on fresh days, which the search did not use, so that its value is not biased by selection.
"""
