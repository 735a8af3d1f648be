"""The questions: what a search has found, in words. They stand above all searches, and know how each is said."""

from desim_warehouse.questions import (
    best_words,
    direction_words,
    fleet_words,
    option_words,
    race_words,
    size_words,
    study_words,
    tipping,
    why_words,
)

__all__ = [
    "best_words",
    "direction_words",
    "fleet_words",
    "option_words",
    "race_words",
    "size_words",
    "study_words",
    "tipping",
    "why_words",
]
