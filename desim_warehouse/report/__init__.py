"""Output for people: figures, report notebooks, the replay page, and files for other programs."""
