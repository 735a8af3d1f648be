"""How many are enough: searches of counts, such as those of robots and chargers."""
