"""Robots: their life, their tasks, their batteries."""
