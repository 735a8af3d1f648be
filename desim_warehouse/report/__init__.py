"""Output for people: figures, reports, the replay page, and files for other programs."""
