"""Appearance of pages: colours, templates, and assembly into a single file."""
