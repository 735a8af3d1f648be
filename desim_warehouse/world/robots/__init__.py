"""What a robot does all day: its life, its tasks, its battery."""
