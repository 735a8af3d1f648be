"""What follows from a model, for runs, checks and reports alike."""
