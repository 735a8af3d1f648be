"""The questions: each has its verb, which hands its answer to what it returns, and its sentences beside it."""

from desim_warehouse.questions import study_words, tipping_words

__all__ = ["study_words", "tipping_words"]
