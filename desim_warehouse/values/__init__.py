"""Values of model files: quantities with units, calendars, distributions, and random numbers by purpose."""
