"""No robot waits for ever: rings of waiting robots are turned, and two-way lanes have a guard."""
