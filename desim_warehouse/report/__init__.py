"""What people look at: figures, report notebooks, the replay page, and files for other programs."""
