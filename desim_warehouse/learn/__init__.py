"""Allocation decisions from outside the simulation: ask and tell, and a Gymnasium environment."""
