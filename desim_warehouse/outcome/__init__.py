"""Results of a run: the log, how it is read, and how a run is judged by it."""
