"""Allocation decided from outside: ask and tell, and a Gymnasium environment."""
