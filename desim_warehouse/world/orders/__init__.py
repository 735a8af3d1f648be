"""Orders: where tasks come from, and which robot is given which."""
