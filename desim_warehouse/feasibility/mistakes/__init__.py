"""What is probably a mistake in a model, seen without a run: what check notes and warns of."""
