"""Search of the best design where there are too many to race, for `desim best` and `desim orient`.

The design that the search chooses is judged on fresh days, on which the search did not choose it.
"""
