"""Orders: the sources of tasks, and their assignment to robots."""
