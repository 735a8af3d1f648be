"""Probable mistakes in a model, seen without a run: the notes and warnings of `desim check`."""
