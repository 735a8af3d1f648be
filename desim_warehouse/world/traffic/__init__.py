"""Movement on the Highways: lanes, intersections, right of way, closures and people."""
