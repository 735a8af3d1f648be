"""Answers as values, with their words and numbers, and their forms as text and page; independent of studies."""
