"""How far to believe what was found, and what is said of it."""
