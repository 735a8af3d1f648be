"""What comes out of a run: the log, what is read from it, and what is judged by it."""
