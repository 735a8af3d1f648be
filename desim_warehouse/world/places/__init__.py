"""Places where robots stop: stations, bays and their chargers, and how long things take there."""
