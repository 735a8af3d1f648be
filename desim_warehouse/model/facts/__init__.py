"""Facts that follow from a model, for runs, checks and reports alike."""
