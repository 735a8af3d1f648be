"""The questions: each with its public verb, what it returns, and its sentences side by side."""
