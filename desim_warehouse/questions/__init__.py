"""The questions: each has its verb, which hands its answer to what it returns, and its sentences beside it."""
