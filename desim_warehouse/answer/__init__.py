"""Answers: their value, their words and numbers, and how the terminal prints them. It knows no study."""
