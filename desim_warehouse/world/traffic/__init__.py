"""Highways and who is on them: lanes, intersections, right of way, closures and people."""
